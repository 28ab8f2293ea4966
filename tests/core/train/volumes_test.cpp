// Claims about where head and torso may be.
#include "core/train/volumes.h"

#include <gtest/gtest.h>

#include "core/head/builtin_head.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

Vec3f cell_centre(const FieldCube& cube, int n, int x, int y, int z) {
  return cube.origin + (Vec3f(float(x), float(y), float(z)) + Vec3f::Constant(0.5f)) * (cube.side / float(n));
}

template <class Visit>
void visit_cells(const Volume& volume, const Visit& visit) {
  const int n = volume.allowed.resolution;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) visit(x, y, z, cell_centre(volume.cube, n, x, y, z));
}

TEST(MakeVolumes, WithoutATorsoTheHeadHoldsNothingBelowTheNeckBase) {
  TrainingSet set = ball_set(6, 32);
  set.has_torso = false;
  const HeadShape shape = shape_head(set.model, set.person);
  const Volumes volumes = make_volumes(set, shape);
  const float base = neck_base(set.model, shape);
  visit_cells(volumes.head, [&](int x, int y, int z, const Vec3f& p) {
    if (volumes.head.allowed.occupied(x, y, z)) {
      ASSERT_GE(p.y(), base);
    }
  });
}

TEST(MakeVolumes, TheSurfaceIsAllowedAndTheDeepInsideIsCore) {
  const TrainingSet set = ball_set(6, 32);
  const HeadShape shape = shape_head(set.model, set.person);
  const Volumes volumes = make_volumes(set, shape);
  int missing = 0, core = 0, both = 0;
  visit_cells(volumes.head, [&](int x, int y, int z, const Vec3f& p) {
    const bool allowed = volumes.head.allowed.occupied(x, y, z), inner = volumes.head.core.occupied(x, y, z);
    const float r = p.norm();
    if (p.y() > neck_base(set.model, shape) + 0.01f && std::abs(r - kBallRadius) < 0.005f)
      missing += !allowed;
    if (inner) {
      EXPECT_LT(r, kBallRadius - 0.012f);
    }
    core += inner, both += allowed && inner;
  });
  EXPECT_EQ(missing, 0);
  EXPECT_GT(core, 1000);
  EXPECT_EQ(both, 0);
}

TEST(MakeVolumes, CarvingTakesAwayTheAirBesideTheHeadButNotTheHead) {
  const TrainingSet set = ball_set(24, 64);
  const HeadShape shape = shape_head(set.model, set.person);
  VolumeOptions uncarved;
  uncarved.carve = false;
  const Volumes carved = make_volumes(set, shape), full = make_volumes(set, shape, uncarved);
  int before = 0, after = 0, lost = 0;
  const float base = neck_base(set.model, shape);
  visit_cells(full.head, [&](int x, int y, int z, const Vec3f& p) {
    before += full.head.allowed.occupied(x, y, z);
    const bool kept = carved.head.allowed.occupied(x, y, z);
    after += kept;
    if (p.y() > base + 0.01f && std::abs(p.norm() - kBallRadius) < 0.003f) lost += !kept;
  });
  EXPECT_LT(after, 0.85 * before);
  EXPECT_EQ(lost, 0);
}

TEST(MakeVolumes, TheTorsoReachesNoHigherThanACollar) {
  TrainingSet set = ball_set(6, 32);
  set.has_torso = true;
  for (TrainingView& view : set.views) view.alpha = {};  // the ball has no body: nothing to carve with
  const HeadShape shape = shape_head(set.model, set.person);
  const Volumes volumes = make_volumes(set, shape);
  ASSERT_TRUE(volumes.torso.has_value());
  const float chin = landmark_positions(set.model, shape.vertices)[8].y();
  int cells = 0;
  visit_cells(*volumes.torso, [&](int x, int y, int z, const Vec3f& p) {
    if (!volumes.torso->allowed.occupied(x, y, z)) return;
    ++cells;
    ASSERT_LT(p.y(), chin + 0.05f);
  });
  EXPECT_GT(cells, 1000);
}

TEST(MakeVolumes, APictureThatEndsAtTheChinStillHasShoulders) {
  TrainingSet set = ball_set(6, 64);
  set.has_torso = true;
  const HeadShape shape = shape_head(set.model, set.person);
  const float chin = landmark_positions(set.model, shape.vertices)[8].y();
  const auto cut_off_at = [&](float height) {
    for (TrainingView& view : set.views) {
      const Vec3d lowest = view.camera.cam_from_world * view.pose.world_from_torso * Vec3d(0, height, 0);
      view.camera.intrinsics.height = int(project<double>(view.camera.intrinsics, lowest).y());
      view.alpha = {};
    }
    return make_volumes(set, shape).torso;
  };
  const auto shoulders = cut_off_at(chin - 0.015f);
  ASSERT_TRUE(shoulders.has_value());
  int cells = 0;
  visit_cells(*shoulders, [&](int x, int y, int z, const Vec3f& p) {
    cells += shoulders->allowed.occupied(x, y, z) && std::abs(p.x()) > 0.1f && p.y() > chin - 0.01f;
  });
  EXPECT_GT(cells, 100);
  EXPECT_FALSE(cut_off_at(chin + 0.03f).has_value());
}

TEST(MakeVolumes, TheNeckAboveTheCollarBelongsToTheHeadAlone) {
  TrainingSet set = ball_set(6, 32);
  set.model = make_builtin_head();
  set.person.identity = Eigen::VectorXf::Zero(set.model.identity_count());
  set.has_torso = true;
  for (TrainingView& view : set.views) {
    view.alpha = {};
    view.pose.articulation = neutral_articulation(set.model);
  }
  const HeadShape shape = shape_head(set.model, set.person);
  const Volumes volumes = make_volumes(set, shape);
  ASSERT_TRUE(volumes.torso.has_value());
  EXPECT_FLOAT_EQ(volumes.neck.base, neck_base(set.model, shape));
  EXPECT_GT(volumes.neck.top, volumes.neck.base + 0.03f);
  const int n = volumes.head.allowed.resolution;
  const float side = volumes.head.cube.side;
  int beside = 0;
  visit_cells(*volumes.torso, [&](int x, int y, int z, const Vec3f& p) {
    if (!volumes.torso->allowed.occupied(x, y, z) || p.y() < volumes.neck.base + 0.045f) return;
    ++beside;  // shoulders reach as high as this, but not where the head's skin is
    const Vec3f cell = (p - volumes.head.cube.origin) * (float(n) / side);
    if ((cell.array() < 0).any() || (cell.array() >= float(n)).any()) return;
    ASSERT_FALSE(volumes.head.allowed.occupied(int(cell.x()), int(cell.y()), int(cell.z())));
  });
  EXPECT_GT(beside, 100);
}

}  // namespace
}  // namespace likeness
