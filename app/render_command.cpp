// likeness render: pictures of an avatar - orbit, poses, expression sweeps - as mp4, PNG sequence or still.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/backend_option.h"
#include "app/camera_option.h"
#include "app/commands.h"
#include "app/holds_json.h"
#include "app/removed.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/direct/direct_avatar.h"
#include "core/direct/performance.h"
#include "core/direct/seen_limits.h"
#include "core/export/write_film.h"
#include "core/export/write_out.h"
#include "core/head/pose_head.h"
#include "core/render/camera_path.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct RenderArguments {
  CommonOptions common;
  fs::path project, out, performance;
  CameraOptions camera;
  std::string background;
  double frames_per_second = 0;  // 0 = 25, or as the performance says
  int frames = 0, size = 0;      // 0 = as the path needs; as the avatar was made
  std::vector<std::string> expressions;
  std::vector<double> pose_deg;  // yaw, pitch, roll
  RenderQuality quality = RenderQuality::final;
  RenderPlace place;
  bool alpha = false, mark = false, list_actions = false;
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

Result<Film> make_film(const RenderArguments& arguments, const OpenedAvatar& opened) {
  const auto& [project, avatar, model, hash] = opened;
  std::vector<ActionSweep> sweeps;
  for (const std::string& text : arguments.expressions) {
    auto sweep = parse_action(text);
    if (!sweep) return sweep.error();
    sweeps.push_back(std::move(*sweep));
  }
  const bool sweeping =
      std::any_of(sweeps.begin(), sweeps.end(), [](const ActionSweep& s) { return s.from != s.to; });
  const bool still = arguments.out.extension() == ".png" || arguments.out.extension() == ".ply" ||
                     (arguments.camera.rests() && !sweeping);
  const int wanted = arguments.frames > 0 ? arguments.frames : still ? 1 : 100;

  if (arguments.camera.follows_a_file() && arguments.frames > 0)
    return Error{ErrorCode::bad_input, "The cameras to follow say how many frames there are.",
                 "Leave out --frames, or --camera.", arguments.camera.camera};
  auto cameras = film_cameras(arguments.camera, opened, steady_times(wanted, arguments.frames_per_second));
  if (!cameras) return cameras.error();
  std::vector<AvatarPose> poses;
  const std::array<double, 3> turn = turn_of(arguments.pose_deg);
  const Vec3d pivot = shape_head(model, avatar.person).joints[kNeck].cast<double>();
  const Pose head = turned_head(avatar.world_from_head, pivot, turn[0], turn[1], turn[2]);
  for (std::size_t i = 0; i < cameras->size(); ++i) {
    const float t = cameras->size() > 1 ? float(i) / float(cameras->size() - 1) : 1;
    std::vector<std::pair<std::string, float>> actions;
    std::vector<float> attributes(avatar.attributes.size(), 0.f);
    for (const ActionSweep& s : sweeps) {
      const float amount = s.from + t * (s.to - s.from);
      if (const int a = attribute_index(avatar.attributes, s.name); a >= 0)
        attributes[std::size_t(a)] = amount;
      else
        actions.emplace_back(s.name, amount);
    }
    auto articulation = articulate(model, avatar.neutral, actions);
    if (!articulation) return articulation.error();
    poses.push_back({.world_from_head = head,
                     .world_from_torso = avatar.world_from_torso,
                     .articulation = std::move(*articulation),
                     .attributes = std::move(attributes)});
  }
  return listed_film(std::move(*cameras), std::move(poses));
}

FilmOptions film_options(const RenderArguments& arguments) {
  FilmOptions options;
  options.out = arguments.out;
  options.background = arguments.background;
  options.camera_rests = arguments.camera.rests();
  options.alpha = arguments.alpha;
  options.mark = arguments.mark;
  options.quality = arguments.quality;
  options.width = arguments.size;
  options.place = arguments.place;
  if (arguments.frames_per_second > 0) options.frames_per_second = arguments.frames_per_second;
  return options;
}

struct RenderOutcome {
  int frames = 0;
  std::optional<HoldingRange> holds;  // of the avatar
  BeyondHolds beyond;
};

RenderOutcome outcome_of(const OpenedAvatar& opened, const Film& film, int frames) {
  const auto& [project, avatar, model, hash] = opened;
  if (!avatar.holds) return {frames, {}, {}};
  return {frames, avatar.holds, beyond_holds(*avatar.holds, avatar, model, film)};
}

// A directed performance, its camera included.
Result<RenderOutcome> render_performance(const RenderArguments& arguments, const OpenedAvatar& opened,
                                         const Progress& progress, std::stop_token stop) {
  if (!arguments.expressions.empty() || !arguments.pose_deg.empty() || !arguments.camera.rests() ||
      arguments.frames > 0) {
    return Error{ErrorCode::bad_input,
                 "The performance says what face, head and camera do, and for how long.",
                 "Leave out --expression, --pose, --camera and --frames, or --performance.", ""};
  }
  auto performance = read_performance(arguments.performance);
  if (!performance) return performance.error();
  if (arguments.frames_per_second > 0) performance->frames_per_second = arguments.frames_per_second;
  const auto frames = write_performed(opened, *performance, film_options(arguments), progress, stop);
  if (!frames) return frames.error();
  const auto film = direct_film(opened, *performance);
  if (!film) return film.error();
  return outcome_of(opened, *film, *frames);
}

Result<RenderOutcome> render_film(const RenderArguments& arguments, const Progress& progress,
                                  std::stop_token stop) {
  if (const auto fine = check_camera(arguments.camera, arguments.out); !fine) return fine.error();
  const auto opened = open_avatar(arguments.project);
  if (!opened) return opened.error();
  if (!arguments.performance.empty()) return render_performance(arguments, *opened, progress, stop);
  const auto film = make_film(arguments, *opened);
  if (!film) return film.error();
  const auto frames = write_posed(*opened, *film, film_options(arguments), progress, stop);
  if (!frames) return frames.error();
  return outcome_of(*opened, *film, *frames);
}

// Lists the sliders, and how much of each the capture showed.
int list_actions(const RenderArguments& arguments) {
  const auto opened = open_avatar(arguments.project);
  if (!opened) return report_failure(opened.error());
  // On top of the person's rest, as --expression takes them; the histogram is of the amounts themselves.
  const std::vector<SeenAction> seen = seen_from_rest(opened->avatar, opened->model);
  const auto from_rest = [&](const ActionRange& range) {
    const auto own = std::ranges::find(seen, range.name, &SeenAction::name);
    return own == seen.end() ? SeenAction{range.name, range.low, range.high} : *own;
  };
  nlohmann::json list = nlohmann::json::array();
  for (const ActionRange& range : opened->avatar.seen) {
    const SeenAction own = from_rest(range);
    list.push_back({{"name", own.name},
                    {"low", own.low},
                    {"high", own.high},
                    {"coverage", range.coverage},
                    {"histogram", range.histogram}});
  }
  nlohmann::json attributes = nlohmann::json::array();
  for (const AttributeRegion& region : opened->avatar.attributes)
    attributes.push_back(
        {{"name", region.name}, {"low", region.low}, {"high", region.high}, {"coverage", region.coverage}});
  if (arguments.common.json) {
    nlohmann::json all = {{"head_model", opened->avatar.head_model_name}, {"actions", list}};
    if (!attributes.empty()) all["attributes"] = attributes;
    print_json(all);
    return kExitDone;
  }
  fmt::print("{:<20} {:>15} {:>9}\n", "action", "seen", "coverage");
  for (const ActionRange& range : opened->avatar.seen) {
    const SeenAction own = from_rest(range);
    fmt::print("{:<20} {:>6.2f} to {:>5.2f} {:>7.0f} %\n", own.name, own.low, own.high, 100 * range.coverage);
  }
  for (const AttributeRegion& region : opened->avatar.attributes)
    fmt::print("{:<20} {:>6.2f} to {:>5.2f} {:>7.0f} %  (attribute)\n", region.name, region.low, region.high,
               100 * region.coverage);
  return kExitDone;
}

int run(RenderArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  if (arguments.list_actions) return list_actions(arguments);
  auto place = chosen_place(arguments.common);
  if (!place) return report_failure(place.error());
  arguments.place = std::move(*place);
  std::optional<Result<RenderOutcome>> done;
  {
    const ProgressLine line(arguments.common);
    done = render_film(arguments, line.progress().stage(0, 1, "render"), stop_on_signals());
  }
  if (!*done) return report_failure(done->error());
  const auto& [frames, holds, beyond] = **done;
  if (arguments.common.json) {
    print_json({{"out", arguments.out.string()},
                {"frames", frames},
                {"beyond_holds", beyond_holds_json(holds, beyond)}});
    return kExitDone;
  }
  tell("Wrote {} ({} frames).\n", arguments.out.string(), frames);
  warn_beyond_holds(holds, beyond);
  return kExitDone;
}

}  // namespace

void add_render_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<RenderArguments>();
  CLI::App* verb = program.add_subcommand("render", "Pictures of the avatar: orbit, poses, expressions");
  verb->add_option("project", a->project, "Project folder")->required();
  verb->add_option("--out", a->out,
                   "FILE.mp4, FILE.png, a folder for a PNG sequence, or the head's mesh: FILE.glb, FILE.ply");
  add_camera_options(*verb, a->camera);
  verb->add_option("--frames", a->frames, "Number of frames")->check(CLI::Range(1, 100000));
  verb->add_option("--fps", a->frames_per_second, "Frames per second; default: 25, or the performance's")
      ->check(CLI::Range(1.0, 240.0));
  verb->add_option("--size", a->size, "Width of the pictures, px; default: as the avatar was made")
      ->check(CLI::Range(16, 8192));
  verb->add_option("--expression", a->expressions,
                   "NAME=VALUE, or NAME=FROM..TO for a sweep, of an action or a painted attribute; may be "
                   "repeated");
  add_pose_option(*verb, a->pose_deg, "Head turn yaw,pitch,roll in degrees");
  verb->add_option("--background", a->background,
                   "plate, room (learnt from a moving camera), a colour such as #e8e8e8, or a picture");
  add_removed_option(*verb, "--drive", "drive PROJECT CLIP --out FILE, with --camera and the rest");
  verb->add_option("--performance", a->performance,
                   "A performance.json: keys of face, head and camera over time");
  add_quality_option(*verb, a->quality);
  verb->add_flag("--alpha", a->alpha, "Transparent background (PNG only)");
  verb->add_flag("--mark", a->mark, "A visible line in each picture saying that it is synthetic");
  verb->add_flag("--list-actions", a->list_actions, "Only list the named actions and what was seen of them");
  add_common_options_with_cuda(*verb, a->common);
  verb->callback([a, &exit_code] {
    if (a->out.empty() && !a->list_actions) throw CLI::RequiredError("--out");
    exit_code = run(*a);
  });
}

}  // namespace likeness::app
