// likeness study gains: what each part of the method brings to held-out pictures.
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/study/gain_study.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct GainStudyArguments {
  CommonOptions common;
  fs::path project, out, head_model;
  bool builtin_head = false;
  GainOptions options;
};

struct Spread {
  double mean = 0, half_range = 0;
};

// Of one score over the seeds; nullopt where a seed lacks it.
template <class F>
std::optional<Spread> over_seeds(const GainRow& row, F score) {
  double sum = 0, low = std::numeric_limits<double>::infinity(), high = -low;
  for (const GainScore& s : row.scores) {
    const std::optional<double> value = score(s);
    if (!value) return std::nullopt;
    sum += *value;
    low = std::min(low, *value);
    high = std::max(high, *value);
  }
  return Spread{sum / double(row.scores.size()), (high - low) / 2};
}

std::string cell(const std::optional<Spread>& spread, bool several) {
  if (!spread) return "-";
  return several ? fmt::format("{:.2f} ±{:.2f}", spread->mean, spread->half_range)
                 : fmt::format("{:.2f}", spread->mean);
}

nlohmann::json to_json(const GainRow& row) {
  nlohmann::json scores = nlohmann::json::array();
  for (const GainScore& s : row.scores)
    scores.push_back({{"seed", s.seed},
                      {"frames", s.frames},
                      {"lost", s.lost},
                      {"psnr_db", finite_or_null(s.psnr_db)},
                      {"psnr_person_db", finite_or_null(s.psnr_person_db)},
                      {"psnr_head_db", finite_or_null(s.psnr_head_db)},
                      {"psnr_face_db", finite_or_null(s.psnr_face_db)},
                      {"psnr_refit_db", finite_or_null(s.psnr_refit_db)},
                      {"psnr_refit_head_db", finite_or_null(s.psnr_refit_head_db)},
                      {"psnr_refit_face_db", finite_or_null(s.psnr_refit_face_db)},
                      {"lmk_error_px", finite_or_null(s.landmarks_px.inner)},
                      {"lmk_mouth_px", finite_or_null(s.landmarks_px.mouth)},
                      {"lmk_eyes_px", finite_or_null(s.landmarks_px.eyes)},
                      {"train_seconds", s.train_seconds},
                      {"samples_per_ray", finite_or_null(s.samples_per_ray)}});
  return {{"variant", row.variant}, {"about", row.about}, {"scores", scores}};
}

void print_rows(const std::vector<GainRow>& rows, const GainOptions& options) {
  const bool several = options.seeds > 1;
  fmt::print("{:<14} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12}", "variant", "full", "person", "head",
             "face", "landmarks px", "mouth px", "eyes px");
  fmt::print(" {:>12}", "samples/ray");
  if (options.refit) fmt::print(" {:>12} {:>12} {:>12}", "refit full", "refit head", "refit face");
  fmt::print("\n");
  for (const GainRow& row : rows) {
    const auto print = [&](auto score) { fmt::print(" {:>12}", cell(over_seeds(row, score), several)); };
    fmt::print("{:<14}", row.variant);
    print([](const GainScore& s) { return s.psnr_db; });
    print([](const GainScore& s) { return std::optional(s.psnr_person_db); });
    print([](const GainScore& s) { return std::optional(s.psnr_head_db); });
    print([](const GainScore& s) { return std::optional(s.psnr_face_db); });
    print([](const GainScore& s) { return std::optional(s.landmarks_px.inner); });
    print([](const GainScore& s) { return std::optional(s.landmarks_px.mouth); });
    print([](const GainScore& s) { return std::optional(s.landmarks_px.eyes); });
    print([](const GainScore& s) { return s.samples_per_ray; });
    if (options.refit) {
      print([](const GainScore& s) { return s.psnr_refit_db; });
      print([](const GainScore& s) { return s.psnr_refit_head_db; });
      print([](const GainScore& s) { return s.psnr_refit_face_db; });
    }
    fmt::print("  {}\n", row.about);
  }
  fmt::print("dB on held-out frames after {} training steps; {}\n", options.steps,
             several ? fmt::format("mean and half the range of {} seeds", options.seeds) : "one seed");
}

int run(const GainStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  if (a.builtin_head) project->options.shared.head_model.clear();
  if (!a.head_model.empty()) project->options.shared.head_model = a.head_model;
  std::optional<Result<std::vector<GainRow>>> rows;
  {
    const ProgressLine line(a.common);
    rows = study_gains(*project, a.out, a.options, line.progress(), stop_on_signals());
  }
  if (!*rows) return report_failure(rows->error(), StoppedWork::kept);
  if (!a.common.json) {
    print_rows(**rows, a.options);
    return kExitDone;
  }
  nlohmann::json list = nlohmann::json::array();
  for (const GainRow& row : **rows) list.push_back(to_json(row));
  print_json({{"steps", a.options.steps}, {"rays", a.options.rays}, {"rows", list}});
  return kExitDone;
}

}  // namespace

void add_gain_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<GainStudyArguments>();
  CLI::App* verb =
      study.add_subcommand("gains", "What each part of the method brings to pictures never seen");
  verb->add_option("project", a->project, "A project that was built: clip, cameras, regions")->required();
  verb->add_option("--out", a->out,
                   "Folder for the trainings; a second call of the same version goes on there")
      ->required();
  std::vector<std::string> names;
  for (const GainVariant& variant : gain_variants()) names.push_back(variant.name);
  verb->add_option("--variants", a->options.variants,
                   fmt::format("Rows of the table, of: {}; default: all", fmt::join(names, ", ")));
  verb->add_option("--steps", a->options.steps, "Training steps of each")
      ->check(CLI::Range(std::uint64_t(1), std::uint64_t(1'000'000)));
  verb->add_option("--rays", a->options.rays, "Rays of each step")->check(CLI::Range(1, 1'000'000));
  verb->add_option("--seeds", a->options.seeds, "Trainings of each, with seeds from --seed on")
      ->check(CLI::Range(1, 20));
  verb->add_flag("--refit", a->options.refit,
                 "Also fit pose and expression of every held-out frame to the frozen field (an oracle)");
  CLI::Option* head =
      verb->add_option("--head-model", a->head_model, "Another head model than the project's");
  verb->add_flag("--builtin-head", a->builtin_head, "The built-in head instead of the project's")
      ->excludes(head);
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] {
    a->options.first_seed = a->common.seed;
    exit_code = run(*a);
  });
}

}  // namespace likeness::app
