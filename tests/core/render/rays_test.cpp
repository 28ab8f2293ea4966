// Claims about rays, the walk through occupied cells, and the placing of samples.
#include "core/render/rays.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/rigid.h"

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
    occupied_intervals(ray, march_volume(grid, none), 0, 10, intervals);
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
  const float end = occupied_intervals(ray, march_volume(all, core), 0, 10, intervals);
  EXPECT_NEAR(end, 1.5f, 1e-6);
  ASSERT_EQ(intervals.size(), 1u);
  EXPECT_NEAR(intervals[0].near, 1.0f, 1e-6);
  EXPECT_NEAR(intervals[0].far, 1.5f, 1e-6);
}

// Most of a sparse grid's bricks are empty, and 20 cells are no whole number of bricks.
TEST(OccupiedIntervals, LoseNothingBySkippingEmptyBricks) {
  for (const int n : {20, 32}) {
    const OccupancyGrid grid = random_grid(n, 0.002, 3), none;
    const MarchVolume quick = march_volume(grid, none);
    MarchVolume plain = quick;
    plain.bricks.assign(plain.bricks.size(), 1);
    std::mt19937 engine(4);
    int found = 0;
    for (int r = 0; r < 2000; ++r) {
      const FieldRay ray = random_ray(engine);
      std::vector<Interval> a, b;
      occupied_intervals(ray, quick, 0, 10, a);
      occupied_intervals(ray, plain, 0, 10, b);
      ASSERT_EQ(a.size(), b.size()) << "ray " << r;
      found += int(a.size());
      for (std::size_t i = 0; i < a.size(); ++i) {
        // Distances of up to 4, each a sum of other steps: some roundings of 2.4e-7 apart.
        EXPECT_NEAR(a[i].near, b[i].near, 5e-6f);
        EXPECT_NEAR(a[i].far, b[i].far, 5e-6f);
      }
    }
    EXPECT_GT(found, 50);
    EXPECT_LT(std::count(quick.bricks.begin(), quick.bricks.end(), 1), 0.75 * double(quick.bricks.size()));
  }
}

TEST(OccupiedIntervals, WithKnownOpacitiesEveryCellHasItsOpticalDepth) {
  const OccupancyGrid all = make_occupancy(4, true), none;
  std::vector<std::uint8_t> opacity(64, 0);
  opacity[0 * 16 + 2 * 4 + 2] = 102;  // 0.4 of the light
  opacity[1 * 16 + 2 * 4 + 2] = 255;
  std::vector<Interval> found;
  occupied_intervals({{0.6f, 0.6f, -1}, {0, 0, 1}}, march_volume(all, none, 1, opacity), 0, 10, found);
  ASSERT_EQ(found.size(), 3u);  // two cells, and the rest in one
  EXPECT_NEAR(found[0].depth, -std::log(0.6f), 1e-5);
  EXPECT_GT(found[1].depth, 5);
  EXPECT_EQ(found[2].depth, 0);
  EXPECT_NEAR(found[2].far - found[2].near, 0.5f, 1e-6);
}

// Below the base all follows the torso, which has moved a quarter of the cube along x.
TEST(OccupiedIntervals, FollowABentNeckAndIgnoreWhatLiesOutsideTheCube) {
  OccupancyGrid grid = make_occupancy(8, false), core = make_occupancy(8, false);
  for (int z = 2; z < 6; ++z) set_occupied(grid, 4, 0, z, true);
  set_occupied(core, 4, 0, 4, true);
  for (int z = 0; z < 8; ++z) set_occupied(grid, 0, 0, z, true);
  Pose moved = Pose::Identity();
  moved.translation().x() = 0.25;
  const NeckBend neck = make_neck_bend({0.3f, 0.6f, {0.5f, 0.45f, 0.5f}}, moved);
  const MarchVolume volume = march_volume(grid, core);
  const MarchNeck bend = march_neck(neck, volume);
  std::vector<Interval> found;
  const FieldRay where_it_went{{0.8125f, 0.0625f, -1}, {0, 0, 1}};
  EXPECT_NEAR(occupied_intervals(where_it_went, volume, 0, 10, found, &bend), 1.5f, 1e-6);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].near, 1.25f, 1e-6);
  found.clear();
  const FieldRay from_outside{{0.0625f, 0.0625f, -1}, {0, 0, 1}};  // its place lies at x = -0.19
  occupied_intervals(from_outside, volume, 0, 10, found, &bend);
  EXPECT_TRUE(found.empty());
}

TEST(OccupiedIntervals, MissNothingOfABentNeckOutsideItsBox) {
  std::mt19937 engine(8);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int found = 0;
  for (int trial = 0; trial < 40; ++trial) {
    OccupancyGrid grid = make_occupancy(32, false);
    const OccupancyGrid none;
    for (int y = 0; y < 14; ++y)
      for (int i = 0; i < 6; ++i)
        set_occupied(grid, 16 + int(6 * uniform(engine)), y, 16 + int(6 * uniform(engine)), true);
    Pose pose = Pose::Identity();
    const Vec3d axis = Vec3d(uniform(engine), uniform(engine), 1).normalized();
    pose.rotate(rotation_about(axis, 0.6 * uniform(engine)));
    const Vec3d middle(0.5, 0.3, 0.5);
    pose.translation() = middle - pose.linear() * middle + 0.05 * Vec3d(uniform(engine), 0, uniform(engine));
    const NeckBend bend = make_neck_bend({0.15f, 0.45f, middle.cast<float>()}, pose);
    const MarchVolume volume = march_volume(grid, none);
    const MarchNeck tight = march_neck(bend, volume);
    const MarchNeck whole{&bend, {Vec3f::Zero(), Vec3f::Ones()}};
    for (int r = 0; r < 200; ++r) {
      FieldRay ray = random_ray(engine);
      ray.origin.y() -= 0.25f;
      std::vector<Interval> a, b;
      occupied_intervals(ray, volume, 0, 10, a, &tight);
      occupied_intervals(ray, volume, 0, 10, b, &whole);
      float length_a = 0, length_b = 0;
      for (const Interval& i : a) length_a += i.far - i.near;
      for (const Interval& i : b) length_b += i.far - i.near;
      EXPECT_NEAR(length_a, length_b, 1e-4f) << "trial " << trial << " ray " << r;
      found += !a.empty();
    }
  }
  EXPECT_GT(found, 1000);
}

// Looked up once, the cells of a bent neck hold what every ray would find in them.
TEST(OccupiedIntervals, AreTheSameThroughAPrecomputedNeck) {
  std::mt19937 engine(9);
  const OccupancyGrid grid = random_grid(32, 0.1, 10), core = random_grid(32, 0.002, 11);
  std::vector<std::uint8_t> opacity(32 * 32 * 32);
  for (std::uint8_t& o : opacity) o = std::uint8_t(engine() % 200);
  Pose pose = Pose::Identity();
  pose.rotate(rotation_about(Vec3d(0.2, 0.3, 1).normalized(), 0.3));
  const NeckBend bend = make_neck_bend({0.2f, 0.6f, {0.5f, 0.4f, 0.5f}}, pose);
  const MarchVolume volume = march_volume(grid, core, 1, opacity);
  const MarchNeck each = march_neck(bend, volume);
  MarchNeck once = each;
  look_up_neck(volume, once);
  ASSERT_FALSE(once.cells.empty());
  int below = 0;
  for (int r = 0; r < 2000; ++r) {
    const FieldRay ray = random_ray(engine);
    std::vector<Interval> a, b;
    EXPECT_EQ(occupied_intervals(ray, volume, 0, 10, a, &each),
              occupied_intervals(ray, volume, 0, 10, b, &once));
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].near, b[i].near);
      EXPECT_EQ(a[i].far, b[i].far);
      EXPECT_EQ(a[i].depth, b[i].depth);
      below += ray.origin.y() + a[i].near * ray.direction.y() < bend.top;
    }
  }
  EXPECT_GT(below, 1000);
}

TEST(OccupiedIntervals, AreEmptyForARayBesideTheCube) {
  const OccupancyGrid all = make_occupancy(8, true), none;
  std::vector<Interval> intervals;
  EXPECT_EQ(occupied_intervals({{2, 2, -1}, {0, 0, 1}}, march_volume(all, none), 0, 10, intervals), 10.f);
  EXPECT_TRUE(intervals.empty());
}

TEST(FieldRay, ReachesTheProjectedPointAtItsDistance) {
  Intrinsics k{64, 64, 90, 95, 31, 33, 0.12, -0.05, 0.002, -0.001};
  Pose cam_from_world = Pose::Identity();
  cam_from_world.rotate(rotation_about(Vec3d(1, 2, 0.5).normalized(), 0.3));
  cam_from_world.pretranslate(Vec3d(0.02, -0.03, 0.7));
  Pose world_from_head = Pose::Identity();
  world_from_head.rotate(rotation_about(Vec3d::UnitY(), -0.5));
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

// What meets_volume noted spares a walk, and changes no sample: not behind a core either.
TEST(SampleRays, StartingAtTheFirstHitChangesNothing) {
  const OccupancyGrid head = random_grid(16, 0.1, 7), torso = random_grid(16, 0.1, 8),
                      core = random_grid(16, 0.02, 9), none;
  MarchVolumes volumes;
  volumes.fields[0] = {&head, &core, 1.f};
  volumes.fields[1] = {&torso, &none, 1.f};
  volumes.near = 0;
  std::mt19937 engine(10);
  std::vector<RayRequest> rays(500);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    rays[r].fields = {random_ray(engine), random_ray(engine)};
    rays[r].jitter = r + 1;
  }
  SampleBatch whole, begun;
  sample_rays(rays, volumes, whole);
  int later = 0;
  for (RayRequest& ray : rays) {
    meets_volume(ray, volumes);
    later += ray.nothing_before[0] > 0.1f;
  }
  EXPECT_GT(later, 100);
  sample_rays(rays, volumes, begun);
  ASSERT_EQ(begun.begin, whole.begin);
  for (int f = 0; f < 2; ++f)
    for (std::size_t i = 0; i < whole.fields[f].count(); ++i) {
      const FieldSamples &a = whole.fields[f], &b = begun.fields[f];
      EXPECT_NEAR(a.x[i], b.x[i], 1e-5f);
      EXPECT_NEAR(a.y[i], b.y[i], 1e-5f);
      EXPECT_NEAR(a.z[i], b.z[i], 1e-5f);
    }
}

// The strata of a ray are its samples without jitter, and their intervals are those of its walk.
TEST(StratifyRays, MatchTheMidpointsThatSampleRaysTakes) {
  const OccupancyGrid head = random_grid(8, 0.4, 3), torso = random_grid(8, 0.4, 4), none;
  MarchVolumes volumes;
  volumes.fields[0] = {&head, &none, 1.f};
  volumes.fields[1] = {&torso, &none, 1.f};
  volumes.near = 0, volumes.max_samples = 12;
  std::mt19937 engine(6);
  std::vector<RayRequest> rays(300);
  for (RayRequest& ray : rays) ray.fields = {random_ray(engine), random_ray(engine)};
  SampleBatch samples, batch;
  RayStrata strata;
  sample_rays(rays, volumes, samples);
  stratify_rays(rays, volumes, 12, batch, strata);
  EXPECT_EQ(batch.begin, samples.begin);
  EXPECT_EQ(batch.dt, samples.dt);
  EXPECT_EQ(batch.field, samples.field);
  EXPECT_EQ(batch.fields[0].x, samples.fields[0].x);
  ASSERT_EQ(strata.strata.size(), batch.dt.size());
  for (std::size_t r = 0; r < rays.size(); ++r)
    for (int f = 0; f < 2; ++f) {
      std::vector<Interval> walked;
      occupied_intervals(rays[r].fields[std::size_t(f)], volumes.fields[std::size_t(f)], 0, 20, walked);
      const auto kept = strata.intervals_of(r, f);
      ASSERT_EQ(kept.size(), walked.size());
      for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i].near, walked[i].near);
    }
}

}  // namespace
}  // namespace likeness
