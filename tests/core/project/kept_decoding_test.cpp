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

constexpr int kDemoFrames = 36;

// The stages are run as seldom as the claims allow: a fit takes its time.
class SharedDecoding : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (std::filesystem::temp_directory_path() / "likeness_shared_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    DemoOptions demo;
    demo.width = demo.height = 320;
    demo.frames = kDemoFrames;
    demo.moving_share = 0;
    demo.samples_per_pixel = 1;
    ASSERT_TRUE(write_demo_capture(root_, demo, Progress(), {}).ok());
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(root_); }
  void SetUp() override {
    if (auto detector = FaceDetector::load(); !detector) GTEST_SKIP() << detector.error().what;
  }

  static Project open(const char* name, int size = 256) {
    ProjectOptions options;
    options.shared.video = root_ / "demo.mp4";
    options.import.size = size;
    auto project = open_or_create_project(root_ / name, options);
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
  static std::string text(const std::filesystem::path& path) { return read_text(path).value(); }
  static bool holds(const Project& project, const char* name) {
    return path_exists(decoded_path(project) / name);
  }
  static std::filesystem::path root_;
};
std::filesystem::path SharedDecoding::root_;

TEST_F(SharedDecoding, AClipIsDecodedOnceAndARunWithoutWhatWasKeptFindsTheSame) {
  Project project = open("once");
  EXPECT_EQ(run(project, Stage::fit), kDemoFrames);
  // The large files are gone with the stages that needed them.
  EXPECT_TRUE(holds(project, "motion.json"));
  EXPECT_FALSE(holds(project, "track.greys"));
  EXPECT_FALSE(holds(project, "landmarks.json"));

  const std::string capture = text(capture_path(project)), cameras = text(cameras_path(project)),
                    track = text(track_path(project));
  // An import that changes nothing keeps nothing for a fit that is current.
  std::filesystem::remove_all(project.folder / "frames");
  EXPECT_EQ(run(project, Stage::fit), kDemoFrames);
  EXPECT_EQ(text(capture_path(project)), capture);
  EXPECT_FALSE(holds(project, "track.greys"));
  // Align and fit by themselves.
  std::filesystem::remove_all(decoded_path(project));
  std::filesystem::remove(cameras_path(project));
  EXPECT_EQ(run(project, Stage::align), kDemoFrames);
  EXPECT_EQ(text(cameras_path(project)), cameras);
  std::filesystem::remove(track_path(project));
  EXPECT_EQ(run(project, Stage::fit), kDemoFrames);
  EXPECT_EQ(text(track_path(project)), track);
}

TEST_F(SharedDecoding, StagesRunOneByOneDecodeOnlyInTheFirst) {
  Project project = open("apart");
  EXPECT_EQ(run(project, Stage::import), kDemoFrames);
  EXPECT_TRUE(holds(project, "motion.json"));
  EXPECT_TRUE(holds(project, "track.greys"));
  EXPECT_EQ(run(project, Stage::align), 0);
  // In another size: the cameras stand, and their motion is not measured again.
  const std::string motion = text(decoded_path(project) / "motion.json");
  project = open("apart", 512);
  EXPECT_EQ(run(project, Stage::import), kDemoFrames);
  EXPECT_EQ(text(decoded_path(project) / "motion.json"), motion);
  EXPECT_TRUE(holds(project, "track.greys"));
}

TEST_F(SharedDecoding, AStopInTheMiddleOfAnImportLosesNothing) {
  Project whole = open("whole");
  run(whole, Stage::import);
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
    EXPECT_EQ(run(project, Stage::import), kDemoFrames);
    EXPECT_EQ(text(capture_path(project)), text(capture_path(whole)));
    for (const char* name : {"motion.json", "landmarks.json", "track.greys"})
      EXPECT_EQ(text(decoded_path(project) / name), text(decoded_path(whole) / name)) << name;
  }
}

}  // namespace
}  // namespace likeness
