// The whole path with a camera that first moves and then rests, as the demo films: real colmap, no shared
// captures.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"

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
                                        project.string(), "--steps", "300", "--lens", "40", "--json"});
  ASSERT_EQ(built.exit_code, 0) << built.err;

  std::ifstream file(project / "cameras.json");
  const json cameras = json::parse(file);
  EXPECT_FALSE(cameras.at("static").get<bool>());
  EXPECT_NE(built.out.find("--lens is not used"), std::string::npos) << built.out;
  // 35 % of the frames film with a moving camera; nearly all of those must be found.
  const auto moving = std::ranges::count_if(
      cameras.at("cameras"), [](const json& camera) { return camera.at("frame").get<int>() < 42; });
  EXPECT_GE(moving, 36);

  const ProgramResult evaluated = likeness({"eval", project.string(), "--json"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const json report = json::parse(evaluated.out);
  EXPECT_EQ(report.at("frames_test"), 12);
  // A person painted as one mean colour scores about 14 dB, the whole picture before a blurred plate 24.
  EXPECT_GT(report.at("psnr_person_db").get<double>(), 26);
  EXPECT_GT(report.at("psnr_db").get<double>(), 30);

  // The plate that the rest sees, completed by the room that the walk saw, tells person from background.
  const ProgramResult compared = likeness(
      {"study", "truth", (folder / "demo").string(), project.string(), "--tables", "mattes", "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  const json rows = json::parse(compared.out).at("mattes");
  ASSERT_EQ(rows.size(), 3u);
  for (const json& row : rows)
    EXPECT_GT(row.at("iou_mean").get<double>(), row.at("part") == "camera moves" ? 0.95 : 0.97) << row.dump();
  std::ifstream plate(project / "plate.json");
  EXPECT_GT(json::parse(plate).at("coverage").get<double>(), 0.55);
  fs::remove_all(folder);
}

TEST(MovingDemo, CamerasAreFoundWhileTheHeadMovesAndWorseWithoutItsMask) {
  std::string name = (fs::temp_directory_path() / "likeness_restless_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path folder = name;
  const ProgramResult demo = likeness({"demo", (folder / "demo").string(), "--frames", "60", "--moving-share",
                                       "0.9", "--samples", "2", "--restless-head"});
  ASSERT_EQ(demo.exit_code, 0) << demo.err;
  const ProgramResult study =
      likeness({"study", "cameras", (folder / "demo").string(), "--masks", "person", "none", "--json"});
  fs::remove_all(folder);
  ASSERT_EQ(study.exit_code, 0) << study.err;
  const json rows = json::parse(study.out).at("cameras");
  ASSERT_EQ(rows.size(), 2u);
  ASSERT_TRUE(rows[0].at("turn_median_deg").is_number()) << rows[0].dump(2);
  EXPECT_GE(rows[0].at("found").get<int>(), rows[0].at("wanted").get<int>() * 9 / 10);
  EXPECT_LE(rows[0].at("position_median_percent").get<double>(), 1.0);
  // What the cameras' turns have in common is the principal point's doing, which so short a path leaves open.
  EXPECT_LE(rows[0].at("own_turn_median_deg").get<double>(), 0.7);
  if (rows[1].at("own_turn_median_deg").is_number()) {
    EXPECT_GT(rows[1].at("own_turn_median_deg").get<double>(),
              rows[0].at("own_turn_median_deg").get<double>());
  }
}

}  // namespace
}  // namespace likeness::test
