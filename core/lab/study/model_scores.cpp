// Rows by name, and the papers' claims: see model_scores.h.
#include "core/lab/study/model_scores.h"

#include <algorithm>

namespace likeness {
namespace {

double mean_head_db(const ModelRow& row) {
  double sum = 0;
  for (const ModelScore& s : row.scores) sum += s.psnr_head_db / double(row.scores.size());
  return sum;
}
double mean_train_seconds(const ModelRow& row) {
  double sum = 0;
  for (const ModelScore& s : row.scores) sum += s.train_seconds / double(row.scores.size());
  return sum;
}
std::optional<double> size_seconds(const ModelRow& row, int size) {
  for (const SizeCost& cost : row.scores.front().sizes)
    if (cost.size == size) return cost.frame_seconds;
  return std::nullopt;
}

}  // namespace

const ModelRow* find_row(const ModelStudy& study, std::string_view name) {
  const auto at =
      std::ranges::find_if(study.rows, [&](const ModelRow& row) { return row.spec.name == name; });
  return at == study.rows.end() || at->scores.empty() ? nullptr : &*at;
}

std::optional<StudyRatios> study_ratios(const ModelStudy& study) {
  const ModelRow *ours = find_row(study, kDefaultModel), *baseline = find_row(study, kLongBaseline),
                 *equal = find_row(study, "concat-mlp");
  if (ours == nullptr || baseline == nullptr || equal == nullptr) return std::nullopt;
  StudyRatios r;
  r.baseline_db = mean_head_db(*baseline);
  r.ours_db = mean_head_db(*ours);
  r.times_longer = mean_train_seconds(*baseline) / std::max(1e-9, mean_train_seconds(*ours));
  r.equal_time_db = r.ours_db - mean_head_db(*equal);
  r.equal_seconds = mean_train_seconds(*equal);
  for (const char* name : {"ours-quarter", "ours-half", kDefaultModel, "ours-long"}) {
    const ModelRow* row = find_row(study, name);
    if (row == nullptr || mean_head_db(*row) < r.baseline_db) continue;
    r.sooner = name;
    r.times_sooner = mean_train_seconds(*baseline) / std::max(1e-9, mean_train_seconds(*row));
    break;
  }
  r.times_faster =
      baseline->scores.front().frame_seconds / std::max(1e-9, ours->scores.front().frame_seconds);
  const auto full = size_seconds(*baseline, study.full_size), own = size_seconds(*ours, study.full_size);
  if (full && own) r.times_faster_full = *full / std::max(1e-9, *own);
  return r;
}

}  // namespace likeness
