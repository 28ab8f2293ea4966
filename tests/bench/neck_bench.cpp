// What a bent neck costs a sample, beside the look-up of the warp lattice that every head sample pays.
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/scene/neck_bend.h"
#include "core/scene/warp_lattice.h"

namespace likeness {
namespace {

std::vector<Vec3f> places_in(float low, float high) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> across(-0.06f, 0.06f), height(low, high);
  std::vector<Vec3f> places(4096);
  for (Vec3f& p : places) p = {across(random), height(random), across(random)};
  return places;
}

template <class F>
void run(benchmark::State& state, const std::vector<Vec3f>& places, const F& look_up) {
  for (auto _ : state)
    for (const Vec3f& p : places) benchmark::DoNotOptimize(look_up(p));
  state.SetItemsProcessed(state.iterations() * std::int64_t(places.size()));
}

void BM_Straightened(benchmark::State& state) {
  Pose turned = Pose::Identity();
  turned.rotate(rotation_about(Vec3d(0.2, 1, 0.1).normalized(), 0.01 * double(state.range(0))));
  const NeckBend bend = make_neck_bend({-0.16f, -0.12f, {0, -0.14f, -0.02f}}, turned);
  const bool lanes = state.range(1) != 0;
  run(state, places_in(-0.19f, -0.12f),
      [&](const Vec3f& p) { return lanes ? straightened_in_lanes(bend, p) : straightened(bend, p); });
}
BENCHMARK(BM_Straightened)->ArgsProduct({{0, 20, 60}, {0, 1}});  // hundredths of a radian; in lanes

void BM_WarpLattice(benchmark::State& state) {
  const HeadModel model = make_builtin_head();
  const HeadShape shape = shape_head(model, {Eigen::VectorXf::Zero(model.identity_count()), {}});
  const Articulation rest = neutral_articulation(model);
  const WarpFrame frame = *make_warp_frame(model, shape, rest);
  Articulation open = rest;
  open.jaw.x() = 0.2f;
  const WarpLattice lattice = make_warp_lattice(frame, pose_head(model, shape, open));
  run(state, places_in(-0.1f, 0.05f), [&](const Vec3f& p) { return displacement_at(lattice, p); });
}
BENCHMARK(BM_WarpLattice);

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
