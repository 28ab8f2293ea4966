// What a study of models found, as tables, plots and one page that holds them all.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/table.h"
#include "core/lab/study/model_scores.h"
#include "core/lab/study/model_study_options.h"
#include "core/lab/study/plot.h"

namespace likeness {

// A table for each of the study's, a row a model, figures over its seeds; then what the default model's
// pictures cost at each quality, and how long a picture takes at each size.
std::vector<Table> models_tables(const ModelStudy& study);
Table trainings_table(const ModelStudy& study);    // a row a training
std::string models_csv(const ModelStudy& study);   // the same
std::string models_json(const ModelStudy& study);  // all of it, marks, qualities and sizes included
// The steps that a study of models_json took. An Error where it is no such study.
Result<StudySteps> read_study_steps(const std::filesystem::path& results);

struct StudyPlot {
  std::string file, caption;
  Plot plot;
};
// Those that have something to show: the head's PSNR against seconds and against steps, against frames a
// processor second of the models and of the default model's qualities, and what a picture costs by its size.
std::vector<StudyPlot> study_plots(const ModelStudy& study);

// A page without any other file: pictures and plots are inside. Reads the study's pictures from `folder`.
Result<std::string> models_page(const ModelStudy& study, const std::filesystem::path& folder);

// results.csv, results.json, the plots, report.html.
Result<void> write_model_report(const ModelStudy& study, const std::filesystem::path& folder);

}  // namespace likeness
