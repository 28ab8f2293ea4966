// likeness study: measurements that take a while and end in a table.
#include <memory>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/camera/clip_camera.h"
#include "core/capture/capture.h"
#include "core/drive/drive_clip.h"
#include "core/export/write_film.h"
#include "core/lab/truth/drive_truth.h"
#include "core/lab/truth/track_study.h"
#include "core/project/project_head_model.h"
#include "core/video/decode.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct TrackStudyArguments {
  CommonOptions common;
  fs::path clip, demo, tracks, marks;
  std::vector<std::string> steps;
  ProjectOptions models;  // head and landmark model only
};

// -- Against the truth of a demo

nlohmann::json to_json(const TruthScore& score) {
  nlohmann::json correlations = nlohmann::json::object();
  for (const TruthCorrelation& c : score.correlations) correlations[c.name] = finite_or_null(c.value);
  const PoseErrors& p = score.pose;
  return {{"frames", score.frames},
          {"good", score.good},
          {"weak", score.weak},
          {"lost", score.lost},
          {"turn_median_deg", p.turn_median_deg},
          {"turn_p95_deg", p.turn_p95_deg},
          {"along_median_percent", p.along_median_percent},
          {"along_p95_percent", p.along_p95_percent},
          {"across_median_mm", p.across_median_mm},
          {"across_p95_mm", p.across_p95_mm},
          {"correlation", correlations}};
}

nlohmann::json to_json(const TruthRow& row) {
  const TruthAlignment& a = row.comparison.alignment;
  const Eigen::AngleAxisd turn(a.truth_head_from_head.linear());
  const Vec3d t = a.truth_head_from_head.translation(), w = turn.angle() * turn.axis();
  return {{"step", row.step},
          {"seconds", row.seconds},
          {"frames_per_second", row.frames_per_second},
          {"scale", a.scale},
          {"shape_rms_mm", row.comparison.shape_rms_mm},
          {"truth_head_from_head",
           {{"rotation_vector_rad", {w.x(), w.y(), w.z()}}, {"translation_m", {t.x(), t.y(), t.z()}}}},
          {"training", to_json(row.comparison.training)},
          {"held_out", to_json(row.comparison.held_out)}};
}

void print_rows(const std::vector<TruthRow>& rows) {
  fmt::print("{:<12} {:<8} {:>6} {:>6} {:>7} {:>7} {:>7} {:>7}  {:>5} {:>4} {:>4} {:>7} {:>6}\n", "step",
             "frames", "turn", "p95", "along", "p95", "across", "p95", "good", "weak", "lost", "seconds",
             "fps");
  for (const TruthRow& row : rows)
    for (const bool training : {true, false}) {
      const TruthScore& s = training ? row.comparison.training : row.comparison.held_out;
      const PoseErrors& p = s.pose;
      fmt::print(
          "{:<12} {:<8} {:>5.2f}° {:>5.2f}° {:>5.2f} % {:>5.2f} % {:>4.2f} mm {:>4.2f} mm {:>4} {:>4} "
          "{:>4} {:>7.1f} {:>6.2f}\n",
          training ? row.step : "", training ? "training" : "held out", p.turn_median_deg, p.turn_p95_deg,
          p.along_median_percent, p.along_p95_percent, p.across_median_mm, p.across_p95_mm, s.good, s.weak,
          s.lost, row.seconds, row.frames_per_second);
    }
  fmt::print("\ncorrelation with the truth\n{:<22}", "");
  for (const TruthCorrelation& c : rows.front().comparison.training.correlations)
    fmt::print(" {:>13}", c.name);
  fmt::print("\n");
  for (const TruthRow& row : rows)
    for (const bool training : {true, false}) {
      fmt::print("{:<12} {:<8} ", training ? row.step : "", training ? "training" : "held out");
      for (const TruthCorrelation& c :
           (training ? row.comparison.training : row.comparison.held_out).correlations)
        fmt::print(" {:>13}", c.value ? fmt::format("{:.3f}", *c.value) : "-");
      fmt::print("\n");
    }
  fmt::print("\ntaken out before: one scale and one offset of the head's frame, from training frames\n");
  for (const TruthRow& row : rows) {
    const TruthAlignment& a = row.comparison.alignment;
    const Vec3d t = 1000 * a.truth_head_from_head.translation();
    fmt::print("{:<12} scale {:.4f}, turn {:.2f}°, shift {:.1f} {:.1f} {:.1f} mm\n", row.step, a.scale,
               Eigen::AngleAxisd(a.truth_head_from_head.linear()).angle() * 180 / std::numbers::pi, t.x(),
               t.y(), t.z());
  }
  fmt::print("\ndistance of the face at rest to the true surface\n");
  for (const TruthRow& row : rows)
    fmt::print("{:<12} {:.2f} mm rms\n", row.step, row.comparison.shape_rms_mm);
}

// -- On a real clip

nlohmann::json to_json(const CheckRow& row) {
  nlohmann::json offsets = nlohmann::json::array();
  for (const Vec2d& offset : row.fresh.usual_offset) offsets.push_back({offset.x(), offset.y()});
  return {{"step", row.step},
          {"frames", row.frames},
          {"good", row.good},
          {"weak", row.weak},
          {"lost", row.lost},
          {"inner_error_px", row.inner_error_px},
          {"withheld_median_px", row.withheld.median_px},
          {"withheld_p90_px", row.withheld.p90_px},
          {"withheld_tracks", row.withheld.tracks},
          {"withheld_on_head", row.withheld.on_head},
          {"withheld_observations", row.withheld.observations},
          {"fresh_landmarks_px", row.fresh.mean_px},
          {"fresh_moving_px", row.fresh.moving_px},
          {"fresh_frames", row.fresh.frames},
          {"landmark_offsets", offsets},
          {"still_jitter_px", row.stillness.jitter_px},
          {"still_frames", row.stillness.frames},
          {"marked_mouths", row.marks.mouths},
          {"wrong_mouths", row.marks.wrong_mouths},
          {"marked_eyes", row.marks.eyes},
          {"wrong_eyes", row.marks.wrong_eyes},
          {"seconds", row.seconds},
          {"frames_per_second", row.frames_per_second}};
}

void print_rows(const std::vector<CheckRow>& rows) {
  fmt::print("{:<12} {:>5} {:>4} {:>4} {:>9} {:>6} {:>9} {:>9} {:>9} {:>9} {:>7} {:>7} {:>6}\n", "step",
             "good", "weak", "lost", "withheld", "p90", "of points", "landmarks", "moving", "jitter", "still",
             "seconds", "fps");
  for (const CheckRow& row : rows)
    fmt::print(
        "{:<12} {:>5} {:>4} {:>4} {:>6.3f} px {:>6.3f} {:>4}/{:<4} {:>6.2f} px {:>6.2f} px {:>6.3f} px "
        "{:>7} {:>7.1f} {:>6.2f}\n",
        row.step, row.good, row.weak, row.lost, row.withheld.median_px, row.withheld.p90_px,
        row.withheld.on_head, row.withheld.tracks, row.fresh.mean_px, row.fresh.moving_px,
        row.stillness.jitter_px, row.stillness.frames, row.seconds, row.frames_per_second);
  fmt::print("px of the tracker's working picture (longer side 512)\n");
  for (const CheckRow& row : rows) {
    const MarkScore& m = row.marks;
    if (m.mouths + m.eyes == 0) continue;
    fmt::print(
        "{:<12} mouths as marked {} of {}, wrong in frames [{}]; eyes {} of {}, wrong in frames [{}]\n",
        row.step, m.mouths - int(m.wrong_mouths.size()), m.mouths, fmt::join(m.wrong_mouths, " "),
        m.eyes - int(m.wrong_eyes.size()), m.eyes, fmt::join(m.wrong_eyes, " "));
  }
}

// A project's clip with its crop, cameras and split, or a bare clip under an assumed camera.
Result<StudyClip> study_clip(const TrackStudyArguments& arguments) {
  StudyClip clip;
  ProjectOptions models = arguments.models;
  std::error_code ignored;
  if (fs::is_directory(arguments.clip, ignored)) {
    const auto project = open_project(arguments.clip);
    if (!project) return project.error();
    const auto capture = read_capture(capture_path(*project));
    if (!capture) return capture.error();
    auto cameras = read_cameras(cameras_path(*project));
    if (!cameras) return cameras.error();
    clip.video = project->options.shared.video;
    clip.region = {capture->crop.x, capture->crop.y, capture->crop.side, capture->crop.side};
    clip.cameras = std::move(*cameras);
    clip.held_out = held_out_frames(*capture);
    if (models.shared.head_model.empty()) models.shared.head_model = project->options.shared.head_model;
  } else {
    const auto info = probe_video(arguments.clip);
    if (!info) return info.error();
    clip.video = arguments.clip;
    clip.cameras = assumed_camera(*info);
  }
  auto model = project_head_model(models);
  if (!model) return model.error();
  clip.model = std::move(*model);
  if (!arguments.marks.empty()) {
    auto marks = read_face_marks(arguments.marks);
    if (!marks) return marks.error();
    clip.marks = std::move(*marks);
  }
  return clip;
}

template <class Row>
int report(const CommonOptions& common, const Result<std::vector<Row>>& rows) {
  if (!rows) return report_failure(rows.error());
  if (!common.json) {
    print_rows(*rows);
    return kExitDone;
  }
  nlohmann::json list = nlohmann::json::array();
  for (const Row& row : *rows) list.push_back(to_json(row));
  print_json({{"rows", list}});
  return kExitDone;
}

int run(const TrackStudyArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  if (arguments.clip.empty() == arguments.demo.empty()) {
    return report_failure({ErrorCode::bad_input, "Say what to study: a clip or project, or a demo.",
                           "likeness study track CLIP, or likeness study track --demo FOLDER", ""});
  }
  TrackOptions base;
  base.predictor = arguments.models.shared.landmark_model;
  const auto steps = track_steps(arguments.steps, base);
  if (!steps) return report_failure(steps.error());
  if (!arguments.demo.empty()) {
    const auto model = project_head_model(arguments.models);
    if (!model) return report_failure(model.error());
    std::optional<Result<std::vector<TruthRow>>> rows;
    {
      const ProgressLine line(arguments.common);
      rows = study_against_truth(arguments.demo, *model, *steps, arguments.tracks, line.progress(),
                                 stop_on_signals());
    }
    return report(arguments.common, *rows);
  }
  const auto clip = study_clip(arguments);
  if (!clip) return report_failure(clip.error());
  std::optional<Result<std::vector<CheckRow>>> rows;
  {
    const ProgressLine line(arguments.common);
    rows = study_real_clip(*clip, *steps, arguments.tracks, line.progress(), stop_on_signals());
  }
  return report(arguments.common, *rows);
}

void add_track_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<TrackStudyArguments>();
  CLI::App* verb = study.add_subcommand("track", "What each step of the tracker brings");
  verb->add_option("clip", a->clip, "A clip or a project: judged by measurements the track has not seen");
  verb->add_option("--demo", a->demo, "A folder of `likeness demo`: judged by its truth");
  verb->add_option(
      "--steps", a->steps,
      fmt::format("Steps to measure, of: {}; default: all", fmt::join(track_step_names(), ", ")));
  verb->add_option("--tracks", a->tracks, "A folder to keep each step's track in");
  verb->add_option("--marks", a->marks,
                   "A file of what was seen of mouth and eyes in the clip (core/lab/truth/face_marks.h)");
  verb->add_option("--head-model", a->models.shared.head_model,
                   "A head model file (.npz); default: the project's, or the built-in head");
  verb->add_option("--landmark-model", a->models.shared.landmark_model,
                   "A dlib 68-point shape predictor; default: the system's");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

// -- Driving

struct DriveStudyArguments {
  CommonOptions common;
  std::vector<fs::path> demo;  // the avatar's project, the driver's demo
  fs::path track, head_model, landmark_model;
};

Result<DriveScore> study_drive(const DriveStudyArguments& a, const Progress& progress, std::stop_token stop) {
  const auto opened = open_avatar(a.demo[0]);
  if (!opened) return opened.error();
  const auto truth = read_track_truth(a.demo[1]);
  if (!truth) return truth.error();
  DriveRequest request;
  request.video = a.demo[1] / "demo.mp4";
  request.track = a.track;
  request.head_model = a.head_model;
  request.landmark_model = a.landmark_model;
  request.options.clamp = false;  // what is held back is the capture's doing, not the transfer's
  const auto clip = drive_clip(*opened, request, progress, stop);
  if (!clip) return clip.error();
  HeadModel other;
  if (!a.head_model.empty()) {
    ProjectOptions models;
    models.shared.head_model = a.head_model;
    auto model = project_head_model(models);
    if (!model) return model.error();
    other = std::move(*model);
  }
  return score_drive(opened->avatar, opened->model, clip->track, a.head_model.empty() ? opened->model : other,
                     *truth, request.options);
}

int run(const DriveStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  std::optional<Result<DriveScore>> score;
  {
    const ProgressLine line(a.common);
    score = study_drive(a, line.progress(), stop_on_signals());
  }
  if (!*score) return report_failure(score->error());
  const DriveScore& s = **score;
  if (a.common.json) {
    nlohmann::json actions = nlohmann::json::array();
    for (const DrivenAction& action : s.actions)
      actions.push_back({{"name", action.name},
                         {"correlation", finite_or_null(action.correlation)},
                         {"gain", action.gain},
                         {"jitter_ratio", action.jitter_ratio}});
    print_json({{"frames", s.frames},
                {"bridged", s.bridged},
                {"mean_correlation", s.mean_correlation},
                {"neutral_psnr_db", s.neutral_psnr_db},
                {"neutral_difference", s.neutral_difference},
                {"actions", actions}});
    return kExitDone;
  }
  fmt::print("{:<16} {:>11} {:>6} {:>7}\n", "action", "correlation", "gain", "jitter");
  for (const DrivenAction& action : s.actions)
    fmt::print("{:<16} {:>11} {:>6.2f} {:>7.2f}\n", action.name,
               action.correlation ? fmt::format("{:.3f}", *action.correlation) : "-", action.gain,
               action.jitter_ratio);
  fmt::print(
      "mean correlation {:.3f} over {} frames ({} bridged); at rest {:.1f} dB, at most {} levels apart\n",
      s.mean_correlation, s.frames, s.bridged, s.neutral_psnr_db, s.neutral_difference);
  return kExitDone;
}

void add_drive_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<DriveStudyArguments>();
  CLI::App* verb = study.add_subcommand("drive", "One person's avatar driven by another's known performance");
  verb->add_option("--demo", a->demo, "The avatar's project, then the driver's folder of `likeness demo`")
      ->expected(2)
      ->required();
  verb->add_option("--track", a->track, "track.json of the driver's demo: read if it exists, else written");
  verb->add_option("--head-model", a->head_model,
                   "Head model to track the driver with (.npz); default: the avatar's");
  verb->add_option("--landmark-model", a->landmark_model,
                   "A dlib 68-point shape predictor; default: the system's");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace

void add_study_command(CLI::App& program, int& exit_code) {
  CLI::App* study = program.add_subcommand("study", "Measurements that take a while and end in a table");
  study->require_subcommand(0, 1);
  add_model_study(*study, exit_code);
  add_track_study(*study, exit_code);
  add_drive_study(*study, exit_code);
  add_camera_study(*study, exit_code);
  add_matte_study(*study, exit_code);
  add_gain_study(*study, exit_code);
  add_landmark_study(*study, exit_code);
  add_live_study(*study, exit_code);
  add_mark_study(*study, exit_code);
  add_render_study(*study, exit_code);
  add_cull_study(*study, exit_code);
  add_true_detail(*study, exit_code);
}

}  // namespace likeness::app
