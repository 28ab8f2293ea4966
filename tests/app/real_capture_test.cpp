// The whole path on a real clip; skipped where the shared captures are absent.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"

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

// Frames of the clip and what was seen in them; tests/core/lab/truth/marks.
TEST(RealCapture, MouthAndEyesAreAsMarkedByHand) {
  const fs::path shared = LIKENESS_SHARED;
  const fs::path model = shared / "head_models" / "ict_head_flame_schema.npz";
  for (const std::string name : {"wojtek", "duda"}) {
    const fs::path clip = shared / "captures" / (name + ".mp4");
    if (!fs::exists(clip) || !fs::exists(model)) GTEST_SKIP() << "the real captures are not here: " << shared;
    const ProgramResult studied = likeness(
        {"study", "track", clip.string(), "--steps", "photometric", "--head-model", model.string(), "--marks",
         std::string(LIKENESS_SOURCE "/tests/core/lab/truth/marks/") + name + ".json", "--json"});
    ASSERT_EQ(studied.exit_code, 0) << studied.err;
    const auto row = nlohmann::json::parse(studied.out).at("marks").at(0);
    const int mouths = row.at("marked_mouths"), eyes = row.at("marked_eyes");
    EXPECT_GE(mouths, 80);
    EXPECT_GE(eyes, 90);
    EXPECT_LE(row.at("wrong_mouths").size(), mouths / 20u) << name << ": " << row;
    EXPECT_LE(row.at("wrong_eyes").size(), eyes / 20u) << name << ": " << row;
  }
}

}  // namespace
}  // namespace likeness::test
