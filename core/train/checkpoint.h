// checkpoint.bin: everything a training run needs to continue as if it had never stopped.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "core/train/train.h"
#include "core/train/training_state.h"

namespace likeness {

// Hash of everything that must agree for a checkpoint to continue: pictures, track, cameras, model, seed,
// switches. The length of the run is excluded: a longer budget may continue a shorter one.
std::string training_fingerprint(const TrainingSet& set, const TrainOptions& options);

Result<void> write_checkpoint(const std::filesystem::path& path, const TrainingState& state,
                              const std::string& fingerprint);

// Fills `state`, made for the same set and options, from the file. An Error leaves `state` untouched; its
// code is not_found when there is no file and bad_input when the file is damaged or belongs to other inputs.
Result<void> read_checkpoint(const std::filesystem::path& path, const std::string& fingerprint,
                             TrainingState& state);

}  // namespace likeness
