// Claims about a project whose split goes by the side from which the head is seen: what its frames share is
// told by those that train alone.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "core/base/files.h"
#include "core/face/landmarks.h"
#include "core/head/builtin_head.h"
#include "core/image/files.h"
#include "core/project/project_views.h"
#include "core/project/run_stages.h"
#include "core/project/training_set.h"
#include "core/scene/track.h"
#include "core/synth/demo_stage.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kTurningFrames = 80, kTurningSide = 224;

class SidesProject : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_sides_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    if (!FaceDetector::load(kDlibLandmarks)) return;  // the tests are skipped
    DemoOptions demo;
    demo.width = demo.height = kTurningSide;
    demo.frames = kTurningFrames;
    demo.samples_per_pixel = 1;
    demo.moving_share = 0;
    DemoStage stage(make_builtin_head(), demo);
    for (int f = 0; f < kTurningFrames; ++f) pictures_.push_back(stage.film(f, {}).rgb);
    film("a.mp4", {});
    project_ = build("a", "a.mp4");
  }
  static void TearDownTestSuite() { fs::remove_all(root_), pictures_.clear(); }
  void SetUp() override {
    if (pictures_.empty()) GTEST_SKIP() << "dlib's landmark model is not here";
  }

  // marked: frames with a bright patch on the wall in a corner, far from the person. Without loss, so that
  // all other frames are the same.
  static void film(const char* name, const std::set<int>& marked) {
    auto writer = VideoWriter::create(root_ / name, kTurningSide, kTurningSide, {.crf = 0});
    ASSERT_TRUE(writer.ok());
    for (int f = 0; f < kTurningFrames; ++f) {
      Image8 picture = pictures_[std::size_t(f)];
      if (marked.contains(f))
        for (int y = 0; y < 24; ++y) std::fill_n(picture.at(0, y), 3 * 24, std::uint8_t(250));
      ASSERT_TRUE(writer->add(picture).ok());
    }
    ASSERT_TRUE(writer->finish().ok());
  }
  static Project build(const char* name, const char* clip) {
    ProjectOptions options;
    options.shared.video = root_ / clip;
    options.shared.landmark_model = kDlibLandmarks;
    options.shared.person_network = "none";
    options.import.split = Split::sides;
    options.import.sides = {22, 28};
    auto project = open_or_create_project(root_ / name, options);
    EXPECT_TRUE(project.ok()) << project.error().what;
    const auto done = run_stages(*project, Stage::matte, Progress(), {}, {});
    EXPECT_TRUE(done.ok()) << done.error().what << done.error().fix;
    return *project;
  }

  static inline fs::path root_;
  static inline std::vector<Image8> pictures_;
  static inline Project project_;
};

TEST_F(SidesProject, TrainsOnTheViewsInsideAlone) {
  const auto capture = read_capture(capture_path(project_));
  ASSERT_TRUE(capture.ok()) << capture.error().what;
  EXPECT_EQ(capture->split, Split::sides);
  const auto set = load_training_views(project_, make_builtin_head());
  ASSERT_TRUE(set.ok()) << set.error().what;
  EXPECT_GE(set->views.size(), 20u);
  const std::set<int> silent = silent_frames(*capture);
  for (const TrainingView& view : set->views) {
    const auto own = std::ranges::find(capture->frames, view.camera.frame, &CaptureFrame::frame);
    ASSERT_NE(own, capture->frames.end());
    ASSERT_TRUE(own->view);
    EXPECT_LE(angle_deg(*own->view), 22) << own->frame;
    EXPECT_FALSE(silent.contains(own->frame)) << own->frame;
  }
  EXPECT_NE(project_.record(Stage::import).message.find("kept apart"), std::string::npos);
}

TEST_F(SidesProject, WhatHeldOutFramesAndThoseBetweenShowReachesNothingThatIsShared) {
  const auto capture = read_capture(capture_path(project_));
  ASSERT_TRUE(capture.ok()) << capture.error().what;
  film("b.mp4", silent_frames(*capture));
  const Project marked = build("b", "b.mp4");
  const auto other = read_capture(capture_path(marked));
  ASSERT_TRUE(other.ok()) << other.error().what;
  ASSERT_EQ(silent_frames(*other), silent_frames(*capture));
  const auto a = read_track(track_path(project_)), b = read_track(track_path(marked));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->person.identity, b->person.identity);
  EXPECT_EQ(a->neutral.expression, b->neutral.expression);
  EXPECT_EQ(*read_file(plate_path(project_)), *read_file(plate_path(marked)));
  int compared = 0, marked_pictures = 0;
  for (const CaptureFrame& frame : capture->frames) {
    const fs::path name = frame_name(frame.frame).filename();
    if (frame.held_out)
      marked_pictures +=
          *read_file(project_.folder / "frames" / name) != *read_file(marked.folder / "frames" / name);
    if (!frame.used) continue;
    EXPECT_EQ(*read_file(project_.folder / "frames" / name), *read_file(marked.folder / "frames" / name));
    EXPECT_EQ(*read_file(project_.folder / "masks" / name), *read_file(marked.folder / "masks" / name));
    const TrackedFrame *own = find_tracked(*a, frame.frame), *theirs = find_tracked(*b, frame.frame);
    ASSERT_TRUE(own && theirs);
    EXPECT_EQ(own->pose.world_from_head.matrix(), theirs->pose.world_from_head.matrix()) << frame.frame;
    ++compared;
  }
  EXPECT_GE(compared, 20);
  EXPECT_EQ(marked_pictures, int(held_out_frames(*capture).size()));  // the marks are in the pictures
  EXPECT_GE(marked_pictures, 6);
}

}  // namespace
}  // namespace likeness
