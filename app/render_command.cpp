// likeness render: pictures of an avatar - orbit, poses, expression sweeps - as mp4, PNG sequence or still.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/head/pose_head.h"
#include "core/image/files.h"
#include "core/project/run_stages.h"
#include "core/render/camera_path.h"
#include "core/render/render.h"
#include "core/track/track.h"
#include "core/video/encode.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct RenderArguments {
  CommonOptions common;
  fs::path project, out;
  std::string camera = "still", background;
  double orbit_deg = 30, frames_per_second = 25;
  int frames = 0;  // 0 = as the path needs
  std::vector<std::string> expressions;
  std::vector<double> pose_deg;  // yaw, pitch, roll
  bool alpha = false;
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

Result<Vec3f> parse_colour(const std::string& text) {
  unsigned value = 0;
  const char* begin = text.data() + 1;
  if (text.size() == 7 && text.front() == '#') {
    const auto [end, failure] = std::from_chars(begin, begin + 6, value, 16);
    if (failure == std::errc{} && end == begin + 6) {
      return Vec3f(Vec3f(float(value >> 16), float(value >> 8 & 255), float(value & 255)) / 255.0f);
    }
  }
  return Error{ErrorCode::bad_input, fmt::format("\"{}\" is not a background.", text),
               "Write plate, or a colour such as #e8e8e8", ""};
}

// A film: the camera and the state of the avatar in every frame.
struct Film {
  std::vector<Camera> cameras;
  std::vector<RenderState> states;
};

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

Result<Film> make_film(const RenderArguments& arguments, const Project& project, const Avatar& avatar,
                       const HeadModel& model) {
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
  if (arguments.out.extension() == ".png" && film.cameras.size() > 1) {
    return Error{ErrorCode::bad_input,
                 fmt::format("{} frames do not fit into one picture.", film.cameras.size()),
                 "Name an .mp4 or a folder as --out.", arguments.out.string()};
  }
  std::array<double, 3> turn{};
  for (std::size_t i = 0; i < arguments.pose_deg.size(); ++i)
    turn[i] = arguments.pose_deg[i] * std::numbers::pi / 180;
  const HeadShape shape = shape_head(model, avatar.person);
  const Vec3d pivot = shape.joints[kNeck].cast<double>();
  const Pose head = turned_head(avatar.world_from_head, pivot, turn[0], turn[1], turn[2]);
  for (std::size_t i = 0; i < film.cameras.size(); ++i) {
    const float t = film.cameras.size() > 1 ? float(i) / float(film.cameras.size() - 1) : 1;
    std::vector<std::pair<std::string, float>> actions;
    for (const ActionSweep& s : sweeps) actions.emplace_back(s.name, s.from + t * (s.to - s.from));
    auto articulation = articulate(model, avatar.neutral, actions);
    if (!articulation) return articulation.error();
    film.states.push_back({head, avatar.world_from_torso, std::move(*articulation)});
  }
  return film;
}

// Frames to an mp4, to a folder of PNGs, or to one PNG.
class FrameSink {
 public:
  static Result<FrameSink> open(const RenderArguments& arguments, const Intrinsics& intrinsics) {
    FrameSink sink;
    sink.out_ = arguments.out;
    if (arguments.out.extension() == ".mp4") {
      auto writer = VideoWriter::create(arguments.out, intrinsics.width, intrinsics.height,
                                        {.frames_per_second = arguments.frames_per_second});
      if (!writer) return writer.error();
      sink.video_.emplace(std::move(*writer));
    }
    return sink;
  }
  Result<void> add(const Image8& picture, std::size_t index) {
    if (video_) return video_->add(picture);
    if (out_.extension() == ".png") return write_image(out_, picture);
    return write_image(out_ / fmt::format("{:06}.png", index), picture);
  }
  Result<void> finish() { return video_ ? video_->finish() : Result<void>{}; }

 private:
  fs::path out_;
  std::optional<VideoWriter> video_;
};

// Alpha straight on disk, premultiplied inside.
Image8 straight_alpha(Image rgba) {
  for (std::size_t i = 0; i < rgba.data.size(); i += 4) {
    const float alpha = rgba.data[i + 3];
    for (int c = 0; c < 3; ++c)
      rgba.data[i + std::size_t(c)] = alpha > 1e-4f ? rgba.data[i + std::size_t(c)] / alpha : 0;
  }
  return to_bytes(rgba);
}

Result<int> render_film(const RenderArguments& arguments, const Progress& progress, std::stop_token stop) {
  const auto project = open_project(arguments.project);
  if (!project) return project.error();
  if (std::error_code ignored; !fs::exists(avatar_path(*project), ignored)) {
    return Error{ErrorCode::not_found, fmt::format("{} holds no trained avatar.", arguments.project.string()),
                 "Run: likeness build VIDEO --project DIR", ""};
  }
  const auto avatar = read_avatar(avatar_path(*project));
  if (!avatar) return avatar.error();
  const auto model = project_head_model(project->options);
  if (!model) return model.error();
  if (model->hash != avatar->head_model_hash) {
    return Error{ErrorCode::bad_input,
                 fmt::format("The avatar was made with the {} head model, the project now names the {} one.",
                             avatar->head_model_name, model->name),
                 "Build the project again, so that both agree.", arguments.project.string()};
  }
  const auto film = make_film(arguments, *project, *avatar, *model);
  if (!film) return film.error();
  // The plate is what the resting camera saw: it holds for a still camera only.
  std::string background = arguments.background;
  if (background.empty())
    background = arguments.camera == "still" && !avatar->plate.empty() ? "plate" : "#e6e6e6";
  const auto colour =
      background == "plate" ? Result<Vec3f>(Vec3f(0.9f, 0.9f, 0.9f)) : parse_colour(background);
  if (!colour) return colour.error();
  if (background == "plate" && avatar->plate.empty()) {
    return Error{ErrorCode::bad_input, "This avatar has no background plate: its camera moved.",
                 "Choose a colour, e.g. --background #e6e6e6", ""};
  }
  const Intrinsics& picture = film->cameras.front().intrinsics;
  if (background == "plate" &&
      (avatar->plate.width != picture.width || avatar->plate.height != picture.height)) {
    return Error{ErrorCode::bad_input,
                 fmt::format("The plate has {} x {} px, the pictures {} x {}.", avatar->plate.width,
                             avatar->plate.height, picture.width, picture.height),
                 "Choose a colour, e.g. --background #e6e6e6", ""};
  }
  if (arguments.alpha && arguments.out.extension() == ".mp4") {
    return Error{ErrorCode::bad_input, "An mp4 holds no transparency.",
                 "With --alpha name a folder or a .png as --out.", ""};
  }
  auto sink = FrameSink::open(arguments, picture);
  if (!sink) return sink.error();
  for (std::size_t i = 0; i < film->cameras.size(); ++i) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(i) / double(film->cameras.size()),
                    fmt::format("frame {} of {}", i + 1, film->cameras.size()));
    const RenderedFrame frame = render_frame(*avatar, film->cameras[i], film->states[i]);
    const Image8 picture =
        arguments.alpha
            ? straight_alpha(frame.rgba)
            : to_bytes(composite(frame.rgba, background == "plate" ? avatar->plate : Image8{}, *colour));
    if (const auto added = sink->add(picture, i); !added) return added.error();
  }
  if (const auto finished = sink->finish(); !finished) return finished.error();
  return int(film->cameras.size());
}

int run(const RenderArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
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
  verb->add_option("--out", a->out, "FILE.mp4, FILE.png, or a folder for a PNG sequence")->required();
  verb->add_option("--camera", a->camera, "still, orbit, or a cameras.json to follow");
  verb->add_option("--orbit", a->orbit_deg, "Half angle of the orbit, degrees")
      ->check(CLI::Range(1.0, 180.0));
  verb->add_option("--frames", a->frames, "Number of frames")->check(CLI::Range(1, 100000));
  verb->add_option("--fps", a->frames_per_second, "Frames per second")->check(CLI::Range(1.0, 240.0));
  verb->add_option("--expression", a->expressions,
                   "NAME=VALUE, or NAME=FROM..TO for a sweep; may be repeated");
  verb->add_option("--pose", a->pose_deg, "Head turn yaw,pitch,roll in degrees")->delimiter(',')->expected(3);
  verb->add_option("--background", a->background, "plate, or a colour such as #e8e8e8");
  verb->add_flag("--alpha", a->alpha, "Transparent background (PNG only)");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
