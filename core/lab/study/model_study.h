// Models of a head side by side on one capture, in tables: the papers' models against each other, ours
// against a long training of the baseline that the papers compare with, ours with a part more or less, and
// what its pictures cost at each quality. Every training draws its rays from the same pictures and, unless
// its row is about the track, the same track, and is measured on the same held-out frames, some as it learns
// and all at the end. Trained by steps instead of seconds, rows differ by their parts alone, however fast
// each is.
//
// Seconds are processor seconds, of all threads together, so that other users of the machine change as
// little as possible: `likeness study PROJECT`.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/lab/study/model_scores.h"
#include "core/lab/study/model_study_options.h"
#include "core/project/project.h"

namespace likeness {

// The project must be tracked and matted, regions included; it is not changed. Works in `folder`: a finished
// training is kept there with its scores and pictures, and a second call with the same options goes on where
// the first stopped. Writes results.csv, results.json, the plots and report.html when all rows are there. The
// program is none of the inputs: after an update take a new folder.
Result<ModelStudy> study_models_of(const Project& project, const std::filesystem::path& folder,
                                   const ModelStudyOptions& options, const Progress& progress,
                                   std::stop_token stop);

}  // namespace likeness
