// The memory a training will take, known before its pictures are read.
#pragma once

#include <cstdint>

#include "core/train/train.h"

namespace likeness {

struct MemoryForecast {
  std::uint64_t pictures = 0;  // bytes: the views' colours and mattes
  std::uint64_t lattices = 0;  // their warp lattices
  std::uint64_t engine = 0;    // fields, optimiser, the samples of a step, and the program itself
  std::uint64_t total() const { return pictures + lattices + engine; }
};

// For a set whose pictures need not be loaded.
MemoryForecast forecast_memory(const TrainingSet& set, const TrainOptions& options);
// When only the number and size of the training pictures are known.
MemoryForecast forecast_memory(std::size_t views, int size, const HeadModel& model,
                               const TrainOptions& options);

// If there is not enough, the error says how much is needed and what to do. available: bytes.
Result<void> check_memory(const MemoryForecast& forecast, std::uint64_t available);

}  // namespace likeness
