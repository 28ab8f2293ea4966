// likeness render: pictures of an avatar - orbit, poses, expression sweeps - as mp4, PNG sequence or still.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/driving.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/film/film.h"
#include "core/head/pose_head.h"
#include "core/render/camera_path.h"
#include "core/track/track.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct RenderArguments {
  CommonOptions common;
  fs::path project, out, drive;
  std::string camera = "still", background;
  double orbit_deg = 30, frames_per_second = 25;
  int frames = 0;  // 0 = as the path needs
  std::vector<std::string> expressions;
  std::vector<double> pose_deg;  // yaw, pitch, roll
  RenderQuality quality = RenderQuality::final;
  bool alpha = false, list_actions = false;
};

// An action going from one value to another over the film.
struct ActionSweep {
  std::string name;
  float from = 0, to = 0;
};

std::optional<float> parse_number(std::string_view text) {
  float value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

// NAME=V holds, NAME=A..B sweeps.
Result<ActionSweep> parse_action(const std::string& text) {
  const Error wrong{ErrorCode::bad_input, fmt::format("\"{}\" is not an expression.", text),
                    "Write NAME=VALUE, or NAME=FROM..TO for a sweep, e.g. jawOpen=0..1", ""};
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) return wrong;
  const std::string_view values = std::string_view(text).substr(equals + 1);
  const std::size_t dots = values.find("..");
  const auto from = parse_number(values.substr(0, dots));
  const auto to = dots == std::string_view::npos ? from : parse_number(values.substr(dots + 2));
  if (!from || !to) return wrong;
  return ActionSweep{text.substr(0, equals), *from, *to};
}

Result<std::vector<Camera>> film_cameras(const RenderArguments& arguments, const Project& project,
                                         const Avatar& avatar, int frames) {
  if (arguments.camera == "still" || arguments.camera == "orbit") {
    const double amplitude = arguments.camera == "orbit" ? arguments.orbit_deg * std::numbers::pi / 180 : 0;
    std::vector<Camera> cameras;
    for (const double yaw : orbit_yaws(frames, amplitude))
      cameras.push_back(orbit_camera(avatar, avatar.world_from_head, yaw));
    return cameras;
  }
  auto set = read_cameras(arguments.camera);
  if (!set) return set.error();
  const Intrinsics& first = set->cameras.front().intrinsics;
  const bool one_size = std::ranges::all_of(set->cameras, [&](const Camera& camera) {
    return camera.intrinsics.width == first.width && camera.intrinsics.height == first.height;
  });
  if (!one_size) {
    return Error{ErrorCode::bad_input, "The cameras to follow differ in picture size.",
                 "Give every camera of the file the same width and height.", arguments.camera};
  }
  if (set->scale == CameraScale::arbitrary) {  // the project's own solve: the track knows its metre
    const auto track = read_track(track_path(project));
    if (!track) return track.error();
    for (Camera& camera : set->cameras) camera.cam_from_world.translation() *= track->metres_per_unit;
  }
  return std::move(set->cameras);
}

Result<Film> make_film(const RenderArguments& arguments, const OpenedAvatar& opened) {
  const auto& [project, avatar, model] = opened;
  std::vector<ActionSweep> sweeps;
  for (const std::string& text : arguments.expressions) {
    auto sweep = parse_action(text);
    if (!sweep) return sweep.error();
    sweeps.push_back(std::move(*sweep));
  }
  const bool sweeping =
      std::any_of(sweeps.begin(), sweeps.end(), [](const ActionSweep& s) { return s.from != s.to; });
  const bool still = arguments.out.extension() == ".png" || (arguments.camera == "still" && !sweeping);
  const int wanted = arguments.frames > 0 ? arguments.frames : still ? 1 : 100;

  Film film;
  auto cameras = film_cameras(arguments, project, avatar, wanted);
  if (!cameras) return cameras.error();
  film.cameras = std::move(*cameras);
  std::array<double, 3> turn{};
  for (std::size_t i = 0; i < arguments.pose_deg.size(); ++i)
    turn[i] = arguments.pose_deg[i] * std::numbers::pi / 180;
  const Vec3d pivot = shape_head(model, avatar.person).joints[kNeck].cast<double>();
  const Pose head = turned_head(avatar.world_from_head, pivot, turn[0], turn[1], turn[2]);
  for (std::size_t i = 0; i < film.cameras.size(); ++i) {
    const float t = film.cameras.size() > 1 ? float(i) / float(film.cameras.size() - 1) : 1;
    std::vector<std::pair<std::string, float>> actions;
    for (const ActionSweep& s : sweeps) actions.emplace_back(s.name, s.from + t * (s.to - s.from));
    auto articulation = articulate(model, avatar.neutral, actions);
    if (!articulation) return articulation.error();
    film.poses.push_back({head, avatar.world_from_torso, std::move(*articulation)});
  }
  return film;
}

FilmOptions film_options(const RenderArguments& arguments) {
  FilmOptions options;
  options.out = arguments.out;
  options.background = arguments.background;
  options.camera_rests = arguments.camera == "still";
  options.alpha = arguments.alpha;
  options.quality = arguments.quality;
  options.frames_per_second = arguments.frames_per_second;
  return options;
}

// The avatar doing what somebody does in a clip, seen from the film's cameras.
Result<int> render_driven(const RenderArguments& arguments, const OpenedAvatar& opened,
                          const Progress& progress, std::stop_token stop) {
  if (!arguments.expressions.empty() || !arguments.pose_deg.empty()) {
    return Error{ErrorCode::bad_input, "The clip says what face and head do.",
                 "Leave out --expression and --pose, or --drive.", ""};
  }
  DriveRequest request;
  request.video = arguments.drive;
  request.landmark_model = opened.project.options.landmark_model;
  const auto clip = drive_clip(opened, request, progress.stage(0, 0.5, "driver"), stop);
  if (!clip) return clip.error();
  auto cameras = film_cameras(arguments, opened.project, opened.avatar, int(clip->frames.size()));
  if (!cameras) return cameras.error();
  Film film{std::move(*cameras), film_poses(*clip)};
  const std::size_t frames = std::min(film.cameras.size(), film.poses.size());
  film.cameras.resize(frames), film.poses.resize(frames);
  FilmOptions options = film_options(arguments);
  options.frames_per_second = clip->frames_per_second;
  return write_film(opened, film, options, progress.stage(0.5, 1, "render"), stop);
}

Result<int> render_film(const RenderArguments& arguments, const Progress& progress, std::stop_token stop) {
  const auto opened = open_avatar(arguments.project);
  if (!opened) return opened.error();
  if (!arguments.drive.empty()) return render_driven(arguments, *opened, progress, stop);
  const auto film = make_film(arguments, *opened);
  if (!film) return film.error();
  return write_film(*opened, *film, film_options(arguments), progress, stop);
}

// What the sliders are, and how much of each the capture showed.
int list_actions(const RenderArguments& arguments) {
  const auto opened = open_avatar(arguments.project);
  if (!opened) return report_failure(opened.error());
  nlohmann::json list = nlohmann::json::array();
  for (const ActionRange& range : opened->avatar.seen)
    list.push_back({{"name", range.name},
                    {"low", range.low},
                    {"high", range.high},
                    {"coverage", range.coverage},
                    {"histogram", range.histogram}});
  if (arguments.common.json) {
    print_json({{"head_model", opened->avatar.head_model_name}, {"actions", list}});
    return kExitDone;
  }
  fmt::print("{:<20} {:>15} {:>9}\n", "action", "seen", "coverage");
  for (const ActionRange& range : opened->avatar.seen)
    fmt::print("{:<20} {:>6.2f} to {:>5.2f} {:>7.0f} %\n", range.name, range.low, range.high,
               100 * range.coverage);
  return kExitDone;
}

int run(const RenderArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  if (arguments.list_actions) return list_actions(arguments);
  std::optional<Result<int>> frames;
  {
    const ProgressLine line(arguments.common);
    frames = render_film(arguments, line.progress().stage(0, 1, "render"), stop_on_signals());
  }
  if (!*frames) return report_failure(frames->error());
  if (arguments.common.json) {
    print_json({{"out", arguments.out.string()}, {"frames", **frames}});
  } else {
    fmt::print(stderr, "Wrote {} ({} frames).\n", arguments.out.string(), **frames);
  }
  return kExitDone;
}

}  // namespace

void add_render_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<RenderArguments>();
  CLI::App* verb = program.add_subcommand("render", "Pictures of the avatar: orbit, poses, expressions");
  verb->add_option("project", a->project, "Project folder")->required();
  verb->add_option("--out", a->out, "FILE.mp4, FILE.png, or a folder for a PNG sequence");
  verb->add_option("--camera", a->camera, "still, orbit, or a cameras.json to follow");
  verb->add_option("--orbit", a->orbit_deg, "Half angle of the orbit, degrees")
      ->check(CLI::Range(1.0, 180.0));
  verb->add_option("--frames", a->frames, "Number of frames")->check(CLI::Range(1, 100000));
  verb->add_option("--fps", a->frames_per_second, "Frames per second")->check(CLI::Range(1.0, 240.0));
  verb->add_option("--expression", a->expressions,
                   "NAME=VALUE, or NAME=FROM..TO for a sweep; may be repeated");
  verb->add_option("--pose", a->pose_deg, "Head turn yaw,pitch,roll in degrees")->delimiter(',')->expected(3);
  verb->add_option("--background", a->background, "plate, or a colour such as #e8e8e8");
  verb->add_option("--drive", a->drive,
                   "A clip whose performance the avatar takes over (see likeness drive)");
  add_quality_option(*verb, a->quality);
  verb->add_flag("--alpha", a->alpha, "Transparent background (PNG only)");
  verb->add_flag("--list-actions", a->list_actions, "Only list the named actions and what was seen of them");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] {
    if (a->out.empty() && !a->list_actions) throw CLI::RequiredError("--out");
    exit_code = run(*a);
  });
}

}  // namespace likeness::app
