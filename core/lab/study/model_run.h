// One model of the study trained and scored. Internal to core/lab/study.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/face/landmarks.h"
#include "core/lab/score/perceptual_network.h"
#include "core/lab/score/sized_clip.h"
#include "core/lab/study/model_rows.h"
#include "core/lab/study/model_scores.h"
#include "core/lab/study/model_study_options.h"
#include "core/project/project_attributes.h"
#include "core/train/choose_parts.h"
#include "core/train/mode.h"

namespace likeness {

// What all trainings of a study share.
struct StudyBench {
  const ModelStudyOptions& options;
  const std::filesystem::path& folder;  // of the pictures
  SizedClip clip;
  int full_size = 0;  // px: of the project
  FaceDetector detector;
  std::optional<PerceptualNetwork> perceptual;
  std::vector<FoundAttribute> attributes;  // of a model that knows them; otherwise not looked for
  std::string painted;                     // hash of what the user painted of them; empty: nothing
  std::vector<std::size_t> measured;       // of clip.held_out
  std::vector<std::size_t> marked, shown;  // of `measured`
};

// The trainer's choice for the study's pictures; `mode` asks for another than a build's.
ChosenParts chosen_parts(const StudyBench& bench, FieldMode mode);

// steps: exactly these, or 0: by the study's seconds. Writes the shown pictures of the first seed as
// NAME-000360.png.
Result<ModelScore> run_model(const StudyBench& bench, const ModelSpec& spec, std::uint64_t seed,
                             std::uint64_t steps, const Progress& progress, std::stop_token stop);

std::string picture_name(const ModelSpec& spec, int frame);

}  // namespace likeness
