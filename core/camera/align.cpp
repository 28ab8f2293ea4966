// Static or moving, then, for a moving camera: keyframes, structure from motion, the frames between, the
// rests.
#include "core/camera/align.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/base/hash.h"
#include "core/camera/assumed_lens.h"
#include "core/camera/colmap.h"
#include "core/camera/kept_path.h"
#include "core/camera/motion.h"
#include "core/camera/resect.h"
#include "core/camera/workplace.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// Background motion, in 1/1000 of the width, below which a failed solve may be taken as a camera at rest.
constexpr double kHardlyMoving = 20;

AlignResult static_result(const VideoInfo& info, const AlignOptions& options, std::size_t frames,
                          std::string evidence) {
  const Intrinsics usual = assumed_intrinsics(info.width, info.height, 0),
                   lens = options.lens_mm > 0 ? film_intrinsics(info.width, info.height, options.lens_mm)
                                              : assumed_intrinsics(info.width, info.height, info.focal_35mm);
  AlignResult result;
  result.cameras.is_static = true;
  result.cameras.scale = CameraScale::metric;
  result.cameras.cameras.push_back({-1, lens, Pose::Identity()});
  result.evidence = std::move(evidence);
  if (options.lens_mm > 0)
    result.evidence +=
        fmt::format(" Its lens was given as {:.3g} mm (on 35 mm film): {:.0f} px.", options.lens_mm, lens.fx);
  else if (lens.fx != usual.fx)
    result.evidence += fmt::format(" The clip names its lens: {:.3g} mm (on 35 mm film), {:.0f} px.",
                                   info.focal_35mm, lens.fx);
  result.frames = result.registered = int(frames);
  return result;
}

// Intrinsics of the reduced pictures, brought to the source's size.
Intrinsics enlarge(const Intrinsics& small, int width, int height) {
  Intrinsics k = small;
  const double sx = double(width) / small.width, sy = double(height) / small.height;
  k.width = width;
  k.height = height;
  k.fx *= sx, k.cx *= sx;
  k.fy *= sy, k.cy *= sy;
  return k;
}

// Writes the keyframes' pictures and masks for colmap.
Result<void> write_keyframes(const fs::path& video, const PersonMask& person, const fs::path& work, int width,
                             const std::vector<int>& keyframes, const Progress& progress,
                             std::stop_token stop) {
  auto reader = VideoReader::open(video, VideoPixels::rgb, VideoFrames::sampled);
  if (!reader) return reader.error();
  const std::set<int> wanted(keyframes.begin(), keyframes.end());
  std::size_t written = 0;
  while (written < wanted.size()) {
    if (stop.stop_requested()) return cancelled_error();
    auto next = reader->next();
    if (!next) return next.error();
    if (!next->has_value()) break;
    const VideoFrame& frame = **next;
    if (!wanted.count(frame.index)) continue;
    const Image8 mask = person ? person(frame.index, frame.rgb) : Image8();
    if (auto done = write_picture(work, keyframe_name(frame.index), frame.rgb, mask, width); !done)
      return done;
    progress.report(double(++written) / double(wanted.size()), fmt::format("keyframe {}", frame.index));
  }
  return mark_pictures_ready(work);
}

Result<ColmapModel> solve_keyframes(const fs::path& video, const PersonMask& person, const fs::path& work,
                                    const AlignOptions& options, const BackgroundMotion& motion,
                                    const std::vector<int>& keyframes, const Progress& progress,
                                    std::stop_token stop) {
  const int width = solve_width(motion.width, options.colmap_width);
  const auto video_hash = hash_video(video);
  if (!video_hash) return video_hash.error();
  const std::string inputs =
      hash_text(keyframe_inputs(*video_hash, motion, keyframes, bool(person), options));
  if (auto ready = prepare_work_folder(work, inputs); !ready) return ready.error();
  const bool ready = pictures_ready(work) ||
                     (!options.kept.empty() && take_pictures(kept_keyframes(options.kept), inputs, work));
  if (!ready) {
    auto written =
        write_keyframes(video, person, work, width, keyframes, progress.stage(0, 0.15, "keyframes"), stop);
    if (!written) return written.error();
  }
  ColmapOptions colmap;
  colmap.program = options.colmap;
  colmap.features = options.colmap_features;
  colmap.seed = options.seed;
  return solve_colmap(work, colmap, progress.stage(0.15, 1, "structure from motion"), stop);
}

// Every frame of a rest gets the mean of the poses found in it.
void share_rest_poses(const BackgroundMotion& motion, std::map<int, Pose>& poses) {
  for (const auto& rest : motion.rests) {
    std::vector<Pose> found;
    for (auto it = poses.lower_bound(rest.first); it != poses.end() && it->first <= rest.last; ++it)
      found.push_back(it->second);
    if (found.empty()) continue;
    const Pose mean = mean_pose(found);
    for (const auto& frame : motion.frames)
      if (frame.frame >= rest.first && frame.frame <= rest.last) poses[frame.frame] = mean;
  }
}

Result<AlignResult> moving_result(const fs::path& video, const ColmapModel& model, std::size_t chosen,
                                  const BackgroundMotion& motion, const fs::path& kept,
                                  const Progress& progress, std::stop_token stop) {
  const auto keyframes = keyframes_of(model);
  if (keyframes.size() < 3)
    return Error{ErrorCode::failed, fmt::format("Only {} keyframes could be placed.", keyframes.size()),
                 "Move the camera more slowly round the head, in front of a background with detail.",
                 "camera"};
  const Intrinsics small = model.cameras.begin()->second;
  std::map<int, Pose> poses;
  std::set<int> solved;
  for (const auto& keyframe : keyframes) {
    poses[keyframe.frame] = keyframe.cam_from_world;
    solved.insert(keyframe.frame);
  }
  const auto between = resect_frames(video, keyframes, small, frames_between(motion, solved),
                                     kept.empty() ? fs::path() : kept_greys(kept), progress, stop);
  if (!between) return between.error();
  for (const auto& camera : *between) poses[camera.frame] = camera.cam_from_world;
  share_rest_poses(motion, poses);

  AlignResult result;
  result.cameras.is_static = false;
  result.cameras.scale = CameraScale::arbitrary;
  result.cameras.reprojection_px = mean_reprojection_px(model) * motion.width / small.width;
  const Intrinsics full = enlarge(small, motion.width, motion.height);
  for (const auto& [frame, pose] : poses) result.cameras.cameras.push_back({frame, full, pose});
  result.frames = int(motion.frames.size());
  result.registered = int(poses.size());
  if (double(keyframes.size()) < kEnoughPlaced * double(chosen))
    result.warnings.push_back(
        fmt::format("Only {} of {} keyframes fitted together. For a better path, film again: move slowly in "
                    "one arc, keep "
                    "a detailed background with things at several distances in view, and avoid blur.",
                    keyframes.size(), chosen));
  if (result.registered < result.frames)
    result.warnings.push_back(fmt::format("The camera of {} of {} frames was not found; they are left out.",
                                          result.frames - result.registered, result.frames));
  return result;
}

// As kept, or measured.
Result<BackgroundMotion> known_motion(const fs::path& video, const PersonMask& person,
                                      const AlignOptions& options, const Progress& progress,
                                      std::stop_token stop) {
  if (!options.kept.empty()) {
    const auto video_hash = hash_video(video);
    if (!video_hash) return video_hash.error();
    if (auto kept = kept_motion(options.kept, motion_inputs(*video_hash, options))) {
      progress.report(1);
      return std::move(*kept);
    }
  }
  return measure_background_motion(video, person, rest_limit(options), progress, stop, options.stretches);
}

std::string moving_evidence(const BackgroundMotion& motion) {
  std::string text = fmt::format(
      "The camera moves: the background shifts by {:.0f} thousandths of the picture's width along a path "
      "of {:.0f}",
      measure_sway(motion).reach, motion.motion);
  if (motion.rests.empty()) return text + " and never rests for a second.";
  text += "; it rests in frames";
  for (std::size_t i = 0; i < motion.rests.size(); ++i)
    text += fmt::format("{} {}-{}", i ? "," : "", motion.rests[i].first, motion.rests[i].last);
  return text + ".";
}

}  // namespace

Result<AlignResult> align_clip(const fs::path& video, const PersonMask& person, const fs::path& work,
                               const AlignOptions& options, const Progress& progress, std::stop_token stop) {
  const auto info = probe_video(video);
  if (!info) return info.error();
  if (options.resting) {
    progress.report(1);
    return static_result(*info, options, std::size_t(info->frame_count),
                         "The camera is at rest as stated; nothing was measured.");
  }
  const auto motion = known_motion(video, person, options, progress.stage(0, 0.2, "background"), stop);
  if (!motion) return motion.error();
  if (motion->tracks < kLeastTracks) {
    auto result =
        static_result(*info, options, motion->frames.size(),
                      fmt::format("The camera rests: the background has too little texture ({:.1f} feature "
                                  "tracks on average, {} needed) to show whether the camera moves.",
                                  motion->tracks, kLeastTracks));
    progress.report(1);
    return result;
  }
  if (motion->motion <= options.static_motion_px_per_1000) {
    auto result = static_result(
        *info, options, motion->frames.size(),
        fmt::format("The camera rests: the background moves by {:.2f} thousandths of the picture's width "
                    "over {} frames ({:.0f} feature tracks on average; limit {:.2f}).",
                    motion->motion, motion->frames.size(), motion->tracks,
                    options.static_motion_px_per_1000));
    progress.report(1);
    return result;
  }
  const auto keyframes = choose_keyframes(*motion, options.keyframes);
  const auto model = solve_keyframes(video, person, work, options, *motion, keyframes,
                                     progress.stage(0.2, 0.7, "camera path"), stop);
  if (!model) {
    const Sway sway = measure_sway(*motion);
    const bool nowhere = motion->motion <= kHardlyMoving || is_shaking(sway);
    if (model.error().code != ErrorCode::failed || !nowhere) return model.error();
    auto result = static_result(
        *info, options, motion->frames.size(),
        fmt::format("The camera rests: the background shifts by only {:.0f} thousandths of the picture's "
                    "width and returns {:.1f} times a second, so there is no path to solve.",
                    sway.reach, sway.crossings));
    result.warnings.push_back(
        "The camera moved a little and was taken to be at rest, so the background will be soft. " +
        model.error().what + " Use a tripod for a sharper result.");
    progress.report(1);
    return result;
  }
  auto result = moving_result(video, *model, keyframes.size(), *motion, options.kept,
                              progress.stage(0.7, 1, "frames between"), stop);
  if (result) {
    result->evidence = moving_evidence(*motion);
    progress.report(1);
  }
  return result;
}

}  // namespace likeness
