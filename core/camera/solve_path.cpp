// Structure from motion of a clip: see solve_path.h.
#include "core/camera/solve_path.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <set>
#include <vector>

#include "core/base/hash.h"
#include "core/camera/colmap.h"
#include "core/camera/judge_solve.h"
#include "core/camera/kept_path.h"
#include "core/camera/resect.h"
#include "core/camera/workplace.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

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
Result<void> write_keyframes(const fs::path& video, const PixelRect& film, const PersonMask& person,
                             const fs::path& work, int width, const std::vector<int>& keyframes,
                             const Progress& progress, std::stop_token stop) {
  auto reader = VideoReader::open(video, VideoPixels::rgb, VideoFrames::sampled);
  if (!reader) return reader.error();
  reader->show_part(film);
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
    auto written = write_keyframes(video, options.film, person, work, width, keyframes,
                                   progress.stage(0, 0.15, "keyframes"), stop);
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

Result<AlignResult> moving_result(const fs::path& video, const VideoInfo& info, const ColmapModel& model,
                                  std::size_t chosen, const BackgroundMotion& motion,
                                  const AlignOptions& options, const Progress& progress,
                                  std::stop_token stop) {
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
  const auto between =
      resect_frames(video, options.film, keyframes, small, frames_between(motion, solved),
                    options.kept.empty() ? fs::path() : kept_greys(options.kept), progress, stop);
  if (!between) return between.error();
  for (const auto& camera : *between) poses[camera.frame] = camera.cam_from_world;
  share_rest_poses(motion, poses);

  AlignResult result;
  result.cameras.kind = CameraKind::walking;
  result.cameras.scale = CameraScale::arbitrary;
  result.cameras.reprojection_px = mean_reprojection_px(model) * motion.width / small.width;
  const Intrinsics full =
      in_whole_picture(enlarge(small, motion.width, motion.height), options.film, info.width, info.height);
  for (const auto& [frame, pose] : poses) result.cameras.cameras.push_back({frame, full, pose});
  result.frames = int(motion.frames.size());
  result.registered = int(poses.size());
  if (double(keyframes.size()) < kEnoughPlaced * double(chosen))
    result.warnings.push_back(fmt::format(
        "Only {} of {} keyframes fitted together. For a better path, film again: move slowly in one arc, "
        "keep a detailed background with things at several distances in view, and avoid blur.",
        keyframes.size(), chosen));
  if (result.registered < result.frames)
    result.warnings.push_back(fmt::format("The camera of {} of {} frames was not found; they are left out.",
                                          result.frames - result.registered, result.frames));
  return result;
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

Result<AlignResult> solve_path(const fs::path& video, const PersonMask& person, const fs::path& work,
                               const AlignOptions& options, const BackgroundMotion& motion,
                               const VideoInfo& info, const std::optional<SolveLimits>& limits,
                               const Progress& progress, std::stop_token stop) {
  const auto keyframes = choose_keyframes(motion, options.keyframes);
  const auto model = solve_keyframes(video, person, work, options, motion, keyframes,
                                     progress.stage(0, 0.65, "camera path"), stop);
  if (!model) return model.error();
  if (limits) {
    const SolveJudgement judgement = judge_solve(*model, int(keyframes.size()), info.focal_35mm, *limits);
    if (!judgement.usable())
      return Error{ErrorCode::failed,
                   fmt::format("The path that was found for the camera is not believed: {}",
                               fmt::join(judgement.reasons, " ")),
                   "If the camera did walk round the head, say so: --camera-kind walking", "camera"};
  }
  auto result = moving_result(video, info, *model, keyframes.size(), motion, options,
                              progress.stage(0.65, 1, "frames between"), stop);
  if (result) result->evidence = moving_evidence(motion);
  return result;
}

}  // namespace likeness
