// A claim about training in the kernels' arithmetic (core/field/network_math.h and its like), run by the
// emulated device: after equal steps it is as good as the processor's, in single precision and with bfloat16
// products; and so is the processor with bfloat16 products.
#include <gtest/gtest.h>

#include <cmath>

#include "core/image/metrics.h"
#include "core/render/backend.h"
#include "core/render/pose_avatar.h"
#include "tests/core/device/emulated_device.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

constexpr std::uint64_t kSteps = 144;  // past the first looks at the occupancy

// Mean over unseen poses, dB.
double quality(const TrainingSet& set, std::uint64_t seed, std::shared_ptr<Backend> backend) {
  TrainOptions options;
  options.schedule.steps = kSteps, options.rays.per_step = 192, options.seed = seed,
  options.place.backend = std::move(backend);
  const auto avatar = train_avatar(set, options, {}, Progress(), {}, {});
  EXPECT_TRUE(avatar.ok()) << avatar.error().what;
  if (!avatar) return 0;
  const AvatarRig rig = *make_rig(*avatar, set.model);
  double sum = 0;
  const double times[] = {0.2, 1.3, 2.9};
  for (const double time : times) {
    const TrainingView truth = ball_view(gradient_plate(set.size), set.size, time);
    const RenderedFrame frame = render_frame(*avatar, truth.camera, pose_avatar(rig, truth.pose));
    sum += psnr_from_mse(mse(composite(frame.rgba, gradient_plate(set.size)), to_float(truth.rgb)));
  }
  return sum / std::size(times);
}

TEST(BackendQuality, AfterEqualStepsIsTheProcessorsWithinTheSpreadOfSeeds) {
  const TrainingSet set = ball_set(24, 32);
  double lowest = 1e9, highest = 0, rounded = 0, single = 0, halves = 0;
  for (const std::uint64_t seed : {0, 1, 2}) {
    const double own = quality(set, seed, cpu_backend(FieldPrecision::exact));
    lowest = std::min(lowest, own), highest = std::max(highest, own);
    const double words = quality(set, seed, cpu_backend(FieldPrecision::bf16));
    const double one = quality(set, seed, device_backend(emulated_device(), false));
    const double other = quality(set, seed, device_backend(emulated_device(), true));
    std::printf("seed %d: processor in single precision %.2f dB, with bfloat16 %.2f, device %.2f and %.2f\n",
                int(seed), own, words, one, other);
    rounded += words / 3, single += one / 3, halves += other / 3;
  }
  const double spread = std::max(0.5, highest - lowest);
  EXPECT_GT(lowest, 20);
  EXPECT_GT(rounded, lowest - spread);
  EXPECT_GT(single, lowest - spread);
  EXPECT_GT(halves, lowest - spread);
}

}  // namespace
}  // namespace likeness
