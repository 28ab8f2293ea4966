// The driver's track and its mapping: see drive_clip.h.
#include "core/drive/drive_clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "core/base/files.h"
#include "core/base/path_text.h"
#include "core/base/quantile.h"
#include "core/camera/clip_camera.h"
#include "core/capture/choose_crop.h"
#include "core/capture/choose_shots.h"
#include "core/capture/find_film.h"
#include "core/capture/scan_clip.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/track/clip/track_clip.h"
#include "core/track/frame_spacing.h"
#include "core/video/decode.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr int kWholePicture = 640;  // px; larger pictures are cropped to head and shoulders, as on import

// Where the driver is, and the shots of the film: no pose is carried over a cut, but all of them are tracked.
struct DriverPlace {
  TrackRegion region;
  std::vector<FrameSpan> shots = {};  // empty: one
  bool changed_shape = false;         // in the middle of the film
  std::optional<Error> fault{};       // why it ends early
};

Result<DriverPlace> find_driver(const fs::path& video, const PixelRect& film, const fs::path& landmark_model,
                                const Progress& progress, std::stop_token stop) {
  DriverPlace place{{film.x, film.y, film.width, film.height}};
  const auto detector = FaceDetector::load(landmark_model);
  if (!detector) return detector.error();
  const auto scan = scan_clip(video, *detector, {}, film, progress, stop);
  if (!scan) return scan.error();
  place.changed_shape = std::ranges::any_of(scan->film, [](const FrameSketch& f) { return f.shape > 0; });
  place.fault = scan->fault;
  std::error_code ignored;
  if (!fs::is_directory(video, ignored)) place.shots = every_shot(*scan);
  if (std::max(film.width, film.height) <= kWholePicture) return place;
  std::vector<FaceBox> faces;
  for (const FaceSample& sample : scan->samples)
    if (sample.face) faces.push_back(*sample.face);
  if (faces.empty()) {
    const std::string fault = scan->fault ? scan->fault->what + " " : "";
    return Error{ErrorCode::no_face,
                 fmt::format("{}No face was found in {}.", fault, video.filename().string()),
                 "Use a driving clip in which the face is close and well lit.", video.string()};
  }
  const SquareCrop crop = choose_crop(faces, film).crop;
  const PixelRect part = common_part({crop.x, crop.y, crop.side, crop.side}, film);
  place.region = {part.x, part.y, part.width, part.height};
  return place;
}

Result<Track> driver_track(const DriveRequest& request, const VideoInfo& info, const HeadModel& model,
                           std::vector<std::string>& warnings, const Progress& progress,
                           std::stop_token stop) {
  if (path_exists(request.track)) {
    auto track = read_track(request.track);
    if (!track) return track.error();
    if (const auto fits = check_track_fits(*track, model); !fits) {
      return Error{ErrorCode::bad_input, fits.error().what,
                   "Name the track's own head model with --head-model, or leave out --track.",
                   request.track.string()};
    }
    const auto last = std::ranges::max_element(track->frames, {}, &TrackedFrame::frame);
    // The container only declares how many frames there are, or it is a guess by its length and rate.
    if (last != track->frames.end() && info.frame_count > 0 && last->frame > info.frame_count * 1.05 + 5 &&
        last->time_s > info.duration_s * 1.05)
      return Error{ErrorCode::bad_input,
                   fmt::format("The track has a frame {}, but {} has only about {}.", last->frame,
                               request.video.filename().string(), info.frame_count),
                   "Give the track of this clip, or leave out --track.", request.track.string()};
    return track;
  }
  const auto film = find_film(request.video, progress.stage(0, 0.03, "looking for bars"), stop);
  if (!film) return film.error();
  const PixelRect filmed = film->empty() ? PixelRect{0, 0, info.width, info.height} : *film;
  const auto place = find_driver(request.video, filmed, request.landmark_model,
                                 progress.stage(0.03, 0.15, "looking for the face"), stop);
  if (!place) return place.error();
  if (place->fault) warnings.push_back(fault_words(*place->fault));
  if (place->changed_shape)
    warnings.push_back(
        "The picture changes its shape in the middle of the clip, as where a phone is turned or a call "
        "becomes narrower: the driver is tracked anew there.");
  TrackOptions options;
  options.shots = place->shots;
  options.predictor = request.landmark_model;
  options.every_frame = true;  // the result has the clip's own rate
  auto track = track_clip(request.video, place->region, assumed_camera(info, *film), {}, model, options,
                          progress.stage(0.15, 1, "tracking the driver"), stop);
  if (!track) return track.error();
  track->head_model_file = text_of_path(request.head_model);
  if (!request.track.empty()) {
    if (const auto written = write_track(request.track, *track); !written) return written.error();
  }
  return track;
}

// By the median of the steps: a pause does not slow down the rest.
double usual_rate(std::span<const DrivenFrame> frames, double otherwise) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (frames[i].time_s > frames[i - 1].time_s) steps_s.push_back(frames[i].time_s - frames[i - 1].time_s);
  return steps_s.empty() ? otherwise : std::clamp(std::round(1000 / median(steps_s)) / 1000, 1.0, 240.0);
}

// The requested amounts, in the avatar's order.
Result<std::vector<float>> held_attributes(const Avatar& avatar, const DriveRequest& request) {
  std::vector<float> amounts(avatar.attributes.size(), 0.f);
  for (const auto& [name, amount] : request.attributes) {
    const int a = attribute_index(avatar.attributes, name);
    if (a < 0) {
      std::string known;
      for (const AttributeRegion& region : avatar.attributes)
        known += (known.empty() ? "" : ", ") + region.name;
      return Error{ErrorCode::bad_input, "The avatar has no attribute '" + name + "'.",
                   known.empty() ? "It has none: paint one (likeness attribute) and train again."
                                 : "Choose from: " + known + ".",
                   ""};
    }
    amounts[std::size_t(a)] = amount;
  }
  return amounts;
}

}  // namespace

Result<DrivenClip> drive_clip(const OpenedAvatar& opened, const DriveRequest& request,
                              const Progress& progress, std::stop_token stop) {
  auto held = held_attributes(opened.avatar, request);
  if (!held) return held.error();
  const auto info = probe_video(request.video);
  if (!info) return info.error();
  HeadModel other;
  if (!request.head_model.empty()) {
    ProjectOptions models;
    models.shared.head_model = request.head_model;
    auto model = project_head_model(models);
    if (!model) return model.error();
    other = std::move(*model);
  }
  const HeadModel& model = request.head_model.empty() ? opened.model : other;
  std::vector<std::string> warnings;
  auto track = driver_track(request, *info, model, warnings, progress, stop);
  if (!track) return track.error();
  const auto driver = subject_from_track(*track, model);
  if (!driver) return driver.error();
  const DriveSubject avatar = avatar_subject(opened.avatar, opened.model);
  auto frames = drive(*track, *driver, avatar, request.options);
  if (!frames) return frames.error();
  DrivenClip clip{std::move(*track), std::move(*frames), {}, 25, std::move(*held), std::move(warnings)};
  const std::vector<float> gains = drive_gains(*driver, avatar, request.options);
  for (std::size_t a = 0; a < gains.size(); ++a)
    if (gains[a] != 1) clip.gains.emplace_back(opened.model.actions[a].name, gains[a]);
  // A project's track may have only some of the frames.
  const double rate = info->frames_per_second / std::max(1, frame_spacing(clip.track.frames));
  if (rate > 0) clip.frames_per_second = std::clamp(rate, 1.0, 240.0);
  if (!is_steady(clip)) clip.frames_per_second = usual_rate(clip.frames, clip.frames_per_second);
  return clip;
}

bool is_steady(const DrivenClip& clip) {
  constexpr double kRounding_s = 2e-3;  // Matroska counts milliseconds
  const std::vector<double> times_s = times_of(clip.frames);
  for (std::size_t i = 0; i < times_s.size(); ++i)
    if (std::abs(times_s[i] - double(i) / clip.frames_per_second) > kRounding_s) return false;
  return true;
}

std::vector<double> times_of(std::span<const DrivenFrame> frames) {
  std::vector<double> times_s;
  for (const DrivenFrame& frame : frames) times_s.push_back(frame.time_s - frames.front().time_s);
  return times_s;
}

Result<void> check_out(const DriveRequest& request, const std::filesystem::path& out) {
  for (const std::filesystem::path& used : {request.video, request.track}) {
    std::error_code ignored;
    if (used.empty() || (used.lexically_normal() != out.lexically_normal() &&
                         !std::filesystem::equivalent(used, out, ignored)))
      continue;
    return Error{ErrorCode::bad_input, "--out names a file that is also read or written otherwise.",
                 "Give --out a name of its own.", out.string()};
  }
  return {};
}

std::vector<AvatarPose> film_poses(const DrivenClip& clip) {
  std::vector<AvatarPose> poses;
  for (const DrivenFrame& frame : clip.frames) poses.emplace_back(frame.pose).attributes = clip.attributes;
  return poses;
}

}  // namespace likeness
