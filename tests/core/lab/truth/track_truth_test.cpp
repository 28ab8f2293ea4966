// Claims about measuring a track against the truth.
#include "core/lab/truth/track_truth.h"

#include <gtest/gtest.h>

#include "core/base/rigid.h"
#include "core/head/pose_head.h"
#include "tests/core/lab/truth/acted_track.h"

namespace likeness {
namespace {

Pose small_turn(double angle, const Vec3d& axis, const Vec3d& shift) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation_about(axis.normalized(), angle);
  pose.translation() = shift;
  return pose;
}

TEST(TrackTruth, TheTruthItselfHasNoError) {
  const TrackTruth truth = acted_truth(80);
  const auto result = compare_with_truth(truth.track, truth.model, truth, {70, 71, 72, 73, 74, 75, 76, 77});
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->alignment.scale, 1, 1e-6);
  EXPECT_LT(result->training.pose.turn_p95_deg, 1e-4);
  EXPECT_LT(result->held_out.pose.across_p95_mm, 1e-3);
  EXPECT_LT(result->shape_rms_mm, 1e-3);
  EXPECT_EQ(result->training.frames, 72);
  EXPECT_EQ(result->held_out.frames, 8);
  for (const TruthCorrelation& c : result->training.correlations) {
    ASSERT_TRUE(c.value.has_value()) << c.name;
    EXPECT_NEAR(*c.value, 1, 1e-3) << c.name;
  }
}

TEST(TrackTruth, AnotherScaleAndAnotherOriginAreNoError) {
  const TrackTruth truth = acted_truth(80);
  const Pose offset = small_turn(0.15, Vec3d(1, 2, -1), Vec3d(0.01, -0.03, 0.05));
  constexpr double kScale = 0.93;
  Track other = truth.track;
  for (TrackedFrame& frame : other.frames) {  // the camera is the world
    frame.pose.world_from_head = frame.pose.world_from_head * offset;
    frame.pose.world_from_head.translation() *= kScale;
  }
  const auto result = compare_with_truth(other, truth.model, truth, {});
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->alignment.scale, 1 / kScale, 1e-4);
  EXPECT_LT(result->training.pose.turn_p95_deg, 1e-3);
  EXPECT_LT(result->training.pose.along_p95_percent, 1e-2);
  EXPECT_LT(result->training.pose.across_p95_mm, 1e-2);
  EXPECT_NEAR(rotation_angle(result->alignment.truth_head_from_head.linear()), 0.15, 1e-4);
}

TEST(TrackTruth, TheShapesErrorIsItsDistanceFromTheSurface) {
  const TrackTruth truth = acted_truth(40);
  Track other = truth.track;
  const HeadShape shape = shape_head(truth.model, truth.track.person);
  const auto normals = vertex_normals(shape.vertices, truth.model.triangles);
  other.person.offsets.assign(shape.vertices.size(), Vec3f::Zero());
  for (std::size_t v = 0; v < normals.size(); ++v)
    if (truth.model.parts[v] == HeadPart::face) other.person.offsets[v] = 0.001f * normals[v];
  const auto result = compare_with_truth(other, truth.model, truth, {});
  ASSERT_TRUE(result.ok());
  EXPECT_GT(result->shape_rms_mm, 0.8);  // a little less than 1 mm in folds, where other skin is nearer
  EXPECT_LT(result->shape_rms_mm, 1.01);
}

TEST(TrackTruth, ASmileInTheRestIsAWiderMouth) {
  const TrackTruth truth = acted_truth(40);
  Track other = truth.track;
  other.neutral = neutral_articulation(truth.model);
  const auto right = compare_with_truth(other, truth.model, truth, {});
  ASSERT_TRUE(right.ok());
  EXPECT_LT(right->rest.mouth_rms_mm, 1e-2);
  EXPECT_NEAR(right->rest.mouth_width_mm, 0, 1e-2);
  for (const char* side : {"mouthSmile_L", "mouthSmile_R"})
    add_action(other.neutral, *find_action(truth.model, side), 0.5f);
  const auto smiling = compare_with_truth(other, truth.model, truth, {});
  ASSERT_TRUE(smiling.ok());
  EXPECT_GT(smiling->rest.mouth_rms_mm, 0.3);
  EXPECT_GT(smiling->rest.mouth_width_mm, 2);
}

TEST(TrackTruth, ErrorsPutInAreFound) {
  const TrackTruth truth = acted_truth(80);
  Track other = truth.track;
  for (std::size_t i = 0; i < other.frames.size(); ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;  // a constant error would be an offset
    Pose& pose = other.frames[i].pose.world_from_head;
    // One degree about the middle of the eyes, and 2 mm sideways.
    const HeadShape shape = shape_head(truth.model, other.person);
    const Vec3d eyes = 0.5 * (shape.joints[kLeftEye] + shape.joints[kRightEye]).cast<double>();
    const Mat3d turn = rotation_about(Vec3d::UnitZ(), sign * std::numbers::pi / 180);
    pose = pose * (Eigen::Translation3d(eyes) * Pose(turn) * Eigen::Translation3d(-eyes));
    pose.translation().x() += sign * 0.002;
  }
  const auto result = compare_with_truth(other, truth.model, truth, {});
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->training.pose.turn_median_deg, 1, 0.05);
  EXPECT_NEAR(result->training.pose.across_median_mm, 2, 0.2);
  EXPECT_LT(result->training.pose.along_median_percent, 0.1);
}

TEST(TrackTruth, HeldOutFramesDoNotMoveTheAlignment) {
  const TrackTruth truth = acted_truth(60);
  Track other = truth.track;
  std::set<int> held_out;
  for (int i = 50; i < 60; ++i) {
    held_out.insert(i);
    other.frames[std::size_t(i)].pose.world_from_head.translation().x() += 0.05;
  }
  const auto result = compare_with_truth(other, truth.model, truth, held_out);
  ASSERT_TRUE(result.ok());
  EXPECT_LT(result->training.pose.across_p95_mm, 1e-3);
  EXPECT_NEAR(result->held_out.pose.across_median_mm, 50, 1);
}

TEST(TrackTruth, ATrackWithoutFramesIsRefused) {
  const TrackTruth truth = acted_truth(20);
  Track lost = truth.track;
  for (TrackedFrame& frame : lost.frames) frame.status = FrameStatus::lost;
  const auto result = compare_with_truth(lost, truth.model, truth, {});
  ASSERT_FALSE(result.ok());
  EXPECT_FALSE(result.error().fix.empty());
}

}  // namespace
}  // namespace likeness
