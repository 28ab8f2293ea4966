// What each stage reads of a project's options, listed once: runner, hash, forecast and training take these
// and never the options themselves. A stage has all of its own choices, and of the shared ones and of other
// stages' those named here; each is either in the stage's hash or left out of it with the reason
// (staleness.cpp does not compile before).
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/project/project_options.h"

namespace likeness {

// Units and what empty means: project_options.h. What a stage reads of other stages' results is not here.
struct ImportInputs {
  std::filesystem::path video, landmark_model, person_network;
  std::optional<CameraKind> camera;
  ImportChoices choices{};
};

struct AlignInputs {
  std::filesystem::path video, landmark_model, person_network;
  std::uint64_t seed = 0;
  Split split = Split::tail;  // a hand-held camera's held-out frames say nothing about its other ones
  SideRange sides{};
  AlignChoices choices{};
};

struct FitInputs {
  std::filesystem::path video, head_model, landmark_model;
  FitChoices choices{};  // the spans merged
};

struct MatteInputs {
  std::filesystem::path head_model, person_network;
  std::uint64_t seed = 0;
  MatteChoices choices{};
};

struct TrainInputs {
  std::filesystem::path head_model;
  std::uint64_t seed = 0;
  TrainChoices choices{};
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
