// What each stage reads of a project's options, listed once: runner, hash, forecast and training take these
// and never the options themselves. An option that a stage reads is a member here, and a member is either in
// the stage's hash or left out of it with the reason (staleness.cpp does not compile before).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/capture/capture.h"
#include "core/project/project.h"
#include "core/track/clip/refit_span.h"
#include "core/train/mode.h"

namespace likeness {

// Units and what empty means: ProjectOptions. What a stage reads of other stages' results is not here.
struct ImportInputs {
  std::filesystem::path video, landmark_model;
  int size = 0;
  Split split = Split::tail;
  bool resting_camera = false;
};

struct AlignInputs {
  std::filesystem::path video, landmark_model;
  std::uint64_t seed = 0;
  bool resting_camera = false;
  double lens_mm = 0;
};

struct FitInputs {
  std::filesystem::path video, head_model, landmark_model, identity, displacement;
  std::vector<RefitSpan> refits;  // merged
};

struct MatteInputs {
  std::filesystem::path head_model, matting_network;
  std::uint64_t seed = 0;
};

struct TrainInputs {
  std::filesystem::path head_model;
  double budget_s = 0;
  std::uint64_t steps = 0, seed = 0;
  double checkpoint_every_s = 0;
  std::optional<FieldMode> mode;
  bool use_latent = true, use_occupancy = true, refine_track = false;
  double landmark_loss = 0;
  std::vector<int> left_out;
};

struct StageInputs {
  ImportInputs import;
  AlignInputs align;
  FitInputs fit;
  MatteInputs matte;
  TrainInputs train;
};

StageInputs stage_inputs(const ProjectOptions& options);

}  // namespace likeness
