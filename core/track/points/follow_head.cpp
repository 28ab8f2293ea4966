// See follow_head.h.
#include "core/track/points/follow_head.h"

#include <algorithm>

namespace likeness {
namespace {

constexpr int kPoints = 300, kFewPoints = 200;  // tracked; below the second, new ones are added
constexpr int kMinInliers = 12;
constexpr double kMinAgreeing = 0.5;                  // of the followed points must agree
constexpr double kCornerQuality = 0.01;               // of the best corner
constexpr double kMinPointFacing = 0.35;              // cosine
constexpr double kBackAndForth = 0.5, kAgrees = 2.5;  // px

}  // namespace

HeadFollower::HeadFollower(const RigidHead& head, const Intrinsics& intrinsics, const Image8& grey,
                           const Pose& cam_from_head)
    : head_(head), intrinsics_(intrinsics), picture_(grey), pose_(cam_from_head) {
  add_points();
}

FollowedFrame HeadFollower::next(const Intrinsics& intrinsics, const Image8& grey) {
  FollowedFrame followed;
  followed.cam_from_head = pose_;
  const TrackPicture now(grey);
  std::vector<Vec2d> from;
  for (const Point& point : points_) from.push_back(point.pixel);
  const auto found = follow_points(picture_, now, from, {}, kBackAndForth);
  std::vector<Point> alive;
  std::vector<PoseObservation> seen;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!found[i]) continue;
    alive.push_back({points_[i].place, *found[i]});
    seen.push_back({points_[i].place, ray_direction(intrinsics, *found[i]).head<2>()});
  }
  const auto pose = solve_pose(seen, intrinsics.fx, pose_, {});
  if (!pose || pose->inliers < std::max<double>(kMinInliers, kMinAgreeing * double(seen.size())))
    return followed;
  followed.solved = true;
  followed.cam_from_head = pose->cam_from_head;
  points_.clear();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Vec3d in_cam = pose->cam_from_head * seen[i].point;
    if (in_cam.z() < 0.05 || (in_cam.hnormalized() - seen[i].ray).norm() * intrinsics.fx > kAgrees) continue;
    points_.push_back(alive[i]);
  }
  picture_ = now;
  intrinsics_ = intrinsics;
  pose_ = pose->cam_from_head;
  if (points_.size() < kFewPoints) add_points();
  return followed;
}

void HeadFollower::correct(const Pose& cam_from_head) {
  pose_ = cam_from_head;
  std::vector<Point> kept;
  for (const Point& point : points_)
    if (const auto place = place_of(point.pixel)) kept.push_back({*place, point.pixel});
  points_ = std::move(kept);
}

// What is taken for hair may be the static wall beside it; points on slanted skin slide.
std::optional<Vec3d> HeadFollower::place_of(const Vec2d& pixel) const {
  const auto place = point_on_head(head_, pose_, ray_direction(intrinsics_, pixel).head<2>());
  if (!place || place->hair) return std::nullopt;
  const Vec3d in_cam = pose_ * place->point;
  if (-(pose_.linear() * place->normal).dot(in_cam.normalized()) < kMinPointFacing) return std::nullopt;
  return place->point;
}

void HeadFollower::add_points() {
  const Image8 mask = corner_mask(head_, intrinsics_, pose_);
  std::vector<Vec2d> taken;
  for (const Point& point : points_) taken.push_back(point.pixel);
  PointTrackOptions options;
  options.corner_quality = kCornerQuality;
  for (const Vec2d& corner : find_corners(picture_, mask, taken, kPoints - int(points_.size()), options))
    if (const auto place = place_of(corner)) points_.push_back({*place, corner});
}

}  // namespace likeness
