// What a finished study found, read back from its folder: figures by table, and the plots' files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace likeness {

struct SummaryRow {
  std::string name, about;
  std::string failed;  // why it has no figures; empty: it has
  int seeds = 0;
  // Means over the seeds; the spread is half their range. Absent where the model has none.
  std::optional<double> psnr_db, head_db, face_db, head_spread_db;
  double train_seconds = 0, frames_per_second = 0;  // processor
};
struct SummaryTable {
  std::string name, title;
  std::vector<SummaryRow> rows;
};
struct SummaryPlot {
  std::filesystem::path file;
  std::string title, caption;
};

struct StudySummary {
  std::string clip;
  int size = 0, frames = 0;  // px; held out, measured
  double seconds = 0;        // processor, of a training; 0: by steps
  std::vector<SummaryTable> tables;
  std::vector<SummaryPlot> plots;
  std::filesystem::path page;  // report.html
};

// not_found: no study was finished there.
Result<StudySummary> read_study_summary(const std::filesystem::path& folder);

}  // namespace likeness
