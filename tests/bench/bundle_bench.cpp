// What the bundle adjustment of a head costs whose points are seen again throughout the clip, by how the
// poses are solved for.
#include <benchmark/benchmark.h>

#include <random>

#include "core/base/rigid.h"
#include "core/track/points/bundle.h"

namespace likeness {
namespace {

struct Turning {
  std::vector<BundleFrame> frames;
  std::vector<BundleTrack> tracks;
};

// A head that turns from side to side four times in 400 frames; each point is seen whenever it faces the
// camera.
const Turning& turning() {
  static const Turning scene = [] {
    Turning made;
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const Mat3d facing = Vec3d(1, -1, -1).asDiagonal();
    for (int i = 0; i < 400; ++i) {
      BundleFrame frame{true, 1000, Pose::Identity()};
      const double yaw = 0.6 * std::sin(i * 0.063);
      frame.cam_from_head.linear() = facing * rotation_about(Vec3d::UnitY(), yaw);
      frame.cam_from_head.translation() = Vec3d(0.02 * std::sin(i * 0.1), 0, 0.7);
      made.frames.push_back(frame);
    }
    for (int t = 0; t < 600; ++t) {
      const Vec3d side = Vec3d(normal(random), normal(random), std::abs(normal(random)) + 0.3).normalized();
      const Vec3d point = side.cwiseProduct(Vec3d(0.075, 0.11, 0.1));
      BundleTrack track;
      track.point = point + 0.003 * Vec3d(normal(random), normal(random), normal(random));
      for (int i = 0; i < 400; ++i) {
        const Pose& pose = made.frames[std::size_t(i)].cam_from_head;
        if ((pose.linear() * side).z() > -0.5) continue;
        const Vec2d noise(normal(random), normal(random));
        track.seen.push_back({i, (pose * point).hnormalized() + 0.5e-3 * noise});
      }
      made.tracks.push_back(std::move(track));
    }
    for (BundleFrame& frame : made.frames)
      frame.cam_from_head.translation() += 0.004 * Vec3d(normal(random), normal(random), normal(random));
    return made;
  }();
  return scene;
}

void BM_Bundle(benchmark::State& state) {
  BundleOptions options;
  options.max_dense = int(state.range(0));
  for (auto _ : state) {
    Turning scene = turning();
    benchmark::DoNotOptimize(bundle_adjust(scene.frames, scene.tracks, options, Progress(), {}).ok());
  }
}
BENCHMARK(BM_Bundle)->ArgName("max_dense")->Arg(200)->Arg(0)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
