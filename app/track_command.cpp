// likeness track: the head in every frame of a clip, without a project.
#include <chrono>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/camera/clip_camera.h"
#include "core/capture/choose_shots.h"
#include "core/capture/find_film.h"
#include "core/capture/scan_clip.h"
#include "core/face/landmarks.h"
#include "core/image/files.h"
#include "core/project/care.h"
#include "core/project/project_head_model.h"
#include "core/track/clip/error_strip.h"
#include "core/track/clip/overlay.h"
#include "core/track/clip/track_clip.h"
#include "core/video/decode.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct TrackArguments {
  CommonOptions common;
  fs::path video, out, overlay, strip;
  ProjectOptions models;  // head and landmark model only
};

// The clip's track in figures.
struct Tally {
  int frames = 0, good = 0, weak = 0, lost = 0;
  double inner_error_px = 0;
};

Tally tally(const Track& track) {
  Tally t;
  for (const TrackedFrame& frame : track.frames) {
    ++t.frames;
    if (frame.status == FrameStatus::lost) {
      ++t.lost;
      continue;
    }
    ++(frame.status == FrameStatus::good ? t.good : t.weak);
    t.inner_error_px += frame.inner_error_px;
  }
  if (t.good + t.weak > 0) t.inner_error_px /= t.good + t.weak;
  return t;
}

// Every stage's seconds, wall and processor, and the landmark and fit stages' seconds per frame.
nlohmann::json seconds_json(const std::vector<StageSeconds>& seconds, int frames) {
  nlohmann::json stages = nlohmann::json::object();
  double landmark_fit = 0;
  for (const StageSeconds& s : seconds) {
    nlohmann::json& stage =
        stages.emplace(s.stage, nlohmann::json::object()).first.value();  // some run twice
    stage = {{"wall", stage.value("wall", 0.0) + s.wall_s}, {"cpu", stage.value("cpu", 0.0) + s.cpu_s}};
    if (s.stage.starts_with("landmarks") || s.stage.starts_with("fit")) landmark_fit += s.cpu_s;
  }
  return {{"stages", stages}, {"landmark_fit_cpu_per_frame", frames > 0 ? landmark_fit / frames : 0.0}};
}

// The pictures first and the track last: if there is a track.json, everything that was asked for exists.
Result<void> write_results(const TrackArguments& arguments, const VideoInfo& info, const CameraSet& cameras,
                           const HeadModel& model, const Track& track, const Progress& progress) {
  if (!arguments.overlay.empty()) {
    OverlayOptions options;
    if (info.frames_per_second > 1) options.frames_per_second = info.frames_per_second;
    if (auto drawn = write_overlay(arguments.video, track, model, cameras, arguments.overlay, options,
                                   progress, stop_on_signals());
        !drawn)
      return drawn.error();
  }
  if (!arguments.strip.empty())
    if (auto drawn = write_image(arguments.strip, error_strip(track)); !drawn) return drawn.error();
  return write_track(arguments.out, track);
}

// No pose is carried over a cut.
Result<std::vector<FrameSpan>> find_cuts(const TrackArguments& arguments, const PixelRect& film,
                                         const Progress& progress) {
  std::error_code ignored;
  if (fs::is_directory(arguments.video, ignored)) return std::vector<FrameSpan>();  // photographs
  const auto detector = FaceDetector::load(arguments.models.shared.landmark_model);
  if (!detector) return detector.error();
  const auto scan = scan_clip(arguments.video, *detector, {}, film, progress, stop_on_signals());
  if (!scan) return scan.error();
  if (scan->fault) tell("{}\n", fault_words(*scan->fault));
  return every_shot(*scan);
}

int run(const TrackArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  for (const auto& [written, option] :
       {std::pair(arguments.out, "--out"), {arguments.overlay, "--overlay"}, {arguments.strip, "--strip"}}) {
    if (const auto free = written.empty() ? Result<void>() : check_free(written, option); !free)
      return report_failure(free.error());
    std::error_code ignored;
    if (!written.empty() && fs::equivalent(written, arguments.video, ignored))
      return report_failure({ErrorCode::bad_input, "What is written would replace the clip.",
                             "Give --out, --overlay and --strip names of their own.", written.string()});
  }
  const auto info = probe_video(arguments.video);
  if (!info) return report_failure(info.error());
  const auto model = project_head_model(arguments.models);
  if (!model) return report_failure(model.error());
  TrackOptions options;
  options.predictor = arguments.models.shared.landmark_model;
  options.every_frame = true;
  options.seconds = std::make_shared<std::vector<StageSeconds>>();
  const auto start = std::chrono::steady_clock::now();
  double seconds = 0;
  std::optional<Result<Track>> track;
  Result<void> written;
  {
    const ProgressLine line(arguments.common);
    const double share = arguments.overlay.empty() ? 1.0 : 0.85;
    const auto film =
        find_film(arguments.video, line.progress().stage(0, 0.05, "looking for bars"), stop_on_signals());
    if (!film) return report_failure(film.error());
    const CameraSet cameras = assumed_camera(*info, *film);
    const PixelRect part = film->empty() ? PixelRect{0, 0, info->width, info->height} : *film;
    const auto shots = find_cuts(arguments, part, line.progress().stage(0.05, 0.15, "looking for cuts"));
    if (!shots) return report_failure(shots.error());
    options.shots = *shots;
    track = track_clip(arguments.video, {part.x, part.y, part.width, part.height}, cameras, {}, *model,
                       options, line.progress().stage(0.15, share, "track"), stop_on_signals());
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (*track)
      written = write_results(arguments, *info, cameras, *model, **track,
                              line.progress().stage(share, 1, "overlay"));
  }
  if (!*track) return report_failure(track->error());
  if (!written) return report_failure(written.error());
  const Tally t = tally(**track);
  if (arguments.common.json) {
    print_json({{"frames", t.frames},
                {"good", t.good},
                {"weak", t.weak},
                {"lost", t.lost},
                {"inner_error_px", t.inner_error_px},
                {"frames_per_second", t.frames / seconds},
                {"seconds", seconds_json(*options.seconds, t.frames)}});
  } else {
    tell("{} frames: {} good, {} weak, {} lost; landmarks {:.2f} px off on average.\n", t.frames, t.good,
         t.weak, t.lost, t.inner_error_px);
  }
  return kExitDone;
}

CLI::Validator ending_check(std::string ending) {
  return CLI::Validator(
      [ending](const std::string& name) {
        return fs::path(name).extension() == ending ? std::string() : "the name must end in " + ending;
      },
      "NAME" + ending);
}

}  // namespace

void add_track_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<TrackArguments>();
  CLI::App* verb = program.add_subcommand("track", "Track the head in a clip");
  verb->add_option("video", a->video, "The clip")->required();
  verb->add_option("--out", a->out, "track.json to write")->required();
  verb->add_option("--overlay", a->overlay,
                   "A film (.mp4) of the clip with head model, landmarks, gaze and verdict drawn over it")
      ->check(ending_check(".mp4"));
  verb->add_option("--strip", a->strip, "A picture (.png) of every frame's error, spread and verdict")
      ->check(ending_check(".png"));
  verb->add_option("--head-model", a->models.shared.head_model,
                   "A head model: FLAME's .pkl, ICT-FaceKit's folder, or a .npz; default: the built-in head");
  verb->add_option("--landmark-model", a->models.shared.landmark_model, kLandmarkModelHelp);
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
