// One reason after the other.
#include "core/camera/judge_solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/camera/assumed_lens.h"

namespace likeness {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

void judge_lens(const Intrinsics& k, double focal_35mm, const SolveLimits& limits, SolveJudgement& judged) {
  const double longer = std::max(k.width, k.height), focal = k.width >= k.height ? k.fx : k.fy;
  judged.view_deg = focal > 0 ? 2 * std::atan(longer / 2 / focal) * kDegrees : 180;
  judged.squeeze = least_squeeze(k);
  if (!(judged.view_deg >= limits.narrowest && judged.view_deg <= limits.widest))
    judged.reasons.push_back(fmt::format(
        "Its lens would see {:.0f} degrees across the longer side (focal length {:.0f} px for {:.0f} px); "
        "cameras that people film with see {:.0f} to {:.0f}.",
        judged.view_deg, focal, longer, limits.narrowest, limits.widest));
  const bool tagged = focal_35mm > 0 && assumed_intrinsics(k.width, k.height, focal_35mm).fx ==
                                            film_intrinsics(k.width, k.height, focal_35mm).fx;
  if (tagged) {
    const double named = film_intrinsics(k.width, k.height, focal_35mm).fx;
    if (std::abs(focal - named) > limits.lens_apart * named)
      judged.reasons.push_back(fmt::format(
          "Its focal length of {:.0f} px is more than {:.0f} % off the {:.0f} px that the clip names for its "
          "lens.",
          focal, 100 * limits.lens_apart, named));
  }
  if (judged.squeeze < limits.squeeze)
    judged.reasons.push_back(fmt::format(
        "Its lens distortion folds the picture's border, or nearly: the scale there falls to {:.2f} "
        "of the middle's (at least {:.2f}).",
        judged.squeeze, limits.squeeze));
}

}  // namespace

double least_squeeze(const Intrinsics& k) {
  // The farthest corner's distorted radius; undistorted radii are walked through until it is reached.
  double corner = 0;
  for (const double x : {0.0, double(k.width)})
    for (const double y : {0.0, double(k.height)})
      corner = std::max(corner, std::hypot((x - k.cx) / k.fx, (y - k.cy) / k.fy));
  double least = 1;
  constexpr int kSteps = 1000;
  constexpr double kFarthest = 4;  // times the corner's radius: a lens that has not reached it folds before
  for (int i = 1; i <= kSteps; ++i) {
    const double r = kFarthest * corner * i / kSteps, r2 = r * r;
    least = std::min(least, 1 + r2 * (3 * k.k1 + 5 * r2 * k.k2));
    if (least <= 0 || r * (1 + r2 * (k.k1 + r2 * k.k2)) >= corner) break;
  }
  return least;
}

SolveJudgement judge_solve(const ColmapModel& model, int keyframes, double focal_35mm,
                           const SolveLimits& limits) {
  SolveJudgement judged;
  judged.placed = keyframes > 0 ? double(model.images.size()) / keyframes : 0;
  if (model.cameras.empty() || model.images.empty()) {
    judged.reasons.push_back("It placed no keyframe.");
    return judged;
  }
  const Intrinsics& k = model.cameras.begin()->second;
  judge_lens(k, focal_35mm, limits, judged);
  judged.parallax_deg = median_parallax(model) * kDegrees;
  judged.reprojection = mean_reprojection_px(model) / std::max(1, k.width);
  if (judged.parallax_deg < limits.parallax)
    judged.reasons.push_back(fmt::format(
        "The camera hardly travelled: rays to its points meet at {:.1f} degrees (median; at least {:.1f} are "
        "needed for their depth).",
        judged.parallax_deg, limits.parallax));
  if (judged.reprojection > limits.reprojection)
    judged.reasons.push_back(fmt::format(
        "Its points miss the pictures by {:.1f} thousandths of the width on average (at most {:.1f}).",
        1000 * judged.reprojection, 1000 * limits.reprojection));
  if (judged.placed < limits.placed)
    judged.reasons.push_back(fmt::format("It placed only {} of {} keyframes ({:.0f} % needed).",
                                         model.images.size(), keyframes, 100 * limits.placed));
  return judged;
}

}  // namespace likeness
