// How long a study of models will take, before it is begun: estimated from what it trains and how long, by
// what the pictures of each kind of model took with two threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/lab/study/model_rows.h"
#include "core/lab/study/model_study_options.h"

namespace likeness {

struct StudyForecast {
  int trainings = 0;        // in all
  int finished = 0;         // of them, kept in the folder from an earlier call with the same options
  double seconds = 0;       // of the clock, for all of them
  double left_seconds = 0;  // for those that are not finished
};

// folder: of the study; it need not be there. threads: that will work. Whether the project changed since is
// not looked into: what was trained on other pictures counts as finished here, and is trained anew.
StudyForecast forecast_study(const std::filesystem::path& folder, const ModelStudyOptions& options,
                             int threads);

// Processor seconds of one training with its pictures. first: of the seeds, which is also looked at as it
// learns.
double training_work(const ModelSpec& spec, const ModelStudyOptions& options, bool first);

// The models of the tables that are asked for, each once, and the tables with what is asked for of them.
std::vector<ModelSpec> chosen_models(const ModelStudyOptions& options, std::vector<StudyTable>& tables);

// What a training was asked for, but the pictures it is trained on.
std::string asked_training(const ModelStudyOptions& options, const ModelSpec& spec, std::uint64_t seed);
// Its file in the study's folder.
std::filesystem::path training_path(const std::filesystem::path& folder, const ModelSpec& spec,
                                    std::uint64_t seed);
// Exact steps of it, or 0: by the study's seconds.
std::uint64_t asked_steps(const ModelStudyOptions& options, const ModelSpec& spec, std::uint64_t seed);

}  // namespace likeness
