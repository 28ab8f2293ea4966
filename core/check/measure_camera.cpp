// See measure_camera.h.
#include "core/check/measure_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/camera/assumed_lens.h"
#include "core/camera/camera_kind.h"
#include "core/camera/grey_plate.h"
#include "core/camera/handheld.h"

namespace likeness {
namespace {

// Of a long clip, every n-th: a hand moves little in a fifth of a second, and a check should last no longer
// than the clip.
constexpr std::size_t kFrames = 300;

std::vector<HandheldFrame> frames_of(const BackgroundMotion& motion, const BackgroundPictures& pictures) {
  const std::size_t all = pictures.frames.size(), step = std::max<std::size_t>(1, all / kFrames);
  std::vector<HandheldFrame> frames;
  for (std::size_t i = 0; i < all; i += step) {
    HandheldFrame& frame = frames.emplace_back();
    frame.frame = pictures.frames[i];
    frame.grey = &pictures.grey[i], frame.person = pictures.person_at(i);
    frame.time_s = motion.frames[i].time_s;
  }
  return frames;
}

Result<HandheldSolve> solve_background(const BackgroundMotion& motion, const BackgroundPictures& pictures,
                                       const VideoInfo& info, const Progress& progress,
                                       std::stop_token stop) {
  const auto frames = frames_of(motion, pictures);
  Camera reference;
  reference.intrinsics = assumed_intrinsics(info.width, info.height, info.focal_35mm);
  return solve_handheld(frames, resized(reference, pictures.grey.front().width).intrinsics, {}, progress,
                        stop);
}

void take_verdict(const CameraVerdict& verdict, CameraMeasures& camera) {
  const CameraExplanation e = verdict.explanation;
  camera.kind = e == CameraExplanation::handheld      ? CameraKind::handheld
                : e == CameraExplanation::unexplained ? CameraKind::walking
                                                      : CameraKind::resting;
  camera.sure = e == CameraExplanation::resting || e == CameraExplanation::handheld;
  camera.evidence += (camera.evidence.empty() ? "" : " ") + verdict.reason;
}

}  // namespace

Result<CameraMeasures> measure_camera(const std::filesystem::path& video, const PersonMask& person,
                                      const PixelRect& film, const VideoInfo& info,
                                      const std::vector<FrameSpan>& stretches, const Progress& progress,
                                      std::stop_token stop) {
  const AlignOptions usual;
  const double rest = usual.static_motion_px_per_1000;
  BackgroundPictures pictures;
  const auto motion = measure_background_motion(
      video, person, rest_limit(usual), progress.stage(0, 0.7, "camera"), stop, &pictures, film, stretches);
  if (!motion) return motion.error();
  CameraMeasures camera;
  camera.motion = motion->motion, camera.tracks = motion->tracks;
  camera.sway = measure_sway(*motion);
  for (const FrameMotion& frame : motion->frames) camera.travel = std::max(camera.travel, frame.travel);
  camera.rests = true;
  if (motion->tracks >= kLeastTracks && motion->motion <= rest) {
    const PlateFit fit = fit_of_plate(pictures);
    camera.evidence = fmt::format(
        "The background moves by {:.2f} thousandths of the picture's width (limit {:.2f}, {:.0f} features "
        "followed), and one picture of it explains {:.0f} % of the frames.",
        motion->motion, rest, motion->tracks, 100 * (1 - fit.unexplained));
    if (fit.holds()) return camera;
  }
  if (pictures.grey.empty()) return camera;
  const double textured = share_with_texture(frames_of(*motion, pictures));
  if (textured < CameraKindLimits{}.judged) {
    take_verdict(without_texture(textured), camera);
    return camera;
  }
  const auto solve = solve_background(*motion, pictures, info, progress.stage(0.7, 1, "camera"), stop);
  if (!solve && solve.error().code == ErrorCode::cancelled) return solve.error();
  if (solve)
    take_verdict(judge_camera_kind(*solve), camera);
  else  // the person fills every picture: nothing can tell
    camera.sure = false, camera.evidence = solve.error().what;
  camera.rests = camera.kind == CameraKind::resting;
  return camera;
}

}  // namespace likeness
