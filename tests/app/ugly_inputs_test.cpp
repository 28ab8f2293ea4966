// The table of odd inputs, each imported as a user would; and each clock replayed by an avatar.
#include "tests/app/ugly_inputs.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "core/capture/capture.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

// The words of recipes. Older programs take a turn as metadata, newer ones by an option.
constexpr const char* kWords =
    "ff() { ffmpeg -nostdin -v error -y \"$@\"; }; "
    "turn() { ff -display_rotation $1 -i $2 -c copy \"$3\" 2> /dev/null || "
    "ff -i $2 -c copy -metadata:s:v:0 rotate=$1 \"$3\"; }; ";

class UglyInputs : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (run_program({"ffmpeg", "-version"}).exit_code != 0) return;
    std::string name = (fs::temp_directory_path() / "likeness_ugly_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    const ProgramResult demo =
        likeness({"demo", (folder_ / "demo").string(), "--size", "160", "--frames",
                  std::to_string(kGoodFrames), "--moving-share", "0", "--samples", "1"});
    ASSERT_EQ(demo.exit_code, 0) << demo.err;
    const ProgramResult sounded = run_program(
        {"ffmpeg", "-v", "error", "-i", (folder_ / "demo" / "demo.mp4").string(), "-f", "lavfi", "-i", "sine",
         "-map", "0:v", "-map", "1:a", "-c:v", "copy", "-c:a", "aac", "-shortest", good().string()});
    ASSERT_EQ(sounded.exit_code, 0) << sounded.err;
  }
  static void TearDownTestSuite() {
    if (!folder_.empty()) fs::remove_all(folder_);
  }
  void SetUp() override {
    if (folder_.empty()) GTEST_SKIP() << "ffmpeg is not installed";
  }
  static fs::path good() { return folder_ / "good.mp4"; }

  // Makes the input in a folder of its own.
  static fs::path made(const UglyInput& input) {
    const fs::path work = folder_ / "made";
    fs::remove_all(work), fs::create_directories(work);
    const fs::path file = work / std::string(input.file);
    const ProgramResult run =
        run_program({"env", "CLIP=" + good().string(), "OUT=" + file.string(), "sh", "-euc",
                     std::string(kWords) + "cd \"" + work.string() + "\"; " + std::string(input.recipe)});
    EXPECT_EQ(run.exit_code, 0) << "the recipe: " << run.err;
    return file;
  }

  // What is true of every end: a film becomes a project, or is refused with a sentence and leaves none.
  static void check(const UglyInput& input) {
    SCOPED_TRACE(std::string(input.file));
    const fs::path file = made(input), project = folder_ / "made" / "p.likeness";
    const ProgramResult run =
        likeness({"import", file.string(), "--project", project.string(), "--size", "256"});
    EXPECT_NE(run.err.find(input.says), std::string::npos) << run.err;
    EXPECT_EQ(run.err.find("unexpected"), std::string::npos) << run.err;
    if (input.frames == 0 || run.exit_code != 0) {
      EXPECT_EQ(run.exit_code, 1) << run.out << run.err;
      EXPECT_LE(input.frames, 0) << run.err;
      EXPECT_GE(run.err.size(), 20u) << run.err;
      EXPECT_FALSE(fs::exists(project / "capture.json"));
      return;
    }
    const auto capture = read_capture(project / "capture.json");
    ASSERT_TRUE(capture.ok()) << capture.error().what;
    if (input.frames > 0) {
      EXPECT_EQ(int(capture->frames.size()), input.frames) << run.err;
    }
    if (input.last_s >= 0) {
      EXPECT_NEAR(capture->frames.back().time_s, input.last_s, 0.02);
    }
    for (std::size_t i = 1; i < capture->frames.size(); ++i)
      EXPECT_GT(capture->frames[i].time_s, capture->frames[i - 1].time_s) << "frame " << i;
  }

  static inline fs::path folder_;
};

TEST_F(UglyInputs, ADozenComeToWhatTheyShould) {
  for (const UglyInput& input : ugly_inputs())
    if (input.by_default) check(input);
}

class UglyInputsAll : public UglyInputs {};

TEST_F(UglyInputsAll, EachComesToWhatItShould) {
  for (const UglyInput& input : ugly_inputs())
    if (!input.by_default) check(input);
}

}  // namespace
}  // namespace likeness::test
