// Claims about the lower end of a torso that the pictures cut off.
#include "core/train/torso_hem.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

const FieldCube kTorsoCube{Vec3f(-0.4f, -0.6f, -0.4f), 0.8f};

// The lower edges of the views' pictures at a depth of the torso frame, at its middle column; m.
std::vector<float> reach(const TrainingSet& set, float z) {
  std::vector<float> out;
  for (const TrainingView& view : set.views) {
    const Pose cam_from_torso = view.camera.cam_from_world * view.pose.world_from_torso;
    const Intrinsics& k = view.camera.intrinsics;
    double low = -2, high = 1;  // of y, by bisection
    for (int i = 0; i < 50; ++i) {
      const double y = 0.5 * (low + high);
      (project<double>(k, cam_from_torso * Vec3d(0, y, z)).y() > k.height ? low : high) = y;
    }
    out.push_back(float(high));
  }
  std::ranges::sort(out);
  return out;
}

TEST(TorsoHem, LiesWhereNearlyAllPicturesEnd) {
  TrainingSet set = ball_set(100, 32);
  const auto hem = find_hem(set, kTorsoCube);
  ASSERT_TRUE(hem.has_value());
  // All but the three deepest of a hundred, and not on the last row itself.
  EXPECT_NEAR(hem->at(0, 0.08f), reach(set, 0.08f)[3] + 0.003f, 2e-4f);
}

// What is nearer to the camera is cut off higher.
TEST(TorsoHem, IsThePlaneOfThePicturesEdge) {
  TrainingSet set = ball_set(1, 64);
  set.views[0].pose.world_from_torso.linear() = Vec3d(1, -1, -1).asDiagonal();
  const auto hem = find_hem(set, kTorsoCube);
  ASSERT_TRUE(hem.has_value());
  const TrainingView& view = set.views[0];
  for (const Vec3d& at : {Vec3d(0, 0, 0.1), Vec3d(0.2, 0, -0.1), Vec3d(-0.2, 0, 0)}) {
    const Vec3d place(at.x(), hem->at(float(at.x()), float(at.z())), at.z());
    const Vec2d px = project<double>(view.camera.intrinsics,
                                     view.camera.cam_from_world * view.pose.world_from_torso * place);
    EXPECT_NEAR(px.y(), view.camera.intrinsics.height, 1.0);
  }
  EXPECT_GT(hem->at(0, 0.1f), hem->at(0, -0.1f));
}

TEST(TorsoHem, CellsGoOnAsTheyAreAtTheHemAndNoFurtherThanItSays) {
  const int n = 32;
  FieldPart torso;
  torso.cube = kTorsoCube;
  torso.occupancy = make_occupancy(n, false);
  torso.opacity.assign(std::size_t(n) * n * n, 0);
  const TorsoHem hem{-0.2f, 0, 0};  // 16 cells above the cube's floor
  for (int y = 10; y < 20; ++y) {   // of column (5, 5): below the hem it was forbidden, too, once
    set_occupied(torso.occupancy, 5, y, 5, y >= 16);
    torso.opacity[(5 * std::size_t(n) + std::size_t(y)) * n + 5] = std::uint8_t(y);
  }
  set_occupied(torso.occupancy, 8, 12, 8, true);  // below the hem, and nothing at it
  extend_below(hem, torso);
  const int cells = int(std::ceil(kBelowHem / (kTorsoCube.side / float(n))));
  for (int y = 0; y < n; ++y) {
    EXPECT_EQ(torso.occupancy.occupied(5, y, 5), y >= 16 - cells && y < 20) << y;
    EXPECT_FALSE(torso.occupancy.occupied(8, y, 8)) << y;
  }
  EXPECT_EQ(torso.opacity[(5 * std::size_t(n) + 15) * n + 5], 16);
}

}  // namespace
}  // namespace likeness
