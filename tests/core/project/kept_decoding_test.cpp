// Claims about import, align and fit sharing one decoding: how often a clip is decoded, and that the results
// are the same bits however the stages were run.
#include "core/project/kept_decoding.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"
#include "core/face/landmarks.h"
#include "core/project/run_stages.h"
#include "core/synth/demo_capture.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

constexpr int kDemoFrames = 40;

class SharedDecoding : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (std::filesystem::temp_directory_path() / "likeness_shared_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) return;
    root_ = name;
    DemoOptions demo;
    demo.width = demo.height = 320;
    demo.frames = kDemoFrames;
    demo.moving_share = 0;
    demo.samples_per_pixel = 1;
    EXPECT_TRUE(write_demo_capture(root_, demo, Progress(), {}).ok());
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(root_); }
  void SetUp() override {
    if (auto detector = FaceDetector::load(); !detector) GTEST_SKIP() << detector.error().what;
  }

  static Project open(const char* name, int size = 256) {
    auto project = open_or_create_project(root_ / name, {.video = root_ / "demo.mp4", .size = size});
    EXPECT_TRUE(project.ok());
    return *project;
  }
  // Frames decoded meanwhile.
  static std::int64_t run(Project& project, Stage last) {
    const std::int64_t before = decoded_frames();
    const auto done = run_stages(project, last, Progress(), {}, {});
    EXPECT_TRUE(done.ok()) << done.error().what;
    return decoded_frames() - before;
  }
  // What the stages wrote, to the bit.
  static std::string results(const Project& project) {
    std::string all;
    for (const auto& path : {capture_path(project), cameras_path(project), track_path(project)})
      all += read_text(path).value() + "\n";
    return all;
  }
  static bool holds(const Project& project, const char* name) {
    return path_exists(decoded_path(project) / name);
  }
  static std::filesystem::path root_;
};
std::filesystem::path SharedDecoding::root_;

TEST_F(SharedDecoding, AClipIsDecodedOnceByImportAlignAndFit) {
  Project project = open("once");
  EXPECT_EQ(run(project, Stage::fit), kDemoFrames);
  // The large files are gone with the stages that needed them.
  EXPECT_TRUE(holds(project, "motion.json"));
  EXPECT_FALSE(holds(project, "track.greys"));
  EXPECT_FALSE(holds(project, "landmarks.json"));
}

TEST_F(SharedDecoding, StagesRunOneByOneOrWithoutWhatWasKeptFindTheSame) {
  Project together = open("together");
  run(together, Stage::fit);

  Project apart = open("apart");
  EXPECT_EQ(run(apart, Stage::import), kDemoFrames);
  EXPECT_TRUE(holds(apart, "motion.json"));
  EXPECT_TRUE(holds(apart, "track.greys"));
  EXPECT_EQ(run(apart, Stage::align), 0);
  EXPECT_EQ(run(apart, Stage::fit), 0);
  EXPECT_EQ(results(apart), results(together));

  Project without = open("without");
  run(without, Stage::import);
  std::filesystem::remove_all(decoded_path(without));
  EXPECT_EQ(run(without, Stage::align), kDemoFrames);
  EXPECT_EQ(run(without, Stage::fit), kDemoFrames);
  EXPECT_EQ(results(without), results(together));
}

TEST_F(SharedDecoding, AFitRunAgainDecodesForItself) {
  Project project = open("again");
  run(project, Stage::fit);
  const std::string before = results(project);
  std::filesystem::remove(track_path(project));
  EXPECT_EQ(run(project, Stage::fit), kDemoFrames);
  EXPECT_EQ(results(project), before);
}

TEST_F(SharedDecoding, AnImportInAnotherSizeKeepsTheCamerasAndTheirMotion) {
  Project project = open("resized");
  run(project, Stage::fit);
  project = open("resized", 512);
  EXPECT_EQ(run(project, Stage::import), kDemoFrames);
  EXPECT_TRUE(holds(project, "motion.json"));
  EXPECT_TRUE(holds(project, "track.greys"));
  EXPECT_EQ(run(project, Stage::fit), 0);
}

TEST_F(SharedDecoding, AnImportThatChangesNothingKeepsNothingForTheFit) {
  Project project = open("unchanged");
  run(project, Stage::fit);
  std::filesystem::remove_all(project.folder / "frames");
  EXPECT_EQ(run(project, Stage::fit), kDemoFrames);
  EXPECT_FALSE(holds(project, "track.greys"));
}

TEST_F(SharedDecoding, AStopInTheMiddleOfAnImportLosesNothing) {
  Project whole = open("whole");
  run(whole, Stage::fit);
  for (const double moment : {0.3, 0.9}) {
    Project project = open(moment < 0.5 ? "cut_early" : "cut_late");
    std::stop_source stop;
    const Progress progress([&](const ProgressReport& r) {
      if (r.fraction > moment) stop.request_stop();
    });
    const auto cut = run_stages(project, Stage::import, progress, {}, stop.get_token());
    ASSERT_FALSE(cut.ok());
    EXPECT_EQ(cut.error().code, ErrorCode::cancelled);
    EXPECT_FALSE(path_exists(decoded_path(project)));
    for (const auto& entry : std::filesystem::directory_iterator(project.folder))
      EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path();
    EXPECT_EQ(run(project, Stage::fit), kDemoFrames);
    EXPECT_EQ(results(project), results(whole));
  }
}

}  // namespace
}  // namespace likeness
