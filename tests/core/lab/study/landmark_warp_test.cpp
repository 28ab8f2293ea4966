// Claims about the moved picture: similarities are met exactly, control points land where they were, and a
// picture moved to its own pose is itself.
#include "core/lab/study/landmark_warp.h"

#include <gtest/gtest.h>

#include <complex>

#include "core/base/rigid.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

const std::vector<Vec2d> kPoints{{3, 4}, {20, 6}, {11, 15}, {7, 22}, {25, 24}};
const std::vector<double> kImportance{1, 2, 1, 1, 5};

TEST(MovedBack, EverySimilarityIsMetEverywhere) {
  const std::complex<double> a = std::polar(1.3, 0.4), b(5, -2);
  std::vector<Vec2d> now;
  for (const Vec2d& p : kPoints) {
    const auto q = a * std::complex<double>(p.x(), p.y()) + b;
    now.emplace_back(q.real(), q.imag());
  }
  for (const Vec2d& p : {Vec2d(0, 0), Vec2d(12, 9), Vec2d(-30, 80), kPoints[2]}) {
    const auto q = a * std::complex<double>(p.x(), p.y()) + b;
    EXPECT_LT((moved_back({q.real(), q.imag()}, now, kPoints, kImportance) - p).norm(), 1e-9);
  }
}

TEST(MovedBack, AControlPointComesFromWhereItWas) {
  std::vector<Vec2d> now = kPoints;
  now[1] += Vec2d(2, -1), now[4] += Vec2d(-3, 1);
  for (std::size_t i = 0; i < now.size(); ++i)
    EXPECT_LT((moved_back(now[i], now, kPoints, kImportance) - kPoints[i]).norm(), 1e-3) << i;
}

TEST(LandmarkWarp, APictureMovedToItsOwnPoseIsItself) {
  const TrainingSet set = ball_set(5, 32);
  const LandmarkWarp warp = make_landmark_warp(set);
  const TrainingView& view = set.views[std::size_t(warp.view)];
  const Image moved = render_landmark_warp(warp, set.model, view.camera, view.pose);
  ASSERT_EQ(moved.data.size(), warp.picture.data.size());
  for (std::size_t i = 0; i < moved.data.size(); ++i) ASSERT_NEAR(moved.data[i], warp.picture.data[i], 1e-4f);
}

TEST(LandmarkWarp, APersonWhoStepsAsideIsSeenThere) {
  const TrainingSet set = ball_set(5, 32);
  const LandmarkWarp warp = make_landmark_warp(set);
  const TrainingView& view = set.views[std::size_t(warp.view)];
  const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
  const Pose aside(
      Eigen::Translation3d(4 * cam_from_head.translation().z() / view.camera.intrinsics.fx, 0, 0));
  const Pose world = inverse(view.camera.cam_from_world) * aside * view.camera.cam_from_world;  // 4 px
  AvatarPose stepped = view.pose;
  stepped.world_from_head = world * stepped.world_from_head;
  stepped.world_from_torso = world * stepped.world_from_torso;
  const Image moved = render_landmark_warp(warp, set.model, view.camera, stepped);
  const auto centre = [](const Image& rgba) {
    double x = 0, all = 0;
    for (int v = 0; v < rgba.height; ++v)
      for (int u = 0; u < rgba.width; ++u) x += u * rgba.at(u, v)[3], all += rgba.at(u, v)[3];
    return x / all;
  };
  EXPECT_NEAR(centre(moved) - centre(warp.picture), 4, 0.5);
}

}  // namespace
}  // namespace likeness
