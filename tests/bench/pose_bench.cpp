// What posing an avatar costs before its first ray: the head model's vertices and their lattice, beside the
// same in plain loops on one thread.
#include <benchmark/benchmark.h>

#include "core/head/builtin_head.h"
#include "core/scene/warp_lattice.h"
#include "tests/core/scene/warp_lattice_reference.h"

namespace likeness {
namespace {

struct Person {
  HeadModel model = make_builtin_head();
  HeadShape shape = shape_head(model, Eigen::VectorXf());
  WarpFrame frame = *make_warp_frame(model, shape, neutral_articulation(model));
  Articulation articulation = neutral_articulation(model);
  std::vector<Vec3f> posed;

  Person() {
    articulation.expression.setConstant(0.1f);
    articulation.jaw.x() = 0.1f;
    posed = pose_head(model, shape, articulation);
  }
};
const Person& person() {
  static const Person p;
  return p;
}

void BM_Vertices(benchmark::State& state) {
  const Person& p = person();
  for (auto _ : state) benchmark::DoNotOptimize(pose_head(p.model, p.shape, p.articulation));
}
BENCHMARK(BM_Vertices)->UseRealTime();

// One blend shape after the other over all vertices.
void BM_BlendShapesPlain(benchmark::State& state) {
  const Person& p = person();
  for (auto _ : state) {
    std::vector<Vec3f> vertices = p.shape.vertices;
    Eigen::Map<Eigen::VectorXf> flat(vertices.front().data(), 3 * p.model.vertex_count());
    for (Eigen::Index e = 0; e < p.articulation.expression.size(); ++e)
      flat += p.articulation.expression[e] * p.model.expression_basis.col(e);
    benchmark::DoNotOptimize(vertices);
  }
}
BENCHMARK(BM_BlendShapesPlain)->UseRealTime();

void BM_Lattice(benchmark::State& state) {
  const Person& p = person();
  for (auto _ : state) benchmark::DoNotOptimize(make_warp_lattice(p.frame, p.posed));
}
BENCHMARK(BM_Lattice)->UseRealTime();

void BM_LatticePlain(benchmark::State& state) {
  const Person& p = person();
  for (auto _ : state) benchmark::DoNotOptimize(warp_lattice_reference(p.frame, p.posed));
}
BENCHMARK(BM_LatticePlain)->UseRealTime();

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
