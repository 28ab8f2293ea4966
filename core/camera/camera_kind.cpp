// Which of the four, in the order in which one rules out the next.
#include "core/camera/camera_kind.h"

#include <fmt/format.h>

namespace likeness {

CameraVerdict judge_camera_kind(const HandheldSolve& solve, const CameraKindLimits& limits) {
  const double width = solve.reference.width;
  const double sigma = 1000 * solve.sigma_px / width, misfit = 1000 * solve.misfit_px / width;
  // Shading without edges follows the person's shadow as readily as the camera: only parts with texture can
  // tell.
  if (solve.explained > 0 && solve.judged < limits.judged)
    return {CameraExplanation::no_texture,
            fmt::format(
                "The background has too little texture to show whether the camera moves: in {:.0f} % of the "
                "frames parts of it would tell ({:.0f} % needed).",
                100 * solve.judged, 100 * limits.judged)};
  if (solve.explained < limits.explained)
    return {
        CameraExplanation::unexplained,
        fmt::format("Only {:.0f} % of the frames show a background that one turning camera explains ({:.0f} "
                    "% needed): the camera travels, or the scene changes.",
                    100 * solve.explained, 100 * limits.explained)};
  if (solve.motion <= limits.resting)
    return {
        CameraExplanation::resting,
        fmt::format("The camera rests: the background strays by {:.2f} thousandths of the picture's width "
                    "(limit {:.2f}), known to {:.2f}.",
                    solve.motion, limits.resting, sigma)};
  if (solve.misfitting > limits.misfitting)
    return {CameraExplanation::unexplained,
            fmt::format("The camera travels: in {:.0f} % of the frames parts of the background lie more than "
                        "{:.1f} thousandths of the width away from where a camera that only turns and zooms "
                        "would show them (half of the frames: {:.1f}; {:.0f} % of the frames allowed).",
                        100 * solve.misfitting, 1000 * kMisfitLimit, misfit, 100 * limits.misfitting)};
  return {
      CameraExplanation::handheld,
      fmt::format("The camera is hand-held: the background strays by {:.1f} thousandths of the picture's "
                  "width, and turning and zooming about one place explains {:.0f} % of the frames to {:.1f} "
                  "thousandths.",
                  solve.motion, 100 * solve.explained, misfit)};
}

}  // namespace likeness
