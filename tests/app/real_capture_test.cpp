// The whole path on a real clip; skipped where the shared captures are absent.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <nlohmann/json.hpp>

#include "tests/app/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

TEST(RealCapture, AShortBuildOfARealFaceBeatsThePlateByFar) {
  const fs::path shared = LIKENESS_SHARED;
  const fs::path clip = shared / "captures" / "wojtek.mp4",
                 model = shared / "head_models" / "ict_head_flame_schema.npz";
  if (!fs::exists(clip) || !fs::exists(model)) GTEST_SKIP() << "the real captures are not here: " << shared;
  std::string name = (fs::temp_directory_path() / "likeness_real_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path folder = name;
  // The first five seconds: enough to show that tracking and training work on a real face.
  const ProgramResult cut = run_program({"ffmpeg", "-v", "error", "-i", clip.string(), "-frames:v", "120",
                                         "-c:v", "libx264", "-crf", "12", (folder / "clip.mp4").string()});
  ASSERT_EQ(cut.exit_code, 0) << cut.err;
  const ProgramResult built =
      likeness({"build", (folder / "clip.mp4").string(), "--project", (folder / "p").string(), "--head-model",
                model.string(), "--steps", "300", "--json"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const ProgramResult evaluated = likeness({"eval", (folder / "p").string(), "--json"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const auto report = nlohmann::json::parse(evaluated.out);
  EXPECT_EQ(report.at("frames_test"), 12);
  EXPECT_GT(report.at("psnr_db").get<double>(), 24);
  EXPECT_GT(report.at("psnr_head_db").get<double>(), 21);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace likeness::test
