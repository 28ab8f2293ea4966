// Claims about rays, the walk through occupied cells, and the placing of samples.
#include "core/render/rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace likeness {
namespace {

OccupancyGrid random_grid(int n, double share, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  OccupancyGrid grid = make_occupancy(n, false);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) set_occupied(grid, x, y, z, uniform(engine) < share);
  return grid;
}

FieldRay random_ray(std::mt19937& engine) {
  std::uniform_real_distribution<float> uniform(-1, 1);
  Vec3f direction(uniform(engine), uniform(engine), uniform(engine));
  direction.normalize();
  const Vec3f through =
      Vec3f::Constant(0.5f) + 0.45f * Vec3f(uniform(engine), uniform(engine), uniform(engine));
  return {through - 2 * direction, direction};
}

bool occupied_at(const OccupancyGrid& grid, const Vec3f& p) {
  for (int a = 0; a < 3; ++a)
    if (p[a] < 0 || p[a] >= 1) return false;
  const float n = float(grid.resolution);
  return grid.occupied(int(p.x() * n), int(p.y() * n), int(p.z() * n));
}

TEST(OccupiedIntervals, CoverExactlyTheOccupiedStretches) {
  const OccupancyGrid grid = random_grid(12, 0.3, 1), none;
  std::mt19937 engine(2);
  int disagreements = 0, looks = 0;
  for (int r = 0; r < 200; ++r) {
    const FieldRay ray = random_ray(engine);
    std::vector<Interval> intervals;
    occupied_intervals(ray, grid, none, 0, 10, intervals);
    for (std::size_t i = 0; i + 1 < intervals.size(); ++i) EXPECT_LT(intervals[i].far, intervals[i + 1].near);
    for (float t = 0; t < 4; t += 0.00371f, ++looks) {
      bool inside = false;
      for (const Interval& i : intervals) inside |= t >= i.near && t < i.far;
      disagreements += inside != occupied_at(grid, ray.origin + t * ray.direction);
    }
  }
  EXPECT_LT(disagreements, looks / 10000);  // rounding at cell borders
}

TEST(OccupiedIntervals, StopAtTheFirstCoreCell) {
  OccupancyGrid all = make_occupancy(8, true), core = make_occupancy(8, false);
  set_occupied(core, 4, 4, 4, true);
  const FieldRay ray{{0.5625f, 0.5625f, -1}, {0, 0, 1}};
  std::vector<Interval> intervals;
  const float end = occupied_intervals(ray, all, core, 0, 10, intervals);
  EXPECT_NEAR(end, 1.5f, 1e-6);
  ASSERT_EQ(intervals.size(), 1u);
  EXPECT_NEAR(intervals[0].near, 1.0f, 1e-6);
  EXPECT_NEAR(intervals[0].far, 1.5f, 1e-6);
}

// Below the base all follows the torso, which has moved a quarter of the cube along x.
TEST(OccupiedIntervals, FindABentNeckWhereItWentAndNothingFromOutsideTheCube) {
  OccupancyGrid grid = make_occupancy(8, false), core = make_occupancy(8, false);
  for (int z = 2; z < 6; ++z) set_occupied(grid, 4, 0, z, true);
  set_occupied(core, 4, 0, 4, true);
  for (int z = 0; z < 8; ++z) set_occupied(grid, 0, 0, z, true);
  Pose moved = Pose::Identity();
  moved.translation().x() = 0.25;
  const NeckBend neck = make_neck_bend({0.3f, 0.6f, {0.5f, 0.45f, 0.5f}}, moved);
  std::vector<Interval> found;
  const FieldRay where_it_went{{0.8125f, 0.0625f, -1}, {0, 0, 1}};
  EXPECT_NEAR(occupied_intervals(where_it_went, grid, core, 0, 10, found, &neck), 1.5f, 1e-6);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].near, 1.25f, 1e-6);
  found.clear();
  const FieldRay from_outside{{0.0625f, 0.0625f, -1}, {0, 0, 1}};  // its place lies at x = -0.19
  occupied_intervals(from_outside, grid, core, 0, 10, found, &neck);
  EXPECT_TRUE(found.empty());
}

TEST(OccupiedIntervals, AreEmptyForARayBesideTheCube) {
  const OccupancyGrid all = make_occupancy(8, true), none;
  std::vector<Interval> intervals;
  EXPECT_EQ(occupied_intervals({{2, 2, -1}, {0, 0, 1}}, all, none, 0, 10, intervals), 10.f);
  EXPECT_TRUE(intervals.empty());
}

TEST(PlaceSamples, AreSortedInsideTheirIntervalsAndCoverTheLength) {
  const std::vector<Interval> head{{1.0f, 1.1f}, {1.3f, 1.35f}}, torso{{1.05f, 1.25f}};
  for (const std::uint64_t jitter : {0, 7, 99}) {
    std::vector<RaySample> samples(16);
    const int n = place_samples(head, torso, 0.0015f, jitter, samples);
    EXPECT_EQ(n, 16);
    float length = 0;
    for (int i = 0; i < n; ++i) {
      if (i > 0) {
        EXPECT_LE(samples[i - 1].t, samples[i].t);
      }
      bool inside = false;
      for (const Interval& interval : samples[i].field == 0 ? head : torso)
        inside |= samples[i].t >= interval.near - 1e-5f && samples[i].t <= interval.far + 1e-5f;
      EXPECT_TRUE(inside) << samples[i].t << " of field " << samples[i].field;
      length += samples[i].dt;
    }
    EXPECT_NEAR(length, 0.35f, 1e-5);
  }
}

TEST(PlaceSamples, AreNoDenserThanAsked) {
  const std::vector<Interval> head{{1.0f, 1.01f}};
  std::vector<RaySample> samples(16);
  EXPECT_EQ(place_samples(head, {}, 0.0025f, 0, samples), 4);
}

TEST(FieldRay, ReachesTheProjectedPointAtItsDistance) {
  Intrinsics k{64, 64, 90, 95, 31, 33, 0.12, -0.05, 0.002, -0.001};
  Pose cam_from_world = Pose::Identity();
  cam_from_world.rotate(Eigen::AngleAxisd(0.3, Vec3d(1, 2, 0.5).normalized()));
  cam_from_world.pretranslate(Vec3d(0.02, -0.03, 0.7));
  Pose world_from_head = Pose::Identity();
  world_from_head.rotate(Eigen::AngleAxisd(-0.5, Vec3d::UnitY()));
  const FieldCube cube{Vec3f(-0.15f, -0.1f, -0.2f), 0.3f};
  const Vec3d point(0.04, 0.06, 0.03);  // in the head frame
  const Vec3d in_cam = cam_from_world * world_from_head * point;
  const Vec3f direction = ray_direction(k, project(k, in_cam)).normalized().cast<float>();
  const FieldRay ray = field_ray(unit_from_camera(cube, cam_from_world, world_from_head), direction);
  const Vec3f unit = ray.origin + float(in_cam.norm()) * ray.direction;
  const Vec3f expected = (point.cast<float>() - cube.origin) / cube.side;
  EXPECT_LT((unit - expected).norm(), 1e-4f);
  EXPECT_NEAR(ray.direction.norm() * cube.side, 1, 1e-5);
}

TEST(SampleRays, GiveEachSampleItsPlaceInItsField) {
  const OccupancyGrid head = random_grid(8, 0.4, 3), torso = random_grid(8, 0.4, 4), none;
  MarchVolumes volumes;
  volumes.fields[0] = {&head, &none, 1.f};
  volumes.fields[1] = {&torso, &none, 2.f};
  volumes.near = 0;
  std::mt19937 engine(5);
  std::vector<RayRequest> rays(700);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    rays[r].fields = {random_ray(engine), random_ray(engine)};
    rays[r].fields[1].direction *= 0.5f;  // a side of 2 m
    rays[r].view = std::int32_t(r % 5);
    rays[r].jitter = r + 1;
  }
  SampleBatch batch;
  sample_rays(rays, volumes, batch);
  ASSERT_EQ(batch.begin.size(), rays.size() + 1);
  EXPECT_EQ(batch.begin.back(), batch.fields[0].count() + batch.fields[1].count());
  for (std::size_t r = 0; r < rays.size(); ++r) {
    EXPECT_EQ(meets_volume(rays[r], volumes), batch.begin[r] < batch.begin[r + 1]);
    for (std::uint32_t i = batch.begin[r]; i < batch.begin[r + 1]; ++i) {
      const int f = batch.field[i];
      const FieldSamples& s = batch.fields[f];
      const std::uint32_t at = batch.slot[i];
      ASSERT_LT(at, s.count());
      EXPECT_EQ(s.view[at], rays[r].view);
      const FieldRay& ray = rays[r].fields[f];
      const Vec3f p(s.x[at], s.y[at], s.z[at]);
      const Vec3f off = (p - ray.origin).cross(ray.direction.normalized());
      EXPECT_LT(off.norm(), 1e-4f);
    }
  }
}

}  // namespace
}  // namespace likeness
