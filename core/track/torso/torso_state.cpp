// See torso_state.h.
#include "core/track/torso/torso_state.h"

#include "core/base/rigid.h"

namespace likeness {

Pose motion_pose(const TorsoMotion& m, const Vec2d& pivot) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation_about(Vec3d::UnitZ(), m.angle);
  const Vec3d about(pivot.x(), pivot.y(), 0);
  pose.translation() = about + Vec3d(m.shift.x(), m.shift.y(), m.depth) - pose.linear() * about;
  return pose;
}

bool seen_at(const TorsoView& view, const Pose& motion, const Vec3d& posed, Vec2d* px) {
  const Vec3d p = view.frame->cam_from_world * (view.reference * (motion * posed));
  if (p.z() < 0.05) return false;
  const Vec2d full = project<double>(view.frame->intrinsics, p);
  *px = full * view.level->scale;
  return !holds(view.frame->head_outline, full, kTorsoHeadMargin);
}

Vec3d displaced(const TorsoGrid& grid, const std::vector<float>& displacement, const Vec3d& place) {
  if (displacement.empty()) return place;
  const GridPlace at = place_in(grid, float(place.x()), float(place.y()));
  Vec3d moved = place;
  for (std::size_t k = 0; k < 4; ++k)
    for (int c = 0; c < 2; ++c)
      moved[c] += double(at.weight[k]) * displacement[2 * std::size_t(at.node[k]) + std::size_t(c)];
  return moved;
}

}  // namespace likeness
