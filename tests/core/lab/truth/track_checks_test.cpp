// Claims about judging a track without its truth.
#include "core/lab/truth/track_checks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "core/track/points/withheld_points.h"
#include "tests/core/lab/truth/acted_track.h"

namespace likeness {
namespace {

std::vector<ProjectedLandmarks> nose_path(int frames, double noise_px, double speed_px) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, noise_px > 0 ? noise_px : 1);
  std::vector<ProjectedLandmarks> path(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) {
    ProjectedLandmarks& p = path[std::size_t(i)];
    p.known = true;
    p.points.fill(Vec2d::Zero());
    p.points[30] = Vec2d(100 + speed_px * i, 100);
    if (noise_px > 0) p.points[30] += Vec2d(normal(random), normal(random));
  }
  return path;
}

TEST(TrackChecks, JitterIsTheSecondDifferenceOfWhatTrembles) {
  EXPECT_LT(measure_stillness(nose_path(200, 0, 0)).jitter_px, 1e-12);
  const Stillness trembling = measure_stillness(nose_path(400, 0.1, 0));
  EXPECT_GT(trembling.frames, 300);
  EXPECT_NEAR(trembling.jitter_px, 0.1 * std::sqrt(2 * 6.0), 0.05);  // (1, -2, 1) in two dimensions
}

TEST(TrackChecks, TheTurningPointsOfANodAreNotStill) {
  auto path = nose_path(200, 0, 0);
  for (std::size_t i = 0; i < path.size(); ++i) path[i].points[30].y() += 4 * std::sin(double(i) * 0.6);
  EXPECT_EQ(measure_stillness(path).frames, 0);
}

TEST(TrackChecks, AMovingHeadIsNotStill) { EXPECT_EQ(measure_stillness(nose_path(100, 0, 0.5)).frames, 0); }

// Points on the head seen in every frame, with a little noise.
WithheldPoints seen_points(const TrackTruth& truth, double noise_px) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.06, 0.06);
  std::normal_distribution<double> normal;
  WithheldPoints points;
  for (int k = 0; k < 40; ++k) {
    const Vec3d at(place(random), place(random), 0.08 + 0.3 * place(random));
    WithheldTrack track{at + Vec3d::Constant(0.003), {}};
    for (const TrackedFrame& frame : truth.track.frames) {
      const Vec3d p = frame.pose.world_from_head * at;
      track.seen.push_back(
          {frame.frame, p.hnormalized() + Vec2d(normal(random), normal(random)) * noise_px / 700, 700});
    }
    points.tracks.push_back(track);
  }
  return points;
}

TEST(TrackChecks, WhatStaysInTheFaceIsTakenOffFreshLandmarks) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1);
  std::vector<ProjectedLandmarks> fitted(60);
  std::array<Vec2d, kLandmarkCount> face, usual;
  for (std::size_t k = 0; k < kLandmarkCount; ++k)
    face[k] = 60 * Vec2d(noise(random), noise(random)), usual[k] = 2 * Vec2d(noise(random), noise(random));
  const auto found_with = [&](double scatter_px) {
    std::vector<std::array<Vec2d, kLandmarkCount>> found(fitted.size());
    for (std::size_t i = 0; i < fitted.size(); ++i) {
      const double size = 1 + 0.5 * std::sin(0.3 * double(i));  // the face turns and comes nearer
      const Eigen::Matrix2d turn =
          size * Eigen::Rotation2Dd(0.5 * std::sin(0.2 * double(i))).toRotationMatrix();
      for (std::size_t k = 0; k < kLandmarkCount; ++k) {
        fitted[i].points[k] = turn * face[k];
        found[i][k] = turn * (face[k] + usual[k]) + scatter_px * Vec2d(noise(random), noise(random));
      }
    }
    return found;
  };
  const auto still = found_with(0);
  const FreshLandmarks drawn_elsewhere = compare_fresh(still, fitted);
  EXPECT_EQ(drawn_elsewhere.frames, 60);
  EXPECT_GT(drawn_elsewhere.mean_px, 1.5);
  EXPECT_LT(drawn_elsewhere.moving_px, 1e-9);
  // What was drawn elsewhere comes back, on the face's own axes: its outer eye corners are level and one
  // apart.
  const Vec2d across = face[45] - face[36];
  Eigen::Matrix2d to_face;
  to_face << across.x(), across.y(), -across.y(), across.x();
  to_face /= across.squaredNorm();
  for (std::size_t k = 17; k < kLandmarkCount; ++k)
    EXPECT_LT((drawn_elsewhere.usual_offset[k] - to_face * usual[k]).norm(), 1e-9) << k;
  EXPECT_EQ(drawn_elsewhere.usual_offset[0], Vec2d(0, 0));
  const auto scattered = found_with(1);
  const double moving_px = compare_fresh(scattered, fitted).moving_px;
  EXPECT_NEAR(moving_px, std::sqrt(std::numbers::pi / 2),
              0.08);  // mean length of the scatter: none is taken off
}

TEST(TrackChecks, WithheldPointsAgreeWithTheTruthAndNotWithAWrongPose) {
  const TrackTruth truth = acted_truth(40);
  const WithheldPoints points = seen_points(truth, 0.1);
  const WithheldScore right = score_withheld(points, truth.track, truth.cameras);
  EXPECT_EQ(right.on_head, 40);
  EXPECT_LT(right.median_px, 0.2);
  Track wrong = truth.track;
  for (std::size_t i = 0; i < wrong.frames.size(); ++i)
    wrong.frames[i].pose.world_from_head.translation().x() += i % 4 < 2 ? 0.001 : 0.0;  // 1.2 px
  EXPECT_GT(score_withheld(points, wrong, truth.cameras).median_px, 2 * right.median_px);
}

TEST(TrackChecks, PointsThatDoNotMoveWithTheHeadDoNotCount) {
  const TrackTruth truth = acted_truth(40);
  WithheldPoints points = seen_points(truth, 0.1);
  for (WithheldObservation& o : points.tracks.front().seen) o.ray = Vec2d(0.1, 0.1);  // on the wall
  const WithheldScore score = score_withheld(points, truth.track, truth.cameras);
  EXPECT_EQ(score.tracks, 40);
  EXPECT_EQ(score.on_head, 39);
}

TEST(TrackChecks, AboutTheAskedShareIsWithheld) {
  int count = 0;
  for (std::size_t i = 0; i < 4000; ++i) count += is_withheld(i, 0.15);
  EXPECT_NEAR(count, 600, 80);
}

}  // namespace
}  // namespace likeness
