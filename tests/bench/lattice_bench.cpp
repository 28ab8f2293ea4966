// What a pose's warp lattice costs to make, and what a look-up in it does, beside the same in a lattice that
// keeps every node: at places spread over one lattice, as a picture is rendered, and along a few rays of each
// of many, as a step of training asks.
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "core/head/builtin_head.h"
#include "core/scene/warp_lattice.h"
#include "tests/core/scene/warp_lattice_reference.h"

namespace likeness {
namespace {

constexpr int kViews = 400, kRays = 20, kSamples = 16;  // a ray has its samples near the face's front

struct Queries {
  std::vector<int> view;
  std::vector<Vec3f> place;  // head frame, m
};

Queries make_queries(int views) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> across(-0.08f, 0.08f), height(-0.12f, 0.08f), depth(-0.04f, 0.02f);
  Queries queries;
  for (int ray = 0; ray < kViews * kRays; ++ray) {
    const Vec3f from(across(random), height(random), 0.06f + depth(random));
    for (int s = 0; s < kSamples; ++s) {
      queries.view.push_back(ray * views / (kViews * kRays));
      queries.place.push_back(from - Vec3f(0, 0, 0.004f * float(s)));
    }
  }
  return queries;
}

struct PosedFace {
  WarpFrame frame;
  std::vector<Vec3f> posed;
};

const PosedFace& posed_face() {
  static const PosedFace face = [] {
    const HeadModel model = make_builtin_head();
    const HeadShape shape = shape_head(model, {Eigen::VectorXf::Zero(model.identity_count()), {}});
    Articulation open = neutral_articulation(model);
    const WarpFrame frame = *make_warp_frame(model, shape, open);
    open.jaw.x() = 0.1f;
    return PosedFace{frame, pose_head(model, shape, open)};
  }();
  return face;
}

const WarpLattice& lattice() {
  static const WarpLattice made = make_warp_lattice(posed_face().frame, posed_face().posed);
  return made;
}

template <class Lattice>
void look_up(benchmark::State& state, const Lattice& one) {
  const auto views = std::size_t(state.range(0));
  const std::vector<Lattice> lattices(views, one);
  const Queries queries = make_queries(int(views));
  for (auto _ : state)
    for (std::size_t i = 0; i < queries.place.size(); ++i)
      benchmark::DoNotOptimize(displacement_at(lattices[std::size_t(queries.view[i])], queries.place[i]));
  state.SetItemsProcessed(state.iterations() * std::int64_t(queries.place.size()));
}

// A pose's lattice, and the same by plain loops.
void BM_MakeLattice(benchmark::State& state) {
  const PosedFace& face = posed_face();
  for (auto _ : state) benchmark::DoNotOptimize(make_warp_lattice(face.frame, face.posed));
}
BENCHMARK(BM_MakeLattice);

void BM_MakeLatticeReference(benchmark::State& state) {
  const PosedFace& face = posed_face();
  for (auto _ : state) benchmark::DoNotOptimize(warp_lattice_reference(face.frame, face.posed));
}
BENCHMARK(BM_MakeLatticeReference);

void BM_LookUp(benchmark::State& state) { look_up(state, lattice()); }
BENCHMARK(BM_LookUp)->Arg(1)->Arg(kViews);

void BM_LookUpDense(benchmark::State& state) { look_up(state, dense_lattice(lattice())); }
BENCHMARK(BM_LookUpDense)->Arg(1)->Arg(kViews);

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
