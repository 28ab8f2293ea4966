// Claims about core/lab/study/track_annotations.h: what the track shows is painted where it is, from the
// least to the most of it.
#include "core/lab/study/track_annotations.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

constexpr int kViews = 40, kSize = 200;
const Capture kCapture{.width = 900, .height = 700, .crop = {100, 50, 600}, .size = kSize};

// Frames 3, 6, 9, ... in which the jaw opens more and more and the right eye closes now and then.
TrainingSet acted_set() {
  TrainingSet set;
  set.size = kSize;
  set.model = make_builtin_head();
  set.person = {Eigen::VectorXf::Zero(set.model.identity_count()), {}};
  const NamedAction* jaw = find_action(set.model, "jawOpen");
  const NamedAction* lid = find_action(set.model, "eyeBlink_R");
  for (int v = 0; v < kViews; ++v) {
    TrainingView view;
    view.camera.frame = 3 * (v + 1);
    view.camera.intrinsics = {kSize, kSize, 300, 300, 100, 100};
    view.pose.world_from_head.linear() = Vec3d(1, -1, -1).asDiagonal();
    view.pose.world_from_head.translation() = Vec3d(0, 0, 0.6);
    view.pose.articulation = neutral_articulation(set.model);
    add_action(view.pose.articulation, *jaw, float(v) / kViews);
    add_action(view.pose.articulation, *lid, v % 5 == 4 ? 1.f : 0.f);
    set.views.push_back(std::move(view));
  }
  return set;
}

const PaintedAttribute* named(const PaintedAttributes& painted, std::string_view name) {
  const auto at = std::ranges::find(painted, name, &PaintedAttribute::name);
  return at == painted.end() ? nullptr : &*at;
}

TEST(TrackAnnotations, GoFromTheLeastToTheMostThatTheTrackShows) {
  const PaintedAttributes painted = annotate_from_track(acted_set(), kCapture, 0.25);
  const PaintedAttribute* mouth = named(painted, "mouth");
  ASSERT_NE(mouth, nullptr);
  ASSERT_EQ(mouth->annotations.size(), std::size_t(kViews / 4));
  EXPECT_NEAR(mouth->annotations.front().value, -1, 0.06);
  EXPECT_NEAR(mouth->annotations.back().value, 1, 0.06);
  EXPECT_TRUE(std::ranges::is_sorted(mouth->annotations, {}, &AttributeAnnotation::value));
  const PaintedAttribute* eye = named(painted, "right eye");
  ASSERT_NE(eye, nullptr);
  for (const AttributeAnnotation& annotation : eye->annotations)
    EXPECT_NEAR(annotation.value, annotation.frame / 3 % 5 == 0 ? 1 : 0, 0.05) << annotation.frame;
}

TEST(TrackAnnotations, WhatDoesNotMoveIsNotPainted) {
  EXPECT_EQ(named(annotate_from_track(acted_set(), kCapture), "left eye"), nullptr);
}

TEST(TrackAnnotations, ThereAreSixAtLeastAndNoMoreThanFrames) {
  TrainingSet set = acted_set();
  EXPECT_EQ(annotate_from_track(set, kCapture).front().annotations.size(), 6u);
  std::vector<TrainingView> few;
  for (int v = 0; v < kViews; v += 10) few.push_back(set.views[std::size_t(v)]);
  set.views = few;
  EXPECT_EQ(annotate_from_track(set, kCapture).front().annotations.size(), 4u);
  set.views.clear();
  EXPECT_TRUE(annotate_from_track(set, kCapture).empty());
}

TEST(TrackAnnotations, ThePaintCoversTheLipsAndNotTheEyes) {
  const TrainingSet set = acted_set();
  const PaintedAttributes painted = annotate_from_track(set, kCapture);
  const AttributeAnnotation& last = named(painted, "mouth")->annotations.back();
  const StrokeCover cover = cover_strokes(last.region, kCapture.crop, kSize);
  const auto view =
      std::ranges::find(set.views, last.frame, [](const TrainingView& v) { return v.camera.frame; });
  const auto landmarks = landmark_positions(
      set.model, pose_head(set.model, shape_head(set.model, set.person), view->pose.articulation));
  for (int i = 36; i < kLandmarkCount; ++i) {
    const Vec3d point =
        view->camera.cam_from_world * view->pose.world_from_head * landmarks[std::size_t(i)].cast<double>();
    const Vec2d pixel = project(view->camera.intrinsics, point);
    const float painted_here = cover.person.data[std::size_t(pixel.y()) * kSize + std::size_t(pixel.x())];
    if (i < 48)
      EXPECT_LT(painted_here, 0.5f) << "landmark " << i;
    else
      EXPECT_GT(painted_here, 0.5f) << "landmark " << i;
  }
}

}  // namespace
}  // namespace likeness
