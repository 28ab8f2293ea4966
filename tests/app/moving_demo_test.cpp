// The whole path with a camera that first moves and then rests, as the demo films: real colmap, no shared
// captures.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST(MovingDemo, IsSolvedTrainedAndMeasured) {
  std::string name = (fs::temp_directory_path() / "likeness_moving_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path folder = name, project = folder / "p.likeness";
  const ProgramResult demo =
      likeness({"demo", (folder / "demo").string(), "--size", "384", "--frames", "120", "--samples", "1"});
  ASSERT_EQ(demo.exit_code, 0) << demo.err;
  const ProgramResult built = likeness({"build", (folder / "demo" / "demo.mp4").string(), "--project",
                                        project.string(), "--steps", "300", "--json"});
  ASSERT_EQ(built.exit_code, 0) << built.err;

  std::ifstream file(project / "cameras.json");
  const json cameras = json::parse(file);
  EXPECT_FALSE(cameras.at("static").get<bool>());
  // 35 % of the frames film with a moving camera; nearly all of those must be found.
  const auto moving = std::ranges::count_if(
      cameras.at("cameras"), [](const json& camera) { return camera.at("frame").get<int>() < 42; });
  EXPECT_GE(moving, 36);

  const ProgramResult evaluated = likeness({"eval", project.string(), "--json"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const json report = json::parse(evaluated.out);
  EXPECT_EQ(report.at("frames_test"), 12);
  // A person painted as one mean colour scores about 14 dB.
  EXPECT_GT(report.at("psnr_person_db").get<double>(), 20);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace likeness::test
