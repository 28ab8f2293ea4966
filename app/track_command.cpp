// likeness track: the head in every frame of a clip, without a project.
#include <chrono>
#include <memory>

#include <fmt/format.h>

#include "app/clip_camera.h"
#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/project/run_stages.h"
#include "core/track/track_clip.h"
#include "core/video/decode.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct TrackArguments {
  CommonOptions common;
  fs::path video, out;
  ProjectOptions models;  // head and landmark model only
};

int run(const TrackArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  const auto info = probe_video(arguments.video);
  if (!info) return report_failure(info.error());
  const auto model = project_head_model(arguments.models);
  if (!model) return report_failure(model.error());
  TrackOptions options;
  options.predictor = arguments.models.landmark_model;
  const auto start = std::chrono::steady_clock::now();
  std::optional<Result<Track>> track;
  {
    const ProgressLine line(arguments.common);
    track = track_clip(arguments.video, {0, 0, info->width, info->height}, assumed_camera(*info), {}, *model,
                       options, line.progress(), stop_on_signals());
  }
  if (!*track) return report_failure(track->error());
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (const auto written = write_track(arguments.out, **track); !written)
    return report_failure(written.error());
  int count[3] = {};
  double error_px = 0;
  for (const TrackedFrame& frame : (*track)->frames) {
    ++count[int(frame.status)];
    if (frame.status != FrameStatus::lost) error_px += frame.inner_error_px;
  }
  const int frames = int((*track)->frames.size()), followed = count[0] + count[1];
  error_px = followed > 0 ? error_px / followed : 0;
  if (arguments.common.json) {
    print_json({{"frames", frames},
                {"good", count[0]},
                {"weak", count[1]},
                {"lost", count[2]},
                {"inner_error_px", error_px},
                {"frames_per_second", frames / seconds}});
  } else {
    fmt::print(stderr, "{} frames: {} good, {} weak, {} lost; landmarks within {:.2f} px.\n", frames,
               count[0], count[1], count[2], error_px);
  }
  return kExitDone;
}

}  // namespace

void add_track_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<TrackArguments>();
  CLI::App* verb = program.add_subcommand("track", "Track the head in a clip");
  verb->add_option("video", a->video, "The clip")->required();
  verb->add_option("--out", a->out, "track.json to write")->required();
  verb->add_option("--head-model", a->models.head_model,
                   "A head model: FLAME's .pkl, ICT-FaceKit's folder, or a .npz; default: the built-in head");
  verb->add_option("--landmark-model", a->models.landmark_model,
                   "A dlib 68-point shape predictor; default: the system's");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
