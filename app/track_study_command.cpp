// likeness study track: what each step of the tracker brings on a real clip; or an existing track, beside
// what was seen in the pictures.
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/removed.h"
#include "app/tables.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/base/path_text.h"
#include "core/camera/clip_camera.h"
#include "core/capture/capture.h"
#include "core/face/landmarks.h"
#include "core/lab/truth/track_study.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/video/decode.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct TrackStudyArguments {
  CommonOptions common;
  TableOptions output;
  fs::path clip, tracks, marks;
  std::vector<std::string> steps;
  ProjectOptions models;  // head and landmark model only
};

// -- What was marked by eye

Table marks_table() {
  return {.name = "marks",
          .title = "Beside what was seen by eye",
          .columns = {{"step", "track"},
                      {"marked_good", "good frames marked", 0},
                      {"misplaced", "wrong in frames"},
                      {"marked_mouths", "mouths", 0},
                      {"wrong_mouths", "wrong in frames"},
                      {"marked_eyes", "eyes", 0},
                      {"wrong_eyes", "wrong in frames"}}};
}

std::vector<TableCell> mark_cells(const std::string& step, const MarkScore& m) {
  return {step, m.placed, m.misplaced, m.mouths, m.wrong_mouths, m.eyes, m.wrong_eyes};
}

Result<std::vector<Table>> compare_marks(const TrackStudyArguments& a) {
  const auto track = read_track(a.clip);
  if (!track) return track.error();
  ProjectOptions models = a.models;
  if (models.shared.head_model.empty()) models.shared.head_model = path_of_text(track->head_model_file);
  const auto model = project_head_model(models);
  if (!model) return model.error();
  if (const auto fits = check_track_fits(*track, *model); !fits) {
    return Error{ErrorCode::bad_input, fits.error().what,
                 "Name the track's own head model with --head-model.", a.clip.string()};
  }
  const auto marks = read_face_marks(a.marks);
  if (!marks) return marks.error();
  int good = 0, weak = 0, lost = 0;
  for (const TrackedFrame& frame : track->frames)
    ++(frame.status == FrameStatus::good ? good : frame.status == FrameStatus::weak ? weak : lost);
  const std::string name = a.clip.filename().string();
  Table frames{.name = "frames"};
  frames.columns = {{"step", "track"},
                    {"frames", "frames", 0},
                    {"good", "good", 0},
                    {"weak", "weak", 0},
                    {"lost", "lost", 0}};
  frames.rows = {{name, int(track->frames.size()), good, weak, lost}};
  Table table = marks_table();
  table.rows = {mark_cells(name, score_marks(*track, *model, *marks))};
  return std::vector<Table>{std::move(frames), std::move(table)};
}

// -- The steps

std::vector<Table> step_tables(const std::vector<CheckRow>& rows) {
  Table steps{.name = "steps", .title = "Each step of the tracker"};
  steps.columns = {{"step", "step"},
                   {"frames", "", 0},
                   {"good", "good", 0},
                   {"weak", "weak", 0},
                   {"lost", "lost", 0},
                   {"inner_error_px", "", 2},
                   {"withheld_median_px", "withheld, px", 3},
                   {"withheld_p90_px", "p90", 3},
                   {"withheld_on_head", "on the head", 0},
                   {"withheld_tracks", "of points", 0},
                   {"withheld_observations", "", 0},
                   {"fresh_landmarks_px", "landmarks, px"},
                   {"fresh_moving_px", "moving, px"},
                   {"fresh_frames", "", 0},
                   {"still_jitter_px", "jitter, px", 3},
                   {"still_frames", "still frames", 0},
                   {"seconds", "seconds", 1},
                   {"frames_per_second", "frames/s"}};
  steps.notes = {"px of the tracker's working picture (longer side 512)"};
  Table marks = marks_table();
  Table offsets{.name = "landmark_offsets",
                .columns = {{"step", ""}, {"landmark", ""}, {"x", ""}, {"y", ""}},
                .printed = false};
  for (const CheckRow& row : rows) {
    steps.rows.push_back({row.step, row.frames, row.good, row.weak, row.lost, row.inner_error_px,
                          row.withheld.median_px, row.withheld.p90_px, row.withheld.on_head,
                          row.withheld.tracks, row.withheld.observations, row.fresh.mean_px,
                          row.fresh.moving_px, row.fresh.frames, row.stillness.jitter_px,
                          row.stillness.frames, row.seconds, row.frames_per_second});
    if (row.marks.mouths + row.marks.eyes + row.marks.placed > 0)
      marks.rows.push_back(mark_cells(row.step, row.marks));
    for (int i = 0; i < kLandmarkCount; ++i) {
      const Vec2d& offset = row.fresh.usual_offset[std::size_t(i)];
      offsets.rows.push_back({row.step, i, offset.x(), offset.y()});
    }
  }
  std::vector<Table> tables{std::move(steps)};
  if (!marks.rows.empty()) tables.push_back(std::move(marks));
  tables.push_back(std::move(offsets));
  return tables;
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
    const PixelRect part = tracked_part(*capture);
    clip.region = {part.x, part.y, part.width, part.height};
    clip.cameras = std::move(*cameras);
    clip.held_out = silent_frames(*capture);
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

Result<std::vector<Table>> compare_steps(const TrackStudyArguments& a) {
  TrackOptions base;
  base.predictor = a.models.shared.landmark_model;
  const auto steps = track_steps(a.steps, base);
  if (!steps) return steps.error();
  const auto clip = study_clip(a);
  if (!clip) return clip.error();
  const ProgressLine line(quiet_if_csv(a.common, a.output));
  const auto rows = study_real_clip(*clip, *steps, a.tracks, line.progress(), stop_on_signals());
  if (!rows) return rows.error();
  return step_tables(*rows);
}

int run(const TrackStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const bool is_track = a.clip.extension() == ".json";
  if (is_track && a.marks.empty())
    return report_failure({ErrorCode::bad_input, "A track alone cannot be compared with anything.",
                           "Give what was seen of its clip: --marks MARKS.json", a.clip.string()});
  const auto tables = is_track ? compare_marks(a) : compare_steps(a);
  return tables ? report_tables(a.common, a.output, *tables) : report_failure(tables.error());
}

}  // namespace

void add_track_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<TrackStudyArguments>();
  CLI::App* verb = study.add_subcommand(
      "track", "What each step of the tracker brings, by measurements the track has not seen");
  verb->add_option("clip", a->clip, "A clip or a project; or with --marks an existing track.json")
      ->required();
  verb->add_option(
      "--steps", a->steps,
      fmt::format("Steps to measure, of: {}; default: all", fmt::join(track_step_names(), ", ")));
  verb->add_option("--tracks", a->tracks, "A folder to keep each step's track in");
  verb->add_option("--marks", a->marks,
                   "A file of how mouth and eyes were seen in the clip (core/lab/truth/face_marks.h)");
  verb->add_option("--head-model", a->models.shared.head_model,
                   "A head model file (.npz); default: the project's, the track's, or the built-in head");
  verb->add_option("--landmark-model", a->models.shared.landmark_model, kLandmarkModelHelp);
  add_removed_option(*verb, "--demo", "study truth DEMO");
  add_common_options(*verb, a->common);
  add_table_options(*verb, a->output);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
