// likeness study beyond: an avatar asked for what its clip never showed, beside the truth of a demo's person,
// or beside the frames of its own clip that see the head from other sides.
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "app/backend_option.h"
#include "app/commands.h"
#include "app/holds_json.h"
#include "app/project_options.h"
#include "app/sides_tables.h"
#include "app/tables.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/capture/capture.h"
#include "core/holds/check_holds.h"
#include "core/lab/beyond/beyond_study.h"
#include "core/lab/beyond/sides_study.h"
#include "core/project/open_avatar.h"
#include "core/project/project.h"
#include "core/synth/cast.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct BeyondStudyArguments {
  CommonOptions common;
  TableOptions output;
  fs::path project;  // empty: a demo person is filmed
  int person = 0, light = 0, frames = DemoOptions().frames, size = 256;
  double budget_s = 120, head_within_deg = faint_film(0, 0).head_within_deg,
         action_share = faint_film(0, 0).action_share;
  std::uint64_t steps = 0;
  bool no_proxies = false;
};

std::vector<Table> beyond_tables(const BeyondStudy& study) {
  const auto score_cells = [](const BeyondScore& s) {
    return std::vector<TableCell>{s.psnr_head_db, s.psnr_face_db, s.psnr_person_db, s.ssim, s.gmsd};
  };
  const std::vector<TableColumn> scores{{"psnr_head_db", "head, dB"},
                                        {"psnr_face_db", "face"},
                                        {"psnr_person_db", "person"},
                                        {"ssim", "SSIM", 3},
                                        {"gmsd", "GMSD", 3}};
  Table inside{.name = "inside", .title = "Within what was filmed: held-out frames, posed by the truth"};
  inside.columns = scores;
  inside.columns.insert(
      inside.columns.end(),
      {{"specks", "specks, %", 3}, {"steps", "steps", 0}, {"train_seconds", "trained, s", 0}});
  inside.rows.push_back(score_cells(study.inside));
  inside.rows.back().insert(
      inside.rows.back().end(),
      {TableCell(100 * study.inside_specks), TableCell(study.steps), TableCell(study.train_seconds)});
  Table views{.name = "views", .title = "From sides that were not filmed"};
  views.columns = {{"yaw", "yaw, °", 0}, {"pitch", "pitch", 0}};
  views.columns.insert(views.columns.end(), scores.begin(), scores.end());
  views.columns.insert(views.columns.end(), {{"drift", "colour drift", 1},
                                             {"iou", "IoU", 3},
                                             {"depth_mm", "depth, mm", 1},
                                             {"landmarks_px", "landmarks, px", 1},
                                             {"specks", "specks, %", 3}});
  for (const BeyondView& view : study.views) {
    std::vector<TableCell>& row = views.rows.emplace_back();
    row = {view.yaw, view.pitch};
    for (TableCell& cell : score_cells(view.score)) row.push_back(std::move(cell));
    row.insert(row.end(), {TableCell(view.drift), TableCell(view.iou), TableCell(view.depth_mm),
                           TableCell(view.landmarks_px), TableCell(100 * view.specks)});
  }
  views.notes = {
      "colour drift: of the skin's mean, of 255, less that at the front; depth: median on the skin;\n"
      "specks: more than 48 of 255 off the truth and off the median of their neighbours"};
  Table actions{.name = "actions", .title = "Actions that were performed faintly or not at all"};
  actions.columns = {{"name", "action"}, {"amount", "amount", 1}};
  actions.columns.insert(actions.columns.end(), scores.begin(), scores.end());
  actions.columns.insert(actions.columns.end(),
                         {{"forehead_change", "forehead", 2}, {"specks", "specks, %", 3}});
  for (const BeyondAction& action : study.actions) {
    std::vector<TableCell>& row = actions.rows.emplace_back();
    row = {action.name, double(action.amount)};
    for (TableCell& cell : score_cells(action.score)) row.push_back(std::move(cell));
    row.insert(row.end(), {TableCell(action.forehead_change), TableCell(100 * action.specks)});
  }
  actions.notes = {"forehead: its mean change from rest, of 255, less the true one"};
  std::vector<Table> tables{std::move(inside), std::move(views), std::move(actions)};
  for (Table& table : holds_tables(study)) tables.push_back(std::move(table));
  return tables;
}

nlohmann::json number(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

// As the contract of the command has it; specks and silhouettes are shares.
nlohmann::json beyond_json(const BeyondStudy& study) {
  const auto scores = [](const BeyondScore& s) {
    return nlohmann::json{{"psnr_head_db", number(s.psnr_head_db)},
                          {"psnr_face_db", number(s.psnr_face_db)},
                          {"psnr_person_db", number(s.psnr_person_db)},
                          {"ssim", number(s.ssim)},
                          {"gmsd", number(s.gmsd)}};
  };
  nlohmann::json json{{"inside", scores(study.inside)},       {"views", nlohmann::json::array()},
                      {"actions", nlohmann::json::array()},   {"steps", study.steps},
                      {"train_seconds", study.train_seconds}, {"holds", holds_json(study.holds.range)}};
  json["inside"]["specks"] = number(study.inside_specks);
  for (const BeyondView& view : study.views) {
    nlohmann::json own = scores(view.score);
    own["yaw"] = view.yaw, own["pitch"] = view.pitch;
    own["drift"] = number(view.drift), own["iou"] = number(view.iou);
    own["depth_mm"] = number(view.depth_mm), own["landmarks_px"] = number(view.landmarks_px);
    own["specks"] = number(view.specks);
    json["views"].push_back(std::move(own));
  }
  for (const BeyondAction& action : study.actions) {
    nlohmann::json own = scores(action.score);
    own["name"] = action.name, own["amount"] = action.amount;
    own["forehead_change"] = number(action.forehead_change), own["specks"] = number(action.specks);
    json["actions"].push_back(std::move(own));
  }
  return json;
}

// Of an avatar there is: its own check, and what its clip says of sides that were held out.
int run_project(const BeyondStudyArguments& a, const RenderPlace& place) {
  const auto opened = open_avatar(a.project);
  if (!opened) return report_failure(opened.error());
  const auto capture = read_capture(capture_path(opened->project));
  // Without its capture a project still has its avatar.
  if (!capture && capture.error().code != ErrorCode::not_found) return report_failure(capture.error());
  std::optional<Result<SidesStudy>> study;
  std::optional<Result<HoldCheck>> check;
  {
    const ProgressLine line(quiet_if_csv(a.common, a.output));
    if (capture && capture->split == Split::sides)
      study = study_sides(opened->project, a.output.out, place, line.progress().stage(0, 0.7, ""),
                          stop_on_signals());
    if (!study || *study)
      check = check_holds(opened->avatar, opened->model, place, {},
                          line.progress().stage(0.7, 1, "what holds"), stop_on_signals());
  }
  if (study && !*study) return report_failure(study->error());
  if (!*check) return report_failure(check->error());
  std::vector<Table> tables;
  nlohmann::json json = check_json(**check);
  if (study) {
    tables = sides_tables(**study);
    json.update(sides_json(**study));
    json["holds"] = holds_json((*check)->range);
  }
  tables.push_back(check_table(**check));
  return report_tables(a.common, a.output, tables, &json);
}

int run_beyond(const BeyondStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto backend = chosen_backend(a.common, FieldPrecision::bf16);
  if (!backend) return report_failure(backend.error());
  if (!a.project.empty()) return run_project(a, {backend->backend, backend->fall_back, {}});
  BeyondOptions options;
  options.film = faint_film(a.person, int(a.common.seed));
  options.film.light = a.light, options.film.frames = a.frames;
  options.film.head_within_deg = a.head_within_deg, options.film.action_share = a.action_share;
  options.project.shared.seed = a.common.seed;
  options.project.import.size = a.size;
  options.project.align.camera = CameraKind::resting;
  options.project.train.budget_s = a.budget_s, options.project.train.steps = a.steps;
  options.project.train.use_proxies = !a.no_proxies;
  options.place = {backend->backend, backend->fall_back, backend->precision};
  std::optional<Result<BeyondStudy>> study;
  {
    const ProgressLine line(quiet_if_csv(a.common, a.output));
    study = study_beyond_truth(a.output.out, options, line.progress(), stop_on_signals());
  }
  if (!*study) return report_failure(study->error(), StoppedWork::kept);
  const nlohmann::json json = beyond_json(**study);
  return report_tables(a.common, a.output, beyond_tables(**study), &json);
}

}  // namespace

void add_beyond_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<BeyondStudyArguments>();
  CLI::App* verb = study.add_subcommand(
      "beyond", "How an avatar looks from sides and with expressions that its clip never showed");
  CLI::Option* project = verb->add_option(
      "project", a->project,
      "A trained project: how far it holds by its own check and, if it was built with --split sides, how "
      "the frames look that its clip has of other sides");
  // Of the film and its avatar.
  std::vector<CLI::Option*> filmed;
  filmed.push_back(verb->add_option("--person", a->person,
                                    "The demo's person, who is filmed facing the camera with faint "
                                    "expressions")
                       ->check(CLI::Range(0, int(demo_people().size()) - 1))
                       ->capture_default_str());
  filmed.push_back(verb->add_option("--light", a->light, "In which light; see likeness demo --list")
                       ->check(CLI::Range(0, int(demo_lights().size()) - 1))
                       ->capture_default_str());
  verb->add_option("--out", a->output.out,
                   "Folder for the film, the avatar, the true pictures, the tables and contact sheets; a "
                   "second call makes nothing again")
      ->required();
  filmed.push_back(verb->add_option("--head-within", a->head_within_deg, "The head turns at most this far, °")
                       ->check(CLI::Range(0.1, kWidestTurn_deg))
                       ->capture_default_str());
  filmed.push_back(
      verb->add_option("--action-share", a->action_share, "At most this share of each action is performed")
          ->check(CLI::Range(0.01, 1.0))
          ->capture_default_str());
  filmed.push_back(verb->add_option("--frames", a->frames, "Frames of the film")
                       ->check(CLI::Range(40, 10000))
                       ->capture_default_str());
  filmed.push_back(verb->add_option("--size", a->size, "Side of the avatar's pictures, px")
                       ->check(CLI::IsMember({256, 512, 1024}))
                       ->capture_default_str());
  filmed.push_back(verb->add_option("--budget", a->budget_s, "Seconds of training")
                       ->check(CLI::PositiveNumber)
                       ->capture_default_str());
  filmed.push_back(verb->add_option("--steps", a->steps, "Exact steps of training instead"));
  filmed.push_back(
      verb->add_flag("--no-proxies", a->no_proxies, "Ablation: nothing is taught of what was not filmed"));
  for (CLI::Option* option : filmed) option->excludes(project);
  add_common_options(*verb, a->common);
  add_table_options(*verb, a->output);
  verb->callback([a, &exit_code] { exit_code = run_beyond(*a); });
}

}  // namespace likeness::app
