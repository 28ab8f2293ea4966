// likeness study truth: tracks, cameras, mattes, walls and driving beside the truth of a demo, mattes beside
// what was drawn by hand.
#include <algorithm>
#include <memory>
#include <numbers>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/tables.h"
#include "app/terminal.h"
#include "app/view_tables.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/base/temporary_folder.h"
#include "core/drive/drive_clip.h"
#include "core/export/write_film.h"
#include "core/face/landmarks.h"
#include "core/lab/truth/camera_truth.h"
#include "core/lab/truth/drive_truth.h"
#include "core/lab/truth/marked_mattes.h"
#include "core/lab/truth/matte_truth.h"
#include "core/lab/truth/track_study.h"
#include "core/lab/truth/wall_truth.h"
#include "core/project/project_head_model.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct TruthStudyArguments {
  CommonOptions common;
  TableOptions output;
  fs::path demo, project, tracks, track, marks;
  std::vector<std::string> steps, networks;
  ProjectOptions models;  // head and landmark model only
};

// -- Tracks

std::vector<Table> track_tables(const std::vector<TruthRow>& rows) {
  Table errors{.name = "track", .title = "Each step of the tracker, beside the truth"};
  errors.columns = {{"step", "step"},
                    {"part", "frames"},
                    {"frames", "", 0},
                    {"turn_median_deg", "turn, °"},
                    {"turn_p95_deg", "p95"},
                    {"along_median_percent", "along, %"},
                    {"along_p95_percent", "p95"},
                    {"across_median_mm", "across, mm"},
                    {"across_p95_mm", "p95"},
                    {"good", "good", 0},
                    {"weak", "weak", 0},
                    {"lost", "lost", 0},
                    {"seconds", "seconds", 1},
                    {"frames_per_second", "frames/s"}};
  Table actions{.name = "correlation", .title = "Correlation with the truth"};
  actions.columns = {{"step", "step"}, {"part", "frames"}};
  for (const TruthCorrelation& c : rows.front().comparison.training.correlations)
    actions.columns.push_back({c.name, c.name, 3});
  Table before{
      .name = "alignment",
      .title = "Taken out before: one scale and one offset of the head's frame, from training frames"};
  before.columns = {{"step", "step"},
                    {"scale", "scale", 4},
                    {"turn_deg", "turn, °"},
                    {"turn_x_rad", ""},
                    {"turn_y_rad", ""},
                    {"turn_z_rad", ""},
                    {"shift_x_mm", "shift x, mm", 1},
                    {"shift_y_mm", "y", 1},
                    {"shift_z_mm", "z", 1},
                    {"shape_rms_mm", "face at rest off by, mm rms"},
                    {"rest_mouth_mm", "resting mouth, mm rms"},
                    {"rest_width_mm", "its width, mm"}};
  for (const TruthRow& row : rows) {
    for (const bool training : {true, false}) {
      const TruthScore& s = training ? row.comparison.training : row.comparison.held_out;
      const PoseErrors& p = s.pose;
      const char* part = training ? "training" : "held out";
      errors.rows.push_back({row.step, part, s.frames, p.turn_median_deg, p.turn_p95_deg,
                             p.along_median_percent, p.along_p95_percent, p.across_median_mm, p.across_p95_mm,
                             s.good, s.weak, s.lost, row.seconds, row.frames_per_second});
      std::vector<TableCell>& cells = actions.rows.emplace_back();
      cells = {row.step, part};
      for (const TruthCorrelation& c : s.correlations) cells.push_back(c.value);
    }
    const TruthAlignment& a = row.comparison.alignment;
    const Eigen::AngleAxisd turn = axis_and_angle(a.truth_head_from_head.linear());
    const Vec3d w = turn.angle() * turn.axis(), t = 1000 * a.truth_head_from_head.translation();
    before.rows.push_back({row.step, a.scale, turn.angle() * 180 / std::numbers::pi, w.x(), w.y(), w.z(),
                           t.x(), t.y(), t.z(), row.comparison.shape_rms_mm, row.comparison.rest.mouth_rms_mm,
                           row.comparison.rest.mouth_width_mm});
  }
  return {std::move(errors), std::move(actions), std::move(before)};
}

Result<std::vector<Table>> compare_tracks(const TruthStudyArguments& a, const Progress& progress,
                                          std::stop_token stop) {
  TrackOptions base;
  base.predictor = a.models.shared.landmark_model;
  const auto steps = track_steps(a.steps, base);
  if (!steps) return steps.error();
  const auto model = project_head_model(a.models);
  if (!model) return model.error();
  const auto rows = study_against_truth(a.demo, *model, *steps, a.tracks, progress, stop);
  if (!rows) return rows.error();
  return track_tables(*rows);
}

// -- Mattes

Result<std::vector<Table>> compare_project_mattes(const TruthStudyArguments& a, const Progress& progress,
                                                  std::stop_token stop) {
  const auto project = open_project(a.project);
  if (!project) return project.error();
  const double n = 1 + double(a.networks.size());
  auto rows = study_mattes(*project, a.demo, progress.stage(0, 1 / n, "as it is"), stop);
  if (!rows) return rows.error();
  const auto work = TemporaryFolder::make("mattes");
  if (!work) return work.error();
  for (std::size_t i = 0; i < a.networks.size(); ++i) {
    const auto more =
        study_mattes_again(*project, a.demo, a.networks[i], work->path() / a.networks[i],
                           progress.stage(double(1 + i) / n, double(2 + i) / n, a.networks[i]), stop);
    if (!more) return more.error();
    rows->insert(rows->end(), more->begin(), more->end());
  }
  Table table{.name = "mattes", .title = "The project's mattes, beside the true ones"};
  table.columns = {{"network", "network"},        {"part", "part"},          {"frames", "frames", 0},
                   {"iou_mean", "IoU", 4},        {"iou_worst", "worst", 4}, {"worst_frame", "its frame", 0},
                   {"border_error", "border", 3}, {"hair_error", "hair", 3}};
  for (const MatteRow& row : *rows)
    table.rows.push_back({row.network, row.part, row.frames, row.iou_mean, row.iou_worst, row.worst_frame,
                          row.border, row.hair});
  table.notes = {
      "border: mean difference of alpha along the true border; hair: of the border above the ears"};
  return std::vector<Table>{std::move(table)};
}

// -- Cameras and what is behind the person

Result<std::vector<Table>> compare_project_views(const TruthStudyArguments& a, const Progress&,
                                                 std::stop_token) {
  const auto project = open_project(a.project);
  if (!project) return project.error();
  const auto found = read_cameras(cameras_path(*project));
  if (!found) return found.error();
  const auto truth = read_camera_truth(a.demo);
  if (!truth) return truth.error();
  Table table = views_table("cameras");
  add_views(table, "the project's", found->kind, truth->kind,
            compare_views(*found, truth->cameras, truth->shots));
  return std::vector<Table>{std::move(table)};
}

Result<std::vector<Table>> compare_project_walls(const TruthStudyArguments& a, const Progress& progress,
                                                 std::stop_token stop) {
  const auto project = open_project(a.project);
  if (!project) return project.error();
  const auto rows = study_walls(*project, a.demo, progress, stop);
  if (!rows) return rows.error();
  Table table{.name = "walls", .title = "The project's background, beside the true one"};
  table.columns = {{"part", "part"},
                   {"pictures", "pictures", 0},
                   {"known_share", "known", 3},
                   {"psnr_db", "dB"},
                   {"psnr_own_light_db", "in its own light, dB"}};
  for (const WallRow& row : *rows)
    table.rows.push_back({row.part, row.pictures, row.known_share, row.psnr_db, row.psnr_own_light_db});
  table.notes = {
      "where the project knows it; known: share of the picture; in its own light: after one factor a "
      "channel"};
  return std::vector<Table>{std::move(table)};
}

// -- Mattes beside what was drawn by hand

Result<std::vector<Table>> compare_with_drawn(const TruthStudyArguments& a) {
  if (!a.project.empty() || !a.output.tables.empty())
    return Error{ErrorCode::bad_input, "Marks are of a project's own clip and need no demo.",
                 "likeness study truth PROJECT --marks MARKS.json", ""};
  const auto project = open_project(a.demo);
  if (!project) return project.error();
  const auto marks = read_person_marks(a.marks);
  if (!marks) return marks.error();
  const ProgressLine line(quiet_if_csv(a.common, a.output));
  const auto found = study_marked_mattes(*project, *marks, line.progress(), stop_on_signals());
  if (!found) return found.error();
  Table table{.name = "marks", .title = "The project's mattes, beside the person drawn by hand"};
  table.columns = {{"frame", "frame"},
                   {"person_iou", "IoU, person", 4},
                   {"head_iou", "head and hair", 4},
                   {"torso_iou", "torso", 4}};
  MarkedMatte sum;
  for (const MarkedMatte& m : found->frames) {
    table.rows.push_back({fmt::format("{}", m.frame), m.person_iou, m.head_iou, m.torso_iou});
    sum.person_iou += m.person_iou, sum.head_iou += m.head_iou, sum.torso_iou += m.torso_iou;
  }
  const double n = double(found->frames.size());
  table.rows.push_back({"mean", sum.person_iou / n, sum.head_iou / n, sum.torso_iou / n});
  table.notes = {fmt::format("Pixels within {:.0f} % of the head's width of the drawn edge do not count.",
                             100 * kUnsureOfHead)};
  if (!found->without_matte.empty())
    table.notes.push_back(fmt::format("Without a matte: {}.", fmt::join(found->without_matte, ", ")));
  return std::vector<Table>{std::move(table)};
}

// -- Driving

Result<DriveScore> driven_score(const TruthStudyArguments& a, const Progress& progress,
                                std::stop_token stop) {
  const auto opened = open_avatar(a.project);
  if (!opened) return opened.error();
  const auto truth = read_track_truth(a.demo);
  if (!truth) return truth.error();
  DriveRequest request;
  request.video = a.demo / "demo.mp4";
  request.track = a.track;
  request.head_model = a.models.shared.head_model;
  request.landmark_model = a.models.shared.landmark_model;
  request.options.clamp = false;  // the clamp is a limit of the capture, not of the transfer
  const auto clip = drive_clip(*opened, request, progress, stop);
  if (!clip) return clip.error();
  HeadModel other;
  if (!a.models.shared.head_model.empty()) {
    auto model = project_head_model(a.models);
    if (!model) return model.error();
    other = std::move(*model);
  }
  return score_drive(opened->avatar, opened->model, clip->track,
                     a.models.shared.head_model.empty() ? opened->model : other, *truth, request.options);
}

Result<std::vector<Table>> compare_driving(const TruthStudyArguments& a, const Progress& progress,
                                           std::stop_token stop) {
  const auto score = driven_score(a, progress, stop);
  if (!score) return score.error();
  Table actions{.name = "actions", .title = "The avatar's actions, beside those performed"};
  actions.columns = {
      {"name", "action"}, {"correlation", "correlation", 3}, {"gain", "gain"}, {"jitter_ratio", "jitter"}};
  for (const DrivenAction& action : score->actions)
    actions.rows.push_back({action.name, action.correlation, action.gain, action.jitter_ratio});
  Table all{.name = "drive", .title = "The whole clip"};
  all.columns = {{"frames", "frames", 0},
                 {"bridged", "bridged", 0},
                 {"mean_correlation", "mean correlation", 3},
                 {"neutral_psnr_db", "at rest, dB", 1},
                 {"neutral_difference", "levels apart at most", 0}};
  all.rows = {{score->frames, score->bridged, score->mean_correlation, score->neutral_psnr_db,
               score->neutral_difference}};
  return std::vector<Table>{std::move(actions), std::move(all)};
}

// -- All of it

struct TruthTable {
  const char* name;
  bool of_a_project;
  Result<std::vector<Table>> (*compare)(const TruthStudyArguments&, const Progress&, std::stop_token);
};
constexpr TruthTable kTruthTables[] = {{"track", false, compare_tracks},
                                       {"mattes", true, compare_project_mattes},
                                       {"views", true, compare_project_views},
                                       {"walls", true, compare_project_walls},
                                       {"drive", true, compare_driving}};

Result<std::vector<Table>> compare_all(const TruthStudyArguments& a) {
  std::vector<TruthTable> asked;
  for (const TruthTable& table : kTruthTables)
    if (is_asked(a.output, table.name)) asked.push_back(table);
  if (asked.empty()) asked.push_back(kTruthTables[0]);
  const bool of_a_project = std::ranges::any_of(asked, &TruthTable::of_a_project);
  if (of_a_project == a.project.empty())
    return Error{ErrorCode::bad_input,
                 of_a_project ? "Mattes, views, walls and driving can only be compared for a project."
                              : "The tracks of a demo need no project.",
                 "likeness study truth DEMO, or likeness study truth DEMO PROJECT --tables mattes, views, "
                 "walls or drive.",
                 ""};
  const ProgressLine line(quiet_if_csv(a.common, a.output));
  std::vector<Table> tables;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const double n = double(asked.size());
    const auto more = asked[i].compare(
        a, line.progress().stage(double(i) / n, double(i + 1) / n, asked[i].name), stop_on_signals());
    if (!more) return more.error();
    tables.insert(tables.end(), more->begin(), more->end());
  }
  return tables;
}

int run(const TruthStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto tables = a.marks.empty() ? compare_all(a) : compare_with_drawn(a);
  return tables ? report_tables(a.common, a.output, *tables) : report_failure(tables.error());
}

}  // namespace

void add_truth_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<TruthStudyArguments>();
  CLI::App* verb =
      study.add_subcommand("truth", "Tracks, cameras, mattes, walls and driving beside the truth of a demo");
  verb->add_option("demo", a->demo, "A folder of `likeness demo`; with --marks a project")->required();
  verb->add_option("project", a->project,
                   "For mattes, views and walls: the project that imported the demo's clip. For drive: the "
                   "avatar's, which the demo's person drives");
  std::vector<std::string> names;
  for (const TruthTable& table : kTruthTables) names.push_back(table.name);
  add_tables_option(*verb, a->output, names, "default: track");
  verb->add_option("--steps", a->steps,
                   fmt::format("Steps of the tracker to measure, of: {}; default: all",
                               fmt::join(track_step_names(), ", ")));
  verb->add_option("--networks", a->networks,
                   "For mattes: also make them again, a row for each: person (with the person network), none")
      ->check(CLI::IsMember({"person", "none"}));
  verb->add_option("--tracks", a->tracks, "A folder to keep each step's track in");
  verb->add_option("--marks", a->marks,
                   "The person drawn by hand in frames of the project's clip "
                   "(core/lab/truth/person_marks.h): its mattes beside that");
  verb->add_option("--track", a->track, "For drive: track.json of the demo, read if it exists, else written");
  verb->add_option(
      "--head-model", a->models.shared.head_model,
      "A head model file (.npz) to track with; default: the built-in head, for drive the avatar's");
  verb->add_option("--landmark-model", a->models.shared.landmark_model, kLandmarkModelHelp);
  add_common_options(*verb, a->common);
  add_table_options(*verb, a->output);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
