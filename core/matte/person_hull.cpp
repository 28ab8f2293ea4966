// Head and torso move as two rigid parts; each has a box of voxels of its own.
#include "core/matte/person_hull.h"

#include <algorithm>

namespace likeness {
namespace {

constexpr double kHeadStep = 0.005, kTorsoStep = 0.01;  // m, about the tracked poses' precision
constexpr double kHair = 0.08;                          // m beyond the bare head
constexpr double kTorsoDepth = 0.4;                     // m below the neck's base that the hull reaches
// Evidence at shares of 0, 1/2 and 1. Below 1/2, several views from one direction see past the voxel; a hull
// is never smaller than the person, so being inside says less.
constexpr float kOutside = -3.0f, kInside = 1.2f;

}  // namespace

PersonHull carve_person(const PersonModel& person, const std::vector<MattedView>& views) {
  std::vector<HullView> head, torso;
  for (const auto& view : views) {
    head.push_back({view.place.cam_from_head, view.picture, view.person});
    if (view.place.torso_known) torso.push_back({view.place.cam_from_torso, view.picture, view.person});
  }
  PersonHull hull;
  hull.head = carve_hull(person.head_low - Vec3d(kHair, 0.02, kHair),
                         person.head_high + Vec3d(kHair, kHair, 0.03), kHeadStep, head);
  hull.torso = carve_hull(person.neck_base + Vec3d(-0.45, -kTorsoDepth, -0.22),
                          person.neck_base + Vec3d(0.45, 0.05, 0.18), kTorsoStep, torso);
  return hull;
}

void sharpen_prior(PersonPrior& prior, const PersonHull& hull, const PersonPlace& place,
                   const Intrinsics& picture) {
  if (hull.empty()) return;
  const cv::Mat head = hull_share(hull.head, place.cam_from_head, picture);
  cv::Mat share = head;
  // Beyond the torso's box, or without a torso, the hulls say nothing.
  const bool torso = place.torso_known && !hull.torso.empty();
  if (torso) share = cv::max(share, hull_share(hull.torso, place.cam_from_torso, picture));
  const double known_to = torso ? place.neck.y() + 0.8 * kTorsoDepth * place.px_per_metre
                                : 0.5 * (place.neck.y() + place.jaw_corners.y());
  const int bottom = std::clamp(int(known_to), 0, picture.height);
  for (int y = 0; y < bottom; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const float s = share.at<float>(y, x);
      // The hull of a torso at rest before a camera at rest includes the furniture beside it: being inside
      // says nothing.
      const float inside = head.at<float>(y, x);
      const float evidence = s < 0.5f        ? kOutside * (1 - 2 * s)
                             : inside > 0.5f ? kInside * (2 * inside - 1)
                                             : 0;
      float& location = prior.location.at<float>(y, x);
      location = (s > inside ? 1.0f : 0.5f) * location + evidence;
      if (inside > 0.7f) prior.possible.at<unsigned char>(y, x) = 255;
    }
}

}  // namespace likeness
