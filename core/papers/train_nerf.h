// Trains the baselines' fields on the same set as core/train does: rays drawn alike, the same track, torso
// modes, neck, plate and loss. Head and torso have a pair of fields each, the torso's smaller and a function
// of the position only, as in our own trainer. There is no per-frame code. Deterministic for one seed,
// whatever the threads.
#pragma once

#include <functional>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/papers/nerf_march.h"
#include "core/train/train.h"

namespace likeness {

struct NerfOptions {
  FieldMode mode = FieldMode::concat;  // any but warp+hyper, which no paper uses
  double budget_s = 300;               // by `clock`; ignored when steps > 0
  std::uint64_t steps = 0;
  WorkClock clock = WorkClock::wall;
  int rays_per_step = 256;
  std::uint64_t seed = 0;
  double rate = 5e-4;  // of Adam, over the schedule of core/train
  NerfMarchOptions march;
  NerfConfig head;  // condition_count and slice are set by the mode
  NerfConfig torso{.direction_frequencies = 0, .width = 128, .layers = 4, .skip = 2};
};

// A look at the running training, during which its clock stops.
struct NerfTap {
  std::function<bool(const TrainStatus&)> wanted;  // asked after every step
  std::function<void(const NerfAvatar&, const TrainStatus&)> take;
};

Result<NerfAvatar> train_nerf(const TrainingSet& set, const NerfOptions& options, const Progress& progress,
                              std::stop_token stop, const NerfTap& tap = {});

}  // namespace likeness
