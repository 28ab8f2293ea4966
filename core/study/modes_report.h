// What study_modes found, as tables, plots and one page that holds them all.
#pragma once

#include <filesystem>
#include <string>

#include "core/study/modes_study.h"
#include "core/study/plot.h"

namespace likeness {

std::string modes_csv(const ModesStudy& study);   // a line a training
std::string modes_json(const ModesStudy& study);  // all of it, marks included

Plot quality_over_seconds(const ModesStudy& study);
Plot quality_over_speed(const ModesStudy& study);

// A page without any other file: pictures and plots are inside. Reads the study's pictures from `folder`.
Result<std::string> modes_page(const ModesStudy& study, const std::filesystem::path& folder);

// results.csv, results.json, psnr_over_seconds.png, psnr_over_speed.png, report.html.
Result<void> write_modes_report(const ModesStudy& study, const std::filesystem::path& folder);

}  // namespace likeness
