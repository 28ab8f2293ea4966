// What one opening of the mouth costs that is asked of a picture: the mouth posed by itself, beside the whole
// face and the head model it is part of.
#include <benchmark/benchmark.h>

#include "core/head/builtin_head.h"
#include "core/track/photo/photometric_surface.h"

namespace likeness {
namespace {

struct Face {
  HeadModel model = make_builtin_head();
  HeadShape shape = shape_head(model, Eigen::VectorXf());
  FaceSurface surface = face_surface(model, shape);
  Eigen::VectorXd expression = Eigen::VectorXd::Constant(model.expression_count(), 0.1);
};
const Face& face() {
  static const Face f;
  return f;
}

void BM_MouthByItself(benchmark::State& state) {
  const Face& f = face();
  for (auto _ : state) benchmark::DoNotOptimize(posed_surface(f.surface.mouth, f.expression, 0.2));
}
BENCHMARK(BM_MouthByItself);

void BM_MouthWithFaceAndHead(benchmark::State& state) {
  const Face& f = face();
  Articulation articulation = neutral_articulation(f.model);
  articulation.expression = f.expression.cast<float>();
  articulation.jaw.x() = 0.2f;
  for (auto _ : state) {
    benchmark::DoNotOptimize(posed_surface(f.surface, f.expression, 0.2));
    benchmark::DoNotOptimize(pose_head(f.model, f.shape, articulation));
  }
}
BENCHMARK(BM_MouthWithFaceAndHead);

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
