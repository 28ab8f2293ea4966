// Claims about import, align and fit sharing one decoding: how often a clip is decoded, and that the results
// are the same bits however the stages were run. That a fit without what was kept ends in the same track is
// among the claims of tests/app/end_to_end_test.cpp.
#include "core/project/kept_decoding.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <map>
#include <string>

#include "core/base/files.h"
#include "core/camera/kept_path.h"
#include "core/capture/hold_out.h"
#include "core/face/landmarks.h"
#include "core/matte/coarse_mask.h"
#include "core/project/run_stages.h"
#include "core/scene/track.h"
#include "core/synth/demo_capture.h"
#include "core/video/decode.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kClipFrames = 30;  // as few as an import takes
constexpr int kClipSide = 160, kStillSide = 192;
constexpr int kMovingFrames = 18;  // of the clip in which the camera moves first
constexpr const char* kKeptFiles[] = {"motion.json", "landmarks.json", "track.greys"};

// While it lives, no file grows beyond two megabytes: as if the disk were full after the first of the
// pictures for the fit, which together take eight.
class FullDisk {
 public:
  FullDisk() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{2'000'000, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

// Two clips show one picture of the demo, which is rendered and tracked in a fraction of the time that a
// performance takes; the stages run as seldom as the claims allow. `whole` is fitted once, and only read.
class SharedDecoding : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_shared_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    if (!FaceDetector::load()) return;  // the tests are skipped
    DemoOptions demo;
    demo.width = demo.height = kStillSide;
    demo.frames = 8;
    demo.moving_share = 0;
    demo.samples_per_pixel = 1;
    ASSERT_TRUE(write_demo_capture(root_, demo, Progress(), {}).ok());
    auto reader = VideoReader::open(root_ / "demo.mp4");
    ASSERT_TRUE(reader.ok());
    const auto still = reader->next();
    ASSERT_TRUE(still.ok() && still->has_value());
    constexpr int kMargin = kStillSide - kClipSide;
    write_clip("rests.mp4", (*still)->rgb, [](int) { return kMargin / 2; });
    write_clip("moves.mp4", (*still)->rgb,
               [](int frame) { return std::min(frame, kMovingFrames) * kMargin / kMovingFrames; });
    make_whole();
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }
  void SetUp() override {
    if (auto detector = FaceDetector::load(); !detector) GTEST_SKIP() << detector.error().what;
  }

  // left: where in the still picture a frame begins. A square in the corner tells the frames apart.
  static void write_clip(const char* name, const Image8& still, const std::function<int(int)>& left,
                         int frames = kClipFrames) {
    constexpr int kSquare = 8;
    auto writer =
        VideoWriter::create(root_ / name, kClipSide, kClipSide, {.frames_per_second = 10, .crf = 12});
    ASSERT_TRUE(writer.ok());
    for (int f = 0; f < frames; ++f) {
      Image8 frame = crop(still, left(f), (kStillSide - kClipSide) / 2, kClipSide, kClipSide);
      for (int y = 0; y < kSquare; ++y)
        std::fill_n(frame.at(0, y), 3 * kSquare, std::uint8_t(40 + 6 * f % 180));
      ASSERT_TRUE(writer->add(frame).ok());
    }
    ASSERT_TRUE(writer->finish().ok());
  }
  static void make_whole() {
    Project project = open("whole");
    const std::int64_t before = decoded_frames();
    RunObserver observer;
    observer.stage_changed = [&](Stage stage, const StageRecord& record) {
      if (record.state != StageState::done) return;
      decoded_until_[stage] = decoded_frames() - before;
      if (stage != Stage::import) return;
      for (const char* file : kKeptFiles) kept_[file] = text(decoded_path(project) / file);
    };
    const auto done = run_stages(project, Stage::fit, Progress(), observer, {});
    ASSERT_TRUE(done.ok()) << done.error().what;
  }

  static Project open(const char* name, int size = 256, const char* clip = "rests.mp4",
                      Split split = Split::tail) {
    ProjectOptions options;
    options.shared.video = root_ / clip;
    options.import.size = size;
    options.import.split = split;
    auto project = open_or_create_project(root_ / name, options);
    EXPECT_TRUE(project.ok());
    return *project;
  }
  static Project copy_of_whole(const char* name, int size = 256) {
    fs::copy(root_ / "whole", root_ / name, fs::copy_options::recursive);
    return open(name, size);
  }
  // Frames decoded meanwhile.
  static std::int64_t run(Project& project, Stage last) {
    const std::int64_t before = decoded_frames();
    const auto done = run_stages(project, last, Progress(), {}, {});
    EXPECT_TRUE(done.ok()) << done.error().what;
    return decoded_frames() - before;
  }
  static std::string text(const fs::path& path) {
    const auto read = read_text(path);
    return read ? *read : "missing: " + path.string();
  }
  static bool holds(const Project& project, const char* name) {
    return path_exists(decoded_path(project) / name);
  }
  static void expect_nothing_half_written(const Project& project) {
    for (const auto& entry : fs::recursive_directory_iterator(project.folder))
      EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path();
  }

  static inline fs::path root_;
  static inline std::map<Stage, std::int64_t> decoded_until_;  // the end of a stage of the one run
  static inline std::map<std::string, std::string> kept_;      // of kKeptFiles, by its import
};

TEST_F(SharedDecoding, AClipIsDecodedOnceForImportAlignAndFit) {
  const Project whole = open("whole");
  for (const Stage stage : {Stage::import, Stage::align, Stage::fit})
    EXPECT_EQ(decoded_until_[stage], kClipFrames) << stage_name(stage);
  // The large files are gone with the stages that needed them.
  EXPECT_EQ(text(decoded_path(whole) / "motion.json"), kept_["motion.json"]);
  EXPECT_FALSE(holds(whole, "track.greys"));
  EXPECT_FALSE(holds(whole, "landmarks.json"));
}

// Of a longer film; what is not asked for is neither tracked nor pictured.
TEST_F(SharedDecoding, OfSomeSecondsOfAFilmNothingElseIsInAnyResult) {
  constexpr int kAround = 12;
  const auto still = VideoReader::open(root_ / "demo.mp4")->next();
  ASSERT_TRUE(still.ok() && still->has_value());
  write_clip(
      "long.mp4", (*still)->rgb, [](int) { return (kStillSide - kClipSide) / 2; }, kClipFrames + 2 * kAround);
  Project project = open("seconds", 256, "long.mp4");
  project.options.import.seconds = {kAround / 10.0, (kAround + kClipFrames) / 10.0};
  ASSERT_TRUE(save_project(project).ok());
  run(project, Stage::fit);
  const auto capture = read_capture(capture_path(project));
  const auto track = read_track(track_path(project));
  ASSERT_TRUE(capture.ok() && track.ok());
  EXPECT_EQ(capture->seconds, project.options.import.seconds);
  ASSERT_EQ(capture->frames.size(), std::size_t(kClipFrames));
  ASSERT_EQ(track->frames.size(), std::size_t(kClipFrames));
  for (int i = 0; i < kClipFrames; ++i) {
    EXPECT_EQ(capture->frames[std::size_t(i)].frame, kAround + i);
    EXPECT_EQ(track->frames[std::size_t(i)].frame, kAround + i);
  }
  const auto cameras = read_cameras(cameras_path(project));
  ASSERT_TRUE(cameras.ok());
  EXPECT_NEAR(cameras->shots.at(0).from_s, kAround / 10.0, 1e-6);
  // Read, not taken over from what import kept, it is the same.
  const std::string tracked = text(track_path(project));
  fs::remove_all(decoded_path(project));
  fs::remove(track_path(project));
  run(project, Stage::fit);
  EXPECT_EQ(text(track_path(project)), tracked);
}

TEST_F(SharedDecoding, WhatNobodyNeedsIsNotKeptAndAlignAloneFindsTheSame) {
  Project project = copy_of_whole("again");
  const std::string capture = text(capture_path(project)), cameras = text(cameras_path(project));
  // An import that changes nothing keeps nothing for a fit that is current.
  fs::remove_all(project.folder / "frames");
  EXPECT_EQ(run(project, Stage::fit), kClipFrames);
  EXPECT_EQ(text(capture_path(project)), capture);
  EXPECT_FALSE(holds(project, "track.greys"));
  fs::remove_all(decoded_path(project));
  fs::remove(cameras_path(project));
  EXPECT_EQ(run(project, Stage::align), kClipFrames);
  EXPECT_EQ(text(cameras_path(project)), cameras);
}

TEST_F(SharedDecoding, InAnotherSizeTheCamerasStandAndTheirMotionIsNotMeasuredAgain) {
  Project project = copy_of_whole("another_size", 512);
  EXPECT_EQ(run(project, Stage::import), kClipFrames);
  EXPECT_EQ(text(decoded_path(project) / "motion.json"), kept_["motion.json"]);
  EXPECT_TRUE(holds(project, "track.greys"));
}

TEST_F(SharedDecoding, AStopInTheMiddleOfAnImportLosesNothing) {
  Project project = open("cut");
  for (const double moment : {0.3, 0.9}) {
    std::stop_source stop;
    const Progress progress([&](const ProgressReport& r) {
      if (r.fraction > moment) stop.request_stop();
    });
    const auto cut = run_stages(project, Stage::import, progress, {}, stop.get_token());
    ASSERT_FALSE(cut.ok());
    EXPECT_EQ(cut.error().code, ErrorCode::cancelled);
    for (const char* name : kKeptFiles) EXPECT_FALSE(path_exists(decoded_path(project) / name)) << name;
    expect_nothing_half_written(project);
  }
  EXPECT_EQ(run(project, Stage::import), kClipFrames);
  EXPECT_EQ(text(capture_path(project)), text(capture_path(open("whole"))));
  for (const char* name : kKeptFiles) EXPECT_EQ(text(decoded_path(project) / name), kept_[name]) << name;
  // The stages run one by one: only the first decodes.
  EXPECT_EQ(run(project, Stage::align), 0);
}

TEST_F(SharedDecoding, AFullDiskEndsNoImportAndTheFitDecodesByItself) {
  Project project = open("full");
  {
    const FullDisk full;
    EXPECT_EQ(run(project, Stage::import), kClipFrames);
  }
  EXPECT_EQ(text(capture_path(project)), text(capture_path(open("whole"))));
  expect_nothing_half_written(project);
  EXPECT_FALSE(holds(project, "track.greys"));
  EXPECT_FALSE(holds(project, "landmarks.json"));
  // What there was room for is used all the same.
  EXPECT_EQ(text(decoded_path(project) / "motion.json"), kept_["motion.json"]);
  EXPECT_EQ(run(project, Stage::align), 0);
  // Only until the clip is read: what follows takes long, and is another's claim.
  std::stop_source stop;
  const std::int64_t before = decoded_frames();
  const Progress progress([&](const ProgressReport&) {
    if (decoded_frames() - before >= kClipFrames) stop.request_stop();
  });
  const auto fitted = run_stages(project, Stage::fit, progress, {}, stop.get_token());
  ASSERT_FALSE(fitted.ok());
  EXPECT_EQ(fitted.error().code, ErrorCode::cancelled) << fitted.error().what;
  EXPECT_EQ(decoded_frames() - before, kClipFrames);
}

TEST_F(SharedDecoding, HeldOutViewsAreThoseOfTheMotionThatTheSameDecodingShows) {
  Project project = open("views", 256, "moves.mp4", Split::views);
  EXPECT_EQ(run(project, Stage::import), kClipFrames);
  // Measured alone, by a decoding of its own.
  const fs::path clip = root_ / "moves.mp4";
  AlignOptions align;
  align.mask_inputs = mask_inputs({});
  const auto person = coarse_person_mask();
  ASSERT_TRUE(person.ok());
  const auto motion = measure_background_motion(clip, *person, rest_limit(align), Progress(), {});
  ASSERT_TRUE(motion.ok()) << motion.error().what;
  const auto stretch = moving_stretch(*motion);
  ASSERT_TRUE(stretch.has_value());
  EXPECT_LT(stretch->last, kClipFrames - 1) << "the camera rests in the end";
  const auto capture = read_capture(capture_path(project));
  ASSERT_TRUE(capture.ok());
  std::vector<CaptureFrame> expected = capture->frames;
  hold_out_views(expected, {stretch->first, stretch->last}, ImportOptions{}.held_out_share);
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(capture->frames[i].held_out, expected[i].held_out) << expected[i].frame;
  // Align finds that motion, to the bit, ...
  ASSERT_TRUE(make_writable_folder(root_ / "measured").ok());
  ASSERT_TRUE(keep_motion(root_ / "measured", motion_inputs(*hash_video(clip), align), *motion).ok());
  const std::string kept = text(decoded_path(project) / "motion.json");
  EXPECT_EQ(kept, text(root_ / "measured" / "motion.json"));
  // ... and so does a later import, which holds out the same.
  const std::string before = text(capture_path(project));
  fs::remove_all(project.folder / "frames");
  EXPECT_EQ(run(project, Stage::import), kClipFrames);
  EXPECT_EQ(text(capture_path(project)), before);
  EXPECT_EQ(text(decoded_path(project) / "motion.json"), kept);
}

TEST_F(SharedDecoding, ACameraAtRestHasNoViewsToHoldOutAndNothingIsKept) {
  Project project = open("no_views", 256, "rests.mp4", Split::views);
  const auto refused = run_stages(project, Stage::import, Progress(), {}, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().what.find("camera rests"), std::string::npos) << refused.error().what;
  EXPECT_FALSE(refused.error().fix.empty());
  EXPECT_FALSE(path_exists(decoded_path(project)));
  expect_nothing_half_written(project);
}

}  // namespace
}  // namespace likeness
