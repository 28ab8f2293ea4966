// Which of the four, in the order in which one rules out the next.
#include "core/camera/camera_kind.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/camera/align_view.h"

namespace likeness {

CameraVerdict without_texture(double judged, const CameraKindLimits& limits) {
  return {CameraExplanation::no_texture,
          fmt::format(
              "The background has too little texture to show whether the camera moves: in {:.0f} % of the "
              "frames parts of it would tell ({:.0f} % needed).",
              100 * judged, 100 * limits.judged)};
}

CameraVerdict judge_camera_kind(const HandheldSolve& solve, const CameraKindLimits& limits) {
  const double width = solve.reference.width;
  const double sigma = 1000 * solve.sigma_px / width;
  const double misfit = 1000 * kMisfitLimit * solve.misfit_px / misfit_limit_px(solve.reference);
  // Shading without edges follows the person's shadow as readily as the camera: only parts with texture can
  // tell.
  if (solve.explained > 0 && solve.judged < limits.judged) return without_texture(solve.judged, limits);
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
            fmt::format(
                "The camera travels: in {:.0f} % of the pairs of frames laid over each other, parts of the "
                "background lie more than {:.1f} thousandths of the picture away from where a camera that "
                "stays in its place would show them (half of the pairs: {:.1f}; {:.0f} % of them allowed).",
                100 * solve.misfitting, 1000 * kMisfitLimit, misfit, 100 * limits.misfitting)};
  const double strays = solve.motion * width / std::max(width, double(solve.reference.height));
  if (strays > limits.swaying)
    return {
        CameraExplanation::unexplained,
        fmt::format("The camera travels: the background strays by {:.0f} thousandths of the picture, and the "
                    "person stays in it (limit {:.0f}).",
                    strays, limits.swaying)};
  return {CameraExplanation::handheld,
          fmt::format(
              "The camera is hand-held: the background strays by {:.1f} thousandths of the picture's "
              "width, and {} about one place explains {:.0f} % of the frames to {:.1f} thousandths of it.",
              solve.motion, solve.shifts ? "turning, zooming and shifting" : "turning and zooming",
              100 * solve.explained, misfit)};
}

}  // namespace likeness
