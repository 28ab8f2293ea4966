// likeness drive: an avatar that does what the driver does in a clip.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "app/backend_option.h"
#include "app/camera_option.h"
#include "app/commands.h"
#include "app/holds_json.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/export/write_out.h"
#include "core/face/landmarks.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct DriveArguments {
  CommonOptions common;
  fs::path project;
  DriveRequest request;
  std::vector<std::string> gains, attributes;
  FilmOptions film;
  CameraOptions camera;
  std::vector<double> pose_deg;  // yaw, pitch, roll; empty: the head moves
  bool unclamped = false, keep_head = false, side_by_side = false;
};

Result<void> parse_gains(const std::vector<std::string>& texts, DriveOptions& options) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    float gain = 0;
    const char* end = text.data() + text.size();
    if (equals != std::string::npos && equals > 0) {
      const auto [rest, failure] = std::from_chars(text.data() + equals + 1, end, gain);
      if (failure == std::errc{} && rest == end && std::isfinite(gain) && std::abs(gain) <= 10) {
        options.gains[text.substr(0, equals)] = gain;
        continue;
      }
    }
    return Error{ErrorCode::bad_input, fmt::format("\"{}\" is not a gain.", text),
                 "Write NAME=GAIN with a gain from -10 to 10, e.g. --gain mouthSmile_L=1.3", ""};
  }
  return {};
}

Result<void> parse_attributes(const std::vector<std::string>& texts, DriveRequest& request) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    float amount = 0;
    const char* end = text.data() + text.size();
    if (equals != std::string::npos && equals > 0) {
      const auto [rest, failure] = std::from_chars(text.data() + equals + 1, end, amount);
      if (failure == std::errc{} && rest == end && std::isfinite(amount)) {
        request.attributes.emplace_back(text.substr(0, equals), amount);
        continue;
      }
    }
    return Error{ErrorCode::bad_input, fmt::format("\"{}\" is not an attribute's amount.", text),
                 "Write NAME=AMOUNT, e.g. --attribute \"cheek puff=0.8\"", ""};
  }
  return {};
}

struct DriveOutcome {
  DrivenOutput output;
  std::optional<HoldingRange> holds;  // of the avatar
};

Result<DriveOutcome> drive_film(DriveArguments& a, const Progress& progress, std::stop_token stop) {
  const auto opened = open_avatar(a.project);
  if (!opened) return opened.error();
  if (const auto parsed = parse_gains(a.gains, a.request.options); !parsed) return parsed.error();
  if (const auto parsed = parse_attributes(a.attributes, a.request); !parsed) return parsed.error();
  a.request.options.clamp = !a.unclamped;
  a.request.options.move_head = !a.keep_head;
  a.film.camera_rests = a.camera.rests();
  if (const auto fine = check_camera(a.camera, a.film.out); !fine) return fine.error();
  DrivenView view;
  if (!a.camera.rests())
    view.cameras = [&](std::span<const double> times_s) { return film_cameras(a.camera, *opened, times_s); };
  if (!a.pose_deg.empty()) view.turn = turn_of(a.pose_deg);
  auto output = write_driven(*opened, a.request, a.film, a.side_by_side, progress, stop, view);
  if (!output) return output.error();
  return DriveOutcome{std::move(*output), opened->avatar.holds};
}

int run(DriveArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto place = chosen_place(a.common);
  if (!place) return report_failure(place.error());
  a.film.place = *place;
  std::optional<Result<DriveOutcome>> outcome;
  {
    const ProgressLine line(a.common);
    outcome = drive_film(a, line.progress(), stop_on_signals());
  }
  if (!*outcome) return report_failure(outcome->error());
  const auto& [done, holds] = **outcome;
  if (a.common.json) {
    nlohmann::json gains = nlohmann::json::object();
    for (const auto& [name, gain] : done.gains) gains[name] = gain;
    print_json({{"out", a.film.out.string()},
                {"frames", done.frames},
                {"bridged", done.bridged},
                {"frames_per_second", done.frames_per_second},
                {"sound", done.sound.copied},
                {"sound_left_out", done.sound.why_not},
                {"gains", gains},
                {"warnings", done.warnings},
                {"beyond_holds", beyond_holds_json(holds, done.beyond)}});
    return kExitDone;
  }
  tell("Wrote {} ({} frames, {}).\n", a.film.out.string(), done.frames,
       done.sound.copied ? "with the clip's sound" : "without sound: " + done.sound.why_not);
  for (const std::string& warning : done.warnings) tell("{}\n", warning);
  if (done.bridged > 0)
    tell("In {} frames the driver's face was lost; the motion is interpolated there.\n", done.bridged);
  warn_beyond_holds(holds, done.beyond);
  return kExitDone;
}

}  // namespace

void add_drive_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<DriveArguments>();
  CLI::App* verb = program.add_subcommand("drive", "The avatar does what the driver does in a clip");
  verb->add_option("project", a->project, "Project folder of the avatar")->required();
  verb->add_option("video", a->request.video, "The driving clip")->required();
  verb->add_option(
          "--out", a->film.out,
          "FILE.mp4, a folder for a PNG sequence, FILE.glb, or FILE.json: the performance as keys to edit")
      ->required();
  verb->add_option("--gain", a->gains, "NAME=GAIN: more or less of an action; may be repeated");
  verb->add_option("--attribute", a->attributes,
                   "NAME=AMOUNT: a painted attribute held at this throughout; may be repeated");
  add_quality_option(*verb, a->film.quality);
  verb->add_flag("--unclamped", a->unclamped, "Go beyond what the avatar's capture showed");
  CLI::Option* keep =
      verb->add_flag("--keep-head", a->keep_head, "Only the face moves, the head keeps its typical pose");
  add_pose_option(*verb, a->pose_deg, "The same with the head turned by yaw,pitch,roll degrees");
  verb->get_option("--pose")->excludes(keep);
  add_camera_options(*verb, a->camera);
  verb->add_flag("--smooth", a->request.options.smooth, "Steadier, with a little lag (one-euro filter)");
  verb->add_option("--track", a->request.track, "track.json of the clip: read if it exists, else written");
  verb->add_option("--head-model", a->request.head_model,
                   "Head model to track the driver with (.npz); default: the avatar's");
  verb->add_option("--landmark-model", a->request.landmark_model, kLandmarkModelHelp);
  verb->add_option("--size", a->film.width, "Width of the pictures, px; default: as the avatar was made")
      ->check(CLI::Range(16, 8192));
  verb->add_flag("--side-by-side", a->side_by_side, "The driver on the left, the avatar on the right");
  verb->add_option("--background", a->film.background,
                   "plate, room (learnt from a moving camera), a colour such as #e8e8e8, or a picture");
  verb->add_flag("--mark", a->film.mark, "A visible line in each picture saying that it is synthetic");
  verb->add_flag("--alpha", a->film.alpha, "Transparent background (PNG only)");
  add_common_options_with_cuda(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
