// What a ray costs before its first sample, with and without what makes it cheaper; and how far its colour is
// from the exact one by the number of samples, evenly placed or where the light is lost.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/base/rigid.h"
#include "core/render/composite.h"
#include "core/render/rays.h"

namespace likeness {
namespace {

constexpr int kCells = 96;
constexpr float kRadius = 0.35f;        // of the head, in cube sides
constexpr float kThickness = 0.012f;    // of its skin
constexpr float kMaxDensity = 1500.0f;  // per cube side

float density_at(const Vec3f& p) {
  const float off = ((p - Vec3f::Constant(0.5f)).norm() - kRadius) / kThickness;
  return kMaxDensity * std::exp(-off * off);
}

Vec3f colour_at(const Vec3f& p) {
  return {0.5f + 0.4f * std::sin(40 * p.x()), 0.5f + 0.4f * std::sin(31 * p.y()),
          0.5f + 0.4f * std::cos(37 * p.z())};
}

// A ball's skin as a trained field has it, its deep inside core.
struct Ball {
  OccupancyGrid occupancy = make_occupancy(kCells, false), core = make_occupancy(kCells, false);
  std::vector<std::uint8_t> opacity = std::vector<std::uint8_t>(std::size_t(kCells) * kCells * kCells, 0);

  Ball() {
    for (int z = 0; z < kCells; ++z)
      for (int y = 0; y < kCells; ++y)
        for (int x = 0; x < kCells; ++x) {
          const Vec3f p = (Vec3f(float(x), float(y), float(z)) + Vec3f::Constant(0.5f)) / float(kCells);
          const float r = (p - Vec3f::Constant(0.5f)).norm();
          if (r < kRadius - 0.08f) set_occupied(core, x, y, z, true);
          if (std::abs(r - kRadius) > 0.06f) continue;
          set_occupied(occupancy, x, y, z, true);
          opacity[(std::size_t(z) * kCells + y) * kCells + x] =
              std::uint8_t(255.5f * (1 - std::exp(-density_at(p) / float(kCells))));
        }
  }
};

const Ball& ball() {
  static const Ball it;
  return it;
}

std::vector<FieldRay> rays(bool at_the_ball) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-0.5f, 0.5f);
  std::vector<FieldRay> list(2048);
  for (FieldRay& ray : list) {
    const float reach = at_the_ball ? 0.6f : 1.0f;
    const Vec3f through = Vec3f::Constant(0.5f) + reach * Vec3f(uniform(random), uniform(random), 0);
    const Vec3f from(0.5f, 0.5f, -1.5f);
    ray = {from, (through - from).normalized()};
  }
  return list;
}

MarchVolume volume(bool bricks, bool opacity) {
  MarchVolume v = march_volume(ball().occupancy, ball().core, 1);
  if (opacity) v.opacity = ball().opacity;
  if (!bricks) std::fill(v.bricks.begin(), v.bricks.end(), 1);
  return v;
}

// Argument: passing over empty bricks.
void BM_Walk(benchmark::State& state) {
  const auto list = rays(false);
  const MarchVolume v = volume(state.range(0) != 0, true);
  std::vector<Interval> intervals;
  for (auto _ : state)
    for (const FieldRay& ray : list) {
      intervals.clear();
      benchmark::DoNotOptimize(occupied_intervals(ray, v, 0, 10, intervals));
    }
  state.SetItemsProcessed(state.iterations() * std::int64_t(list.size()));
}
BENCHMARK(BM_Walk)->Arg(0)->Arg(1);

// The ball on a neck, in the lower third of the cube.
OccupancyGrid ball_on_neck() {
  OccupancyGrid grid = ball().occupancy;
  for (int z = 0; z < kCells; ++z)
    for (int y = 0; y < kCells / 3; ++y)
      for (int x = 0; x < kCells; ++x)
        set_occupied(grid, x, y, z,
                     std::hypot(float(x) - 0.5f * kCells, float(z) - 0.5f * kCells) < 0.15f * kCells);
  return grid;
}

// Argument: 0 straightening every cell below the neck's top, 1 those in the neck's box only, 2 looked up
// before.
void BM_WalkWithABentNeck(benchmark::State& state) {
  const auto list = rays(false);
  const OccupancyGrid grid = ball_on_neck();
  const MarchVolume v = march_volume(grid, ball().core, 1, ball().opacity);
  Pose turned = Pose::Identity();
  turned.rotate(rotation_about(Vec3d::UnitY(), 0.2));
  const NeckBend bend = make_neck_bend({0.15f, 0.33f, {0.5f, 0.24f, 0.5f}}, turned);
  MarchNeck neck = march_neck(bend, v);
  if (state.range(0) == 0) neck.box = {Vec3f::Zero(), Vec3f::Ones()};
  if (state.range(0) == 2) look_up_neck(v, neck);
  std::vector<Interval> intervals;
  for (auto _ : state)
    for (const FieldRay& ray : list) {
      intervals.clear();
      benchmark::DoNotOptimize(occupied_intervals(ray, v, 0, 10, intervals, &neck));
    }
  state.SetItemsProcessed(state.iterations() * std::int64_t(list.size()));
}
BENCHMARK(BM_WalkWithABentNeck)->DenseRange(0, 2);

Vec3f composited(const FieldRay& ray, std::span<const RaySample> samples) {
  std::vector<float> sigma, dt, colour;
  for (const RaySample& s : samples) {
    const Vec3f p = ray.origin + s.t * ray.direction, c = colour_at(p);
    sigma.push_back(density_at(p)), dt.push_back(s.dt);
    colour.insert(colour.end(), c.data(), c.data() + 3);
  }
  const auto out = composite_ray(int(samples.size()), sigma.data(), dt.data(), colour.data());
  return {out.colour[0], out.colour[1], out.colour[2]};
}

// Arguments: samples a ray; by the cells' opacity. Counter: rms distance of the colour to that of 4096
// samples.
void BM_Place(benchmark::State& state) {
  const auto list = rays(true);
  const MarchVolume v = volume(true, state.range(1) != 0);
  std::vector<std::vector<Interval>> intervals(list.size());
  std::vector<RaySample> samples(std::size_t(state.range(0))), many(4096);
  double sum = 0;
  for (std::size_t r = 0; r < list.size(); ++r) {
    occupied_intervals(list[r], v, 0, 10, intervals[r]);
    const int n = place_samples(intervals[r], {}, 1e-4f, kEvenShare, 0, samples),
              most = place_samples(intervals[r], {}, 1e-6f, kEvenShare, 0, many);
    sum += (composited(list[r], {samples.data(), std::size_t(n)}) -
            composited(list[r], {many.data(), std::size_t(most)}))
               .squaredNorm();
  }
  for (auto _ : state)
    for (const auto& list_of : intervals)
      benchmark::DoNotOptimize(place_samples(list_of, {}, 1e-4f, kEvenShare, 0, samples));
  state.SetItemsProcessed(state.iterations() * std::int64_t(list.size()));
  state.counters["rms"] = std::sqrt(sum / double(3 * list.size()));
}
BENCHMARK(BM_Place)->ArgsProduct({{4, 8, 16, 32}, {0, 1}});

// Arguments: strata whose densities are looked up; samples placed by them. Counter as above; the time is of
// the placing alone.
void BM_Refine(benchmark::State& state) {
  const auto list = rays(true);
  const MarchVolume v = volume(true, true);
  std::vector<std::vector<Interval>> intervals(list.size());
  std::vector<std::vector<RayStratum>> strata(list.size());
  std::vector<std::vector<float>> weights(list.size());
  std::vector<RaySample> samples(std::size_t(state.range(1))), many(4096);
  double sum = 0;
  for (std::size_t r = 0; r < list.size(); ++r) {
    occupied_intervals(list[r], v, 0, 10, intervals[r]);
    strata[r].resize(std::size_t(state.range(0)));
    strata[r].resize(std::size_t(place_strata(intervals[r], {}, 1e-4f, strata[r])));
    float transmittance = 1;
    for (const RayStratum& s : strata[r]) {
      const float after =
          transmittance *
          std::exp(-density_at(list[r].origin + s.sample.t * list[r].direction) * s.sample.dt);
      weights[r].push_back(transmittance - after);
      transmittance = after;
    }
    const int n = refine_strata(intervals[r], {}, strata[r], weights[r], samples),
              most = place_samples(intervals[r], {}, 1e-6f, kEvenShare, 0, many);
    sum += (composited(list[r], {samples.data(), std::size_t(n)}) -
            composited(list[r], {many.data(), std::size_t(most)}))
               .squaredNorm();
  }
  for (auto _ : state)
    for (std::size_t r = 0; r < list.size(); ++r)
      benchmark::DoNotOptimize(refine_strata(intervals[r], {}, strata[r], weights[r], samples));
  state.SetItemsProcessed(state.iterations() * std::int64_t(list.size()));
  state.counters["rms"] = std::sqrt(sum / double(3 * list.size()));
}
BENCHMARK(BM_Refine)->ArgsProduct({{8, 16}, {4, 8, 12, 16}});

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
