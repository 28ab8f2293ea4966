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

// How many of the views see a place of the torso that far down, or would without a lower edge.
int seen_by(const TrainingSet& set, const Vec3d& place) {
  return int(std::ranges::count_if(set.views, [&](const TrainingView& view) {
    const Intrinsics& k = view.camera.intrinsics;
    return project<double>(k, view.camera.cam_from_world * view.pose.world_from_torso * place).y() < k.height;
  }));
}

// Of how many views the most see some place that far below the hem, m.
int most_seeing(const TrainingSet& set, double below) {
  const auto hem = find_hem(set, kTorsoCube);
  if (!hem) return -1;
  int most = 0;
  for (const double x : {-0.2, 0.0, 0.2})
    for (const double z : {-0.1, 0.0, 0.1})
      most = std::max(most, seen_by(set, {x, hem->at(float(x), float(z)) - below, z}));
  return most;
}

TEST(TorsoHem, HardlyAnyPictureShowsWhatLiesBelow) {
  TrainingSet set = ball_set(100, 32);  // the views turn by half a radian to either side, and sway
  EXPECT_GE(most_seeing(set, 0.004), 0);
  EXPECT_LE(most_seeing(set, 0.004), 5);
  // Of a body that only sways it lies no deeper than it must.
  for (TrainingView& view : set.views) view.pose.world_from_torso.linear() = Vec3d(1, -1, -1).asDiagonal();
  EXPECT_LE(most_seeing(set, 0.004), 5);
  EXPECT_GE(most_seeing(set, -0.004), 10);
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
