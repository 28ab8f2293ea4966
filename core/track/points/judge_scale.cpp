#include "core/track/points/judge_scale.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "core/base/quantile.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

// Diagonal of the box round all places but the outermost: single frames that were placed wrongly do not make
// a path.
double reach_of(const std::vector<Vec3d>& places) {
  constexpr double kOutermost = 0.02;
  Vec3d size = Vec3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> along;
    for (const Vec3d& place : places) along.push_back(place[axis]);
    size[axis] = quantile(along, 1 - kOutermost) - quantile(along, kOutermost);
  }
  return size.norm();
}

std::string length_words(double metres) {
  const double shown = std::round(metres < 1 ? 1000 * metres : 10 * metres) / 10;
  return fmt::format("{:g} {}", shown, metres < 1 ? "cm" : "m");
}

}  // namespace

ScaleJudgement judge_scale(const std::vector<HeadSighting>& sightings, std::optional<double> metres_per_unit,
                           const ScaleLimits& limits) {
  ScaleJudgement judged;
  if (sightings.empty()) return judged;
  std::vector<double> distances;
  std::vector<Vec3d> places;
  for (const HeadSighting& s : sightings) {
    distances.push_back(s.cam_from_head.translation().norm());
    places.push_back(inverse(s.cam_from_world).translation());
  }
  judged.distance_m = median(std::move(distances));
  if (!(judged.distance_m >= limits.nearest && judged.distance_m <= limits.farthest))
    judged.reasons.push_back(fmt::format(
        "The head would be {} from the camera; people are filmed from {} to {}.",
        length_words(judged.distance_m), length_words(limits.nearest), length_words(limits.farthest)));
  if (!metres_per_unit) return judged;
  judged.reach_m = *metres_per_unit * reach_of(places);
  if (!(judged.reach_m >= limits.least_reach))
    judged.reasons.push_back(fmt::format("The camera would have moved by only {}; depth needs {} at least.",
                                         length_words(judged.reach_m), length_words(limits.least_reach)));
  else if (judged.reach_m > limits.most_reach)
    judged.reasons.push_back(
        fmt::format("The camera would have moved by {}; nobody walks round a head further than {}.",
                    length_words(judged.reach_m), length_words(limits.most_reach)));
  return judged;
}

std::vector<HeadSighting> sightings_of(const Track& track, const CameraSet& cameras) {
  std::vector<HeadSighting> sightings;
  for (const TrackedFrame& frame : track.frames) {
    if (frame.status == FrameStatus::lost) continue;
    if (const Camera* camera = find_camera(cameras, frame.frame))
      sightings.push_back(
          {camera->cam_from_world,
           metric_camera(camera->cam_from_world, track.metres_per_unit) * frame.pose.world_from_head});
  }
  return sightings;
}

std::string scale_warning(const Track& track, const CameraSet& cameras) {
  if (cameras.rests() || cameras.scale == CameraScale::metric) return "";
  const ScaleJudgement judged = judge_scale(
      sightings_of(track, cameras), track.metre_known ? std::optional(track.metres_per_unit) : std::nullopt);
  if (judged.reasons.empty()) return "";
  return fmt::format(
      "By the head's size the path that was found for the camera cannot be true: {} Say what the camera did, "
      "--camera-kind resting or handheld, or film again, walking slowly in half a circle round the head.",
      fmt::join(judged.reasons, " "));
}

}  // namespace likeness
