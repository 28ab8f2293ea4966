// What a study asks for, and how long that takes: see study_forecast.h.
#include "core/lab/study/study_forecast.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/json_text.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// Processor seconds, at 128 px: of a picture of each kind, and of a step if trained by steps.
constexpr double kGridPicture = 0.1, kMlpPicture = 7, kMovedPicture = 0.05, kGridStep = 0.19, kMlpStep = 1.2;
constexpr double kQualities = 16;  // pictures of a model with `costs`, per measured frame
constexpr double kBaked = 25;      // seconds for each number of cells
constexpr double kRefit = 6;       // seconds for each frame that is fitted to the field
constexpr double kMarkedPictures = 16, kTimedPictures = 3;
// Seconds for starting a training and scoring its pictures, and for reading the clip once per study.
constexpr double kTrainingStart = 6, kStudyStart = 15;
// Of a thread beside others: they wait for each other and share the memory's bandwidth.
constexpr double kThreadWorth = 0.85;

double pictures_of(const ModelSpec& spec) {
  return spec.kind == ModelKind::grid  ? kGridPicture
         : spec.kind == ModelKind::mlp ? kMlpPicture
                                       : kMovedPicture;
}

bool is_chosen(const std::vector<std::string>& chosen, const std::string& name) {
  return chosen.empty() || std::ranges::find(chosen, name) != chosen.end();
}

bool is_finished(const fs::path& path, const std::string& asked) {
  const auto text = read_text(path);
  if (!text) return false;
  const nlohmann::json row = try_parse_json(*text);
  return row.is_object() && row.contains("asked") && row["asked"] == asked;
}

}  // namespace

std::vector<ModelSpec> chosen_models(const ModelStudyOptions& options, std::vector<StudyTable>& tables) {
  std::vector<ModelSpec> models;
  for (const StudyTable& table : study_tables()) {
    if (!is_chosen(options.tables, table.name)) continue;
    StudyTable some = table;
    if (!options.models.empty())  // by name also those that a study does not train by default
      some.models.insert(some.models.end(), table.more.begin(), table.more.end());
    some.more.clear();
    std::erase_if(some.models, [&](const std::string& name) { return !is_chosen(options.models, name); });
    if (!some.models.empty()) tables.push_back(std::move(some));
  }
  for (const ModelSpec& spec : study_models())
    if (std::ranges::any_of(tables, [&](const StudyTable& t) {
          return std::ranges::find(t.models, spec.name) != t.models.end();
        }))
      models.push_back(spec);
  return models;
}

std::uint64_t asked_steps(const ModelStudyOptions& options, const ModelSpec& spec, std::uint64_t seed) {
  if (const auto at = options.replay.find({spec.name, seed}); at != options.replay.end()) return at->second;
  const std::uint64_t steps = spec.kind == ModelKind::grid ? options.steps : options.mlp_steps;
  return steps == 0 ? 0 : std::max<std::uint64_t>(1, std::uint64_t(std::llround(double(steps) * spec.share)));
}

std::string asked_training(const ModelStudyOptions& options, const ModelSpec& spec, std::uint64_t seed) {
  const std::uint64_t steps = asked_steps(options, spec, seed);
  const auto network = options.lpips.empty() ? Result<std::string>(std::string()) : hash_file(options.lpips);
  return fmt::format("{} steps {} seconds {} size {} frames {} rays {} seed {} first {} lpips {} baked {}{}",
                     spec.name, steps, steps > 0 ? 0 : options.seconds * spec.share, options.size,
                     options.frames, options.rays, seed, seed == options.first_seed, network ? *network : "",
                     spec.costs ? fmt::format("{}", options.baked_cells) : "", options.refit ? " refit" : "");
}

fs::path training_path(const fs::path& folder, const ModelSpec& spec, std::uint64_t seed) {
  return folder / fmt::format("{}-{}.json", spec.name, seed);
}

double training_work(const ModelSpec& spec, const ModelStudyOptions& options, bool first) {
  const double size = options.size > 0 ? options.size : 256, area = size * size / (128.0 * 128.0);
  const double frames = options.frames > 0 ? options.frames : 40, picture = pictures_of(spec) * area;
  const std::uint64_t steps = asked_steps(options, spec, options.first_seed);
  const double step = spec.kind == ModelKind::grid ? kGridStep * double(options.rays) / 8192 : kMlpStep;
  double work = spec.kind == ModelKind::moved ? 1
                : steps > 0                   ? double(steps) * step
                                              : options.seconds * spec.share;
  work += kTrainingStart + frames * picture;
  if (options.refit && spec.kind == ModelKind::grid) work += frames * kRefit;
  if (!first) return work;
  if (spec.kind != ModelKind::moved) work += kMarkedPictures * picture;
  if (!spec.costs) return work;
  work += kTimedPictures * picture * 4;  // at the project's own size
  if (spec.kind == ModelKind::grid)
    work += kQualities * frames * picture + kBaked * double(options.baked_cells.size());
  return work;
}

StudyForecast forecast_study(const fs::path& folder, const ModelStudyOptions& options, int threads) {
  StudyForecast forecast;
  std::vector<StudyTable> tables;
  double work = kStudyStart, left = 0;
  for (const ModelSpec& spec : chosen_models(options, tables))
    for (int k = 0; k < (spec.once ? 1 : options.seeds); ++k) {
      const std::uint64_t seed = options.first_seed + std::uint64_t(k);
      const double own = training_work(spec, options, k == 0);
      ++forecast.trainings, work += own;
      if (is_finished(training_path(folder, spec, seed), asked_training(options, spec, seed)))
        ++forecast.finished;
      else
        left += own;
    }
  const double speed = threads > 1 ? kThreadWorth * threads : 1;
  forecast.seconds = work / speed;
  forecast.left_seconds = left > 0 ? (left + kStudyStart) / speed : 0;
  return forecast;
}

}  // namespace likeness
