// What is asked of each step of a training (training_step.h).
#pragma once

#include <cstdint>

#include "core/render/ray_samples.h"

namespace likeness {

inline constexpr int kTrainingSamples = 16;  // of a ray, at most

struct StepOptions {
  int rays = 8192;
  std::uint64_t seed = 0;
  bool use_latent = true, use_occupancy = true;
  float even_samples = kEvenShare;
  double landmark_weight = 0;  // lambda of the landmark loss
};

}  // namespace likeness
