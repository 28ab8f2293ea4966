// Choosing what is written, and the function that writes it: see write_out.h.
#include "core/export/write_out.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>

#include "core/direct/direct_avatar.h"
#include "core/export/head_mesh.h"
#include "core/head/pose_head.h"
#include "core/project/care.h"
#include "core/render/camera_path.h"
#include "core/render/render.h"
#include "core/video/decode.h"

namespace likeness {

namespace {

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
  // frame: not before the one requested last.
  Result<Image8> at(int frame) {
    while (index_ < frame) {
      auto next = reader_.next();
      if (!next) return next.error();
      if (!next->has_value()) break;  // the track has frames that the clip does not: the last picture stays
      index_ = (*next)->index;
      if (index_ == frame) picture_ = resize((*next)->rgb, width_, height_);
    }
    return picture_.empty() ? Image8(width_, height_, 3) : picture_;
  }

  VideoReader reader_;
  Image8 picture_;
  int width_ = 0, height_ = 0, index_ = -1;
};

bool is_keys_name(const std::filesystem::path& path) { return path.extension() == ".json"; }

Result<void> check_keys(const FilmOptions& options, bool side_by_side, const DrivenView& view) {
  if (view.cameras)
    return Error{ErrorCode::bad_input, "The keys of a driven clip hold no camera.",
                 "Leave out --camera, or name a film as --out.", options.out.string()};
  if (!side_by_side && !options.alpha && !options.mark && options.background.empty() && options.width == 0)
    return {};
  return Error{ErrorCode::bad_input, "Keys hold no pictures.",
               "Leave out --side-by-side, --alpha, --mark, --size and --background, or name a film as --out.",
               options.out.string()};
}

// A film's cameras: those of the view, or the typical one throughout.
Result<std::vector<Camera>> view_cameras(const DrivenView& view, const Avatar& avatar,
                                         std::span<const double> times_s) {
  if (!view.cameras) return std::vector<Camera>(times_s.size(), typical_camera(avatar));
  auto cameras = view.cameras(times_s);
  if (!cameras) return cameras.error();
  cameras->resize(std::min(cameras->size(), times_s.size()));
  return cameras;
}

void hold_head(const OpenedAvatar& opened, const std::array<double, 3>& turn, DrivenClip& clip) {
  const Avatar& avatar = opened.avatar;
  const Vec3d pivot = shape_head(opened.model, avatar.person).joints[kNeck].cast<double>();
  const Pose head = turned_head(avatar.world_from_head, pivot, turn[0], turn[1], turn[2]);
  for (DrivenFrame& frame : clip.frames) frame.pose.world_from_head = head;
}

Result<int> write_keys(const OpenedAvatar& opened, const DrivenClip& clip, const FilmOptions& options) {
  const Performance keys = performance_of(clip, direct_avatar(opened.avatar, opened.model));
  if (const auto written = write_performance(options.out, keys); !written) return written.error();
  return int(clip.frames.size());
}

}  // namespace

Result<void> check_not_taken(const OpenedAvatar& opened, const FilmOptions& options) {
  if (auto free = check_free(opened.project, options.out, "--out"); !free) return free;
  const std::filesystem::path background = options.background;  // or a colour, or a keyword
  std::error_code ignored;
  if (background.empty() || (background.lexically_normal() != options.out.lexically_normal() &&
                             !std::filesystem::equivalent(background, options.out, ignored)))
    return {};
  return Error{ErrorCode::bad_input, "--out names the picture that is the background.",
               "Give --out a name of its own.", options.out.string()};
}

Result<void> check_output(const Avatar& avatar, const Intrinsics& picture, std::size_t frames,
                          const FilmOptions& options) {
  if (!is_mesh_name(options.out)) return check_film(avatar, picture, frames, options);
  if (options.alpha || options.mark || options.width > 0 || options.beside_width > 0 ||
      !options.background.empty()) {
    return Error{
        ErrorCode::bad_input, "A mesh has no background, no mark and no size.",
        "Leave out --background, --alpha, --mark, --size and --side-by-side, or name pictures as --out.",
        options.out.string()};
  }
  return check_head(options.out, frames);
}

Result<int> write_posed(const OpenedAvatar& opened, const Film& film, const FilmOptions& options,
                        const Progress& progress, std::stop_token stop) {
  if (const auto free = check_not_taken(opened, options); !free) return free.error();
  if (!is_mesh_name(options.out)) return write_film(opened, film, options, progress, stop);
  const Intrinsics picture = film.at(0).camera.intrinsics;
  if (const auto fine = check_output(opened.avatar, picture, film.frames, options); !fine)
    return fine.error();
  std::vector<double> times_s;
  for (std::size_t i = 0; i < film.frames; ++i) times_s.push_back(frame_time_s(options, i));
  return write_head(opened, film, times_s, options.out, provenance_of(opened, options.made_at), progress,
                    stop);
}

Result<int> write_performed(const OpenedAvatar& opened, const Performance& performance, FilmOptions options,
                            const Progress& progress, std::stop_token stop) {
  options.frames_per_second = performance.frames_per_second;
  options.camera_rests = std::ranges::none_of(
      performance.channels, [](const auto& channel) { return channel.first.starts_with("camera "); });
  const Intrinsics picture = typical_camera(opened.avatar).intrinsics;
  if (const auto fine = check_output(opened.avatar, picture, std::size_t(frame_count(performance)), options);
      !fine)
    return fine.error();
  const auto film = direct_film(opened, performance);
  if (!film) return film.error();
  return write_posed(opened, *film, options, progress, stop);
}

Result<DrivenOutput> write_driven(const OpenedAvatar& opened, const DriveRequest& request,
                                  FilmOptions options, bool side_by_side, const Progress& progress,
                                  std::stop_token stop, const DrivenView& view) {
  const auto info = probe_video(request.video);
  if (!info) return info.error();
  // Errors about the picture are reported before the clip is tracked.
  if (const auto apart = check_out(request, options.out); !apart) return apart.error();
  if (const auto free = check_not_taken(opened, options); !free) return free.error();
  const bool to_keys = is_keys_name(options.out);
  if (side_by_side) options.beside_width = 1;  // not known yet, but not 0
  if (to_keys) {
    if (const auto fine = check_keys(options, side_by_side, view); !fine) return fine.error();
  } else {
    // How many frames there are is only what the clip claims: beyond what a mesh holds it says nothing.
    const int expected = std::clamp(info->frame_count, 2, int(kMaxMeshFrames) + 1);
    const auto ahead = view_cameras(view, opened.avatar, steady_times(expected, info->frames_per_second));
    if (!ahead) return ahead.error();
    if (const auto fine = check_output(opened.avatar, ahead->front().intrinsics, ahead->size(), options);
        !fine)
      return fine.error();
  }
  DriveRequest asked = request;
  if (view.turn) asked.options.move_head = false;
  auto clip = drive_clip(opened, asked, progress.stage(0, to_keys ? 1 : 0.5, "driver"), stop);
  if (!clip) return clip.error();
  if (view.turn) hold_head(opened, *view.turn, *clip);
  DrivenOutput output;
  output.frames_per_second = clip->frames_per_second;
  output.gains = clip->gains;
  output.warnings = clip->warnings;
  for (const DrivenFrame& frame : clip->frames) output.bridged += frame.bridged;
  if (to_keys) {
    const auto written = write_keys(opened, *clip, options);
    if (!written) return written.error();
    output.frames = *written;
    output.sound.why_not = "a performance holds no sound";
    return output;
  }
  auto cameras = view_cameras(view, opened.avatar, times_of(clip->frames));
  if (!cameras) return cameras.error();
  const Film film = listed_film(std::move(*cameras), film_poses(*clip));
  if (const auto& holds = opened.avatar.holds)
    output.beyond = beyond_holds(*holds, opened.avatar, opened.model, film);
  options.frames_per_second = clip->frames_per_second;
  if (!is_steady(*clip)) options.times_s = times_of(clip->frames);
  if (side_by_side) {
    const Intrinsics k = film.at(0).camera.intrinsics;
    const int height =
        options.width > 0 ? int(std::lround(double(k.height) * options.width / k.width)) : k.height;
    const auto pictures = DriverPictures::open(request, *clip, height, options);
    if (!pictures) return pictures.error();
  }
  const auto frames = write_posed(opened, film, options, progress.stage(0.5, 1, "render"), stop);
  if (!frames) return frames.error();
  output.frames = *frames;
  output.sound.why_not = is_mesh_name(options.out) ? "a mesh holds no sound" : "pictures hold no sound";
  if (options.out.extension() == ".mp4") {
    auto sound = copy_sound(request.video, options.out, clip->frames.front().time_s);
    if (!sound) return sound.error();
    output.sound = std::move(*sound);
  }
  return output;
}

}  // namespace likeness
