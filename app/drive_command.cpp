// likeness drive: an avatar that does what somebody does in a clip.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/direct/direct_avatar.h"
#include "core/film/driving.h"
#include "core/film/film.h"
#include "core/render/render.h"
#include "core/video/copy_sound.h"
#include "core/video/decode.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct DriveArguments {
  CommonOptions common;
  fs::path project;
  DriveRequest request;
  std::vector<std::string> gains;
  FilmOptions film;
  bool unclamped = false, keep_head = false, side_by_side = false;
};

struct DriveOutcome {
  DrivenClip clip;
  int frames = 0, bridged = 0;
  CopiedSound sound = {};
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

// The driver's pictures one after the other, for the left of each frame.
class DriverPictures {
 public:
  static Result<std::shared_ptr<DriverPictures>> open(const DriveRequest& request, const DrivenClip& clip,
                                                      int height, FilmOptions& film) {
    auto reader = VideoReader::open(request.video);
    if (!reader) return reader.error();
    auto pictures = std::shared_ptr<DriverPictures>(new DriverPictures(std::move(*reader)));
    const VideoInfo& info = pictures->reader_.info();
    pictures->height_ = height;
    pictures->width_ = std::max(2, int(std::lround(double(info.width) * height / info.height)) / 2 * 2);
    film.beside_width = pictures->width_;
    film.beside = [pictures, &clip](std::size_t i) { return pictures->at(clip.frames[i].frame); };
    return pictures;
  }

 private:
  explicit DriverPictures(VideoReader reader) : reader_(std::move(reader)) {}
  // frame: not before the one asked for last.
  Result<Image8> at(int frame) {
    while (index_ < frame) {
      auto next = reader_.next();
      if (!next) return next.error();
      if (!next->has_value()) break;  // the track has frames that the clip has not: the last one stays
      index_ = (*next)->index;
      if (index_ == frame) picture_ = resize((*next)->rgb, width_, height_);
    }
    return picture_.empty() ? Image8(width_, height_, 3) : picture_;
  }

  VideoReader reader_;
  Image8 picture_;
  int width_ = 0, height_ = 0, index_ = -1;
};

Result<DriveOutcome> drive_film(DriveArguments& a, const Progress& progress, std::stop_token stop) {
  const auto opened = open_avatar(a.project);
  if (!opened) return opened.error();
  if (const auto parsed = parse_gains(a.gains, a.request.options); !parsed) return parsed.error();
  a.request.options.clamp = !a.unclamped;
  a.request.options.move_head = !a.keep_head;
  const Camera camera = typical_camera(opened->avatar);
  const auto info = probe_video(a.request.video);
  if (!info) return info.error();
  // What is wrong with the picture is said before the clip is tracked.
  if (const auto apart = check_out(a.request, a.film.out); !apart) return apart.error();
  const bool to_keys = a.film.out.extension() == ".json";
  const std::size_t expected = std::size_t(std::max(2, info->frame_count));
  if (a.side_by_side) a.film.beside_width = 1;  // not known yet, but not none
  if (to_keys && (a.side_by_side || a.film.alpha || a.film.mark || !a.film.background.empty()))
    return Error{ErrorCode::bad_input, "Keys hold no pictures.",
                 "Leave out --side-by-side, --alpha, --mark and --background, or name a film as --out.", ""};
  if (!to_keys)
    if (const auto fine = check_film(opened->avatar, camera.intrinsics, expected, a.film); !fine)
      return fine.error();
  auto clip = drive_clip(*opened, a.request, progress.stage(0, to_keys ? 1 : 0.5, "driver"), stop);
  if (!clip) return clip.error();
  DriveOutcome outcome{std::move(*clip)};
  for (const DrivenFrame& frame : outcome.clip.frames) outcome.bridged += frame.bridged;
  if (to_keys) {
    const auto keys = performance_of(outcome.clip, direct_avatar(opened->avatar, opened->model));
    if (const auto written = write_performance(a.film.out, keys); !written) return written.error();
    outcome.frames = int(outcome.clip.frames.size());
    outcome.sound.why_not = "a performance holds no sound";
    return outcome;
  }
  const Film film{std::vector<Camera>(outcome.clip.frames.size(), camera), film_poses(outcome.clip)};
  a.film.frames_per_second = outcome.clip.frames_per_second;
  if (a.side_by_side) {
    const auto pictures = DriverPictures::open(a.request, outcome.clip, camera.intrinsics.height, a.film);
    if (!pictures) return pictures.error();
  }
  const auto frames = write_film(*opened, film, a.film, progress.stage(0.5, 1, "render"), stop);
  if (!frames) return frames.error();
  outcome.frames = *frames;
  outcome.sound.why_not = "pictures hold no sound";
  if (a.film.out.extension() == ".mp4") {
    const auto sound = copy_sound(a.request.video, a.film.out);
    if (!sound) return sound.error();
    outcome.sound = *sound;
  }
  return outcome;
}

int run(DriveArguments& a) {
  const ThreadLimit limit(a.common.threads);
  std::optional<Result<DriveOutcome>> outcome;
  {
    const ProgressLine line(a.common);
    outcome = drive_film(a, line.progress(), stop_on_signals());
  }
  if (!*outcome) return report_failure(outcome->error());
  const DriveOutcome& done = **outcome;
  if (a.common.json) {
    nlohmann::json gains = nlohmann::json::object();
    for (const auto& [name, gain] : done.clip.gains) gains[name] = gain;
    print_json({{"out", a.film.out.string()},
                {"frames", done.frames},
                {"bridged", done.bridged},
                {"frames_per_second", done.clip.frames_per_second},
                {"sound", done.sound.copied},
                {"sound_left_out", done.sound.why_not},
                {"gains", gains}});
    return kExitDone;
  }
  fmt::print(stderr, "Wrote {} ({} frames, {}).\n", a.film.out.string(), done.frames,
             done.sound.copied ? "with the clip's sound" : "without sound: " + done.sound.why_not);
  if (done.bridged > 0)
    fmt::print(stderr,
               "In {} frames the driver's face was lost; the avatar moves on between its neighbours.\n",
               done.bridged);
  return kExitDone;
}

}  // namespace

void add_drive_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<DriveArguments>();
  CLI::App* verb = program.add_subcommand("drive", "The avatar does what somebody does in a clip");
  verb->add_option("project", a->project, "Project folder of the avatar")->required();
  verb->add_option("video", a->request.video, "The driving clip")->required();
  verb->add_option("--out", a->film.out,
                   "FILE.mp4, a folder for a PNG sequence, or FILE.json: the performance as keys to edit")
      ->required();
  verb->add_option("--gain", a->gains, "NAME=GAIN: more or less of an action; may be repeated");
  add_quality_option(*verb, a->film.quality);
  verb->add_flag("--unclamped", a->unclamped, "Also what the avatar's capture never showed");
  verb->add_flag("--keep-head", a->keep_head, "Only the face moves, the head stays");
  verb->add_flag("--smooth", a->request.options.smooth, "Steadier, with a little lag (one-euro filter)");
  verb->add_option("--track", a->request.track, "track.json of the clip: read if it exists, else written");
  verb->add_option("--head-model", a->request.head_model,
                   "Head model to track the driver with (.npz); default: the avatar's");
  verb->add_option("--landmark-model", a->request.landmark_model,
                   "A dlib 68-point shape predictor; default: the system's");
  verb->add_flag("--side-by-side", a->side_by_side, "The driver on the left, the avatar on the right");
  verb->add_option("--background", a->film.background, "plate, or a colour such as #e8e8e8");
  verb->add_flag("--mark", a->film.mark, "A visible line in each picture that says it is synthetic");
  verb->add_flag("--alpha", a->film.alpha, "Transparent background (PNG only)");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
