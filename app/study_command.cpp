// likeness study PROJECT: what the parts and the papers' models bring, side by side on one capture; and its
// inner verbs.
#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/removed.h"
#include "app/study_tables.h"
#include "app/tables.h"
#include "app/terminal.h"
#include "core/base/json_text.h"
#include "core/base/parallel.h"
#include "core/lab/study/model_report.h"
#include "core/lab/study/model_study.h"

namespace likeness::app {
namespace {

struct StudyArguments {
  CommonOptions common;
  TableOptions output;
  std::filesystem::path project, replay, head_model;
  bool builtin_head = false;
  std::optional<int> frames;
  ModelStudyOptions options;
};

constexpr const char* kAvatarTables[] = {"occupancy", "landmarks"};  // of a trained avatar, without training

std::vector<std::string> all_tables() {
  std::vector<std::string> names;
  for (const StudyTable& table : study_tables()) names.push_back(table.name);
  names.insert(names.end(), std::begin(kAvatarTables), std::end(kAvatarTables));
  return names;
}

std::string model_names(bool more) {
  std::vector<std::string> names;
  for (const ModelSpec& spec : study_models()) {
    const bool later = std::ranges::any_of(study_tables(), [&](const StudyTable& t) {
      return std::ranges::find(t.more, spec.name) != t.more.end();
    });
    if (later == more) names.push_back(spec.name);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

void add_ratios(const ModelStudy& study, Table& table) {
  const auto r = study_ratios(study);
  if (!r) return;
  table.notes.push_back(fmt::format(
      "head {:.2f} dB; the baseline {:.2f} after {:.0f} times the time, {:.2f} less after {:.0f} s",
      r->ours_db, r->baseline_db, r->times_longer, r->equal_time_db, r->equal_seconds));
  if (!r->sooner.empty())
    table.notes.push_back(fmt::format("its long training is reached by {} in 1/{:.1f} of its time", r->sooner,
                                      r->times_sooner));
  std::string picture = fmt::format("a picture takes 1/{:.1f} of its time", r->times_faster);
  if (r->times_faster_full)
    picture += fmt::format(", at {} px 1/{:.1f}", study.full_size, *r->times_faster_full);
  table.notes.push_back(picture);
}

// Which tables were asked for: those that train, and those of a trained avatar.
struct AskedTables {
  std::vector<std::string> trained;  // empty: the default ones
  bool any_trained = true;
  bool occupancy = false, landmarks = false;
};
AskedTables asked_tables(const TableOptions& output) {
  AskedTables asked{output.tables, true, is_asked(output, "occupancy"), is_asked(output, "landmarks")};
  std::erase_if(asked.trained, [](const std::string& name) {
    return std::ranges::find(kAvatarTables, name) != std::end(kAvatarTables);
  });
  asked.any_trained = output.tables.empty() || !asked.trained.empty();
  return asked;
}

// The models' tables and, in `json`, all that is in results.json.
Result<std::vector<Table>> study_models_tables(const StudyArguments& a, const Project& project,
                                               const std::vector<std::string>& tables, nlohmann::json& json,
                                               const Progress& progress) {
  ModelStudyOptions options = a.options;
  options.tables = tables;
  options.first_seed = a.common.seed;
  options.track_anew = a.builtin_head || !a.head_model.empty();
  if (a.frames) options.frames = *a.frames;
  std::erase(options.baked_cells, 0);
  if (!a.replay.empty()) {
    auto steps = read_study_steps(a.replay);
    if (!steps) return steps.error();
    options.replay = std::move(*steps);
  }
  const auto study = study_models_of(project, a.output.out, options, progress, stop_on_signals());
  if (!study) return study.error();
  json = parse_json(models_json(*study));
  std::vector<Table> made = models_tables(*study);
  for (Table& table : made)
    if (table.name == "time") add_ratios(*study, table);
  made.back().notes.push_back(fmt::format(
      "{} held-out frames of {} px; training in processor seconds, pictures per processor second; several "
      "seeds: mean ± half the range\n{}",
      study->frames.size(), study->size, (a.output.out / "report.html").string()));
  return made;
}

Result<std::vector<Table>> all_of_it(const StudyArguments& a, const AskedTables& asked,
                                     nlohmann::json& json) {
  auto project = open_project(a.project);
  if (!project) return project.error();
  if (a.builtin_head) project->options.shared.head_model.clear();
  if (!a.head_model.empty()) project->options.shared.head_model = a.head_model;
  const ProgressLine line(quiet_if_csv(a.common, a.output));
  const double parts = double(asked.any_trained) + double(asked.occupancy) + double(asked.landmarks);
  double done = 0;
  const auto next = [&](const char* name) {
    done += 1;
    return line.progress().stage((done - 1) / parts, done / parts, name);
  };
  std::vector<Table> tables;
  const auto take = [&](const Result<std::vector<Table>>& more) {
    if (more) tables.insert(tables.end(), more->begin(), more->end());
    return more.ok() ? Result<void>() : Result<void>(more.error());
  };
  json = nlohmann::json::object();
  if (asked.any_trained)
    if (auto fine = take(study_models_tables(a, *project, asked.trained, json, next("models"))); !fine)
      return fine.error();
  const std::size_t trained = tables.size();
  if (asked.occupancy)
    if (auto fine = take(occupancy_tables(*project, a.frames, next("occupancy"), stop_on_signals())); !fine)
      return fine.error();
  if (asked.landmarks)
    if (auto fine = take(landmark_tables(*project, a.frames, next("landmarks"), stop_on_signals())); !fine)
      return fine.error();
  json.update(parse_json(tables_json(std::span<const Table>(tables).subspan(trained))));
  return tables;
}

int run(const StudyArguments& a) {
  const AskedTables asked = asked_tables(a.output);
  if (a.project.empty() || (asked.any_trained && a.output.out.empty()))
    return report_failure({ErrorCode::bad_input, "Say what to study, and where its report goes.",
                           "likeness study PROJECT --out FOLDER, or one of likeness study --help.", ""});
  const ThreadLimit limit(a.common.threads);
  nlohmann::json json;
  const auto tables = all_of_it(a, asked, json);
  if (!tables)
    return report_failure(tables.error(), asked.any_trained ? StoppedWork::kept : StoppedWork::lost);
  return report_tables(a.common, a.output, *tables, &json);
}

void add_model_options(CLI::App& study, StudyArguments& a) {
  ModelStudyOptions& o = a.options;
  study.add_option("--models", o.models,
                   fmt::format("Rows of the tables, of: {}; default: all of these. By name alone: {}",
                               model_names(false), model_names(true)));
  study
      .add_option("--seconds", o.seconds,
                  "Processor seconds, all threads together, of each training but those that say otherwise")
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();
  study.add_option("--steps", o.steps, "Exact steps of each such model with the grid, instead of seconds");
  study.add_option("--mlp-steps", o.mlp_steps,
                   "Exact steps of each such model with perceptrons, instead of seconds");
  study.add_option("--replay", a.replay,
                   "results.json of an earlier study: each training takes the steps that it took there");
  study.add_option("--lpips", o.lpips, "A network (.onnx) that measures perceptual distance, e.g. LPIPS")
      ->check(CLI::ExistingFile);
  study.add_option("--rays", o.rays, "Rays of each step of the grid")->check(CLI::Range(1, 1'000'000));
  study.add_option("--size", o.size, "Side of the pictures, px; 0: the project's")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  study
      .add_option("--frames", a.frames,
                  "Held-out frames to measure, evenly chosen; 0: all; default: 8, of occupancy 12, of "
                  "landmarks 24")
      ->check(CLI::Range(0, 1'000'000));
  study
      .add_option("--baked-cells", o.baked_cells,
                  "Cells along an axis at which the default model's fields are also stored, multiples of 8; "
                  "0: not at all")
      ->check(CLI::Range(0, 512));
  study.add_option("--seeds", o.seeds, "Trainings of each, with seeds from --seed on")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  study.add_flag("--refit", o.refit,
                 "Also fit pose and expression of every measured frame to the frozen field (an oracle)");
}

}  // namespace

void add_study_command(CLI::App& program, int& exit_code) {
  CLI::App* study = program.add_subcommand(
      "study", "What the parts and the papers' models bring; and tracks, cameras and truths compared");
  study->require_subcommand(0, 1);
  auto a = std::make_shared<StudyArguments>();
  study->add_option("project", a->project, "A project that was tracked and matted: its models side by side")
      ->check(no_removed_study());
  study->add_option("--out", a->output.out,
                    "Folder for results and report; a second call of the same version continues there");
  add_tables_option(*study, a->output, all_tables(),
                    "default: models, time, parts. occupancy and landmarks need a trained avatar, and no "
                    "--out");
  add_model_options(*study, *a);
  CLI::Option* head = study->add_option("--head-model", a->head_model,
                                        "Another head model than the project's: tracked again");
  study->add_flag("--builtin-head", a->builtin_head, "The built-in head instead of the project's")
      ->excludes(head);
  add_common_options(*study, a->common);
  add_table_options(*study, a->output);
  study->callback([a, &exit_code, study] {
    if (study->get_subcommands().empty()) exit_code = run(*a);
  });
  add_truth_study(*study, exit_code);
  add_track_study(*study, exit_code);
  add_camera_study(*study, exit_code);
  add_face_study(*study, exit_code);
  add_kind_study(*study, exit_code);
  add_beyond_study(*study, exit_code);
}

}  // namespace likeness::app
