// Is the camera's kind found rightly? Made clips are filmed and aligned as a project would, with the coarse
// mask of the person, and what is found is put beside the truth.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/align_options.h"
#include "core/lab/truth/kind_clips.h"
#include "core/lab/truth/spent_seconds.h"
#include "core/lab/truth/view_truth.h"

namespace likeness {

struct KindRow {
  KindClip clip;
  CameraKind truth = CameraKind::resting;
  std::optional<KindFound> found;  // nullopt: the stage failed
  KindOutcome outcome = KindOutcome::wrong;
  std::optional<ViewErrors> views;
  std::string evidence;  // what the stage said, or its failure with the remedy
  std::vector<std::string> warnings;
  SpentSeconds align;  // the stage alone, without the filming
};

struct KindStudyOptions {
  std::filesystem::path landmark_model;  // as coarse_person_mask takes it
  AlignOptions align;
};

// folder: keeps each clip under its name, as `likeness demo` writes it, with clip.txt (how it was filmed),
// cameras.json (what was found) and found.json (in which words). A clip that was filmed so already is not
// filmed again; cameras that this very program found with these options are not looked for again. So a study
// that was stopped goes on.
Result<std::vector<KindRow>> study_camera_kinds(const std::vector<KindClip>& clips,
                                                const std::filesystem::path& folder,
                                                const KindStudyOptions& options, const Progress& progress,
                                                std::stop_token stop);

}  // namespace likeness
