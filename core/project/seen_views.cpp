// Camera directions in the head frame: see seen_views.h.
#include "core/project/seen_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/project/project_views.h"

namespace likeness {
namespace {

Vec3d direction(double yaw, double pitch) {
  return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
}

// The 2nd and 98th percentiles of the views.
void set_range(SeenViews& seen) {
  std::vector<double> yaws, pitches, rolls;
  for (const ViewAngle& view : seen.views)
    yaws.push_back(view.yaw), pitches.push_back(view.pitch), rolls.push_back(view.roll);
  if (seen.views.empty()) return;
  seen.low = {quantile(yaws, 0.02), quantile(pitches, 0.02), quantile(rolls, 0.02)};
  seen.high = {quantile(yaws, 0.98), quantile(pitches, 0.98), quantile(rolls, 0.98)};
}

}  // namespace

ViewAngle view_angle(const Pose& cam_from_head) {
  const Vec3d to_camera = inverse(cam_from_head).translation().normalized();
  ViewAngle view;
  view.yaw = std::atan2(to_camera.x(), to_camera.z());
  view.pitch = std::asin(std::clamp(to_camera.y(), -1.0, 1.0));
  // The head's up in the picture, whose own up is -y. A positive roll about the axis out of the face carries
  // it to the picture's left.
  const Vec3d up = cam_from_head.linear() * Vec3d::UnitY();
  view.roll = std::atan2(-up.x(), -up.y());
  return view;
}

SeenViews seen_views(const Capture& capture, const CameraSet& cameras, const Track& track) {
  SeenViews seen;
  for (const CaptureFrame& frame : capture.frames) {
    const TrackedFrame* tracked = find_tracked(track, frame.frame);
    const auto camera = picture_camera(capture, cameras, track, frame.frame);
    if (!frame.used || tracked == nullptr || tracked->status == FrameStatus::lost || !camera) continue;
    seen.views.push_back(view_angle(camera->cam_from_world * tracked->pose.world_from_head));
  }
  set_range(seen);
  return seen;
}

SeenViews joined(const SeenViews& a, const SeenViews& b) {
  SeenViews seen = a;
  seen.views.insert(seen.views.end(), b.views.begin(), b.views.end());
  set_range(seen);
  return seen;
}

double from_nearest_view(const SeenViews& seen, double yaw, double pitch) {
  double nearest = -1;  // cosine
  for (const ViewAngle& view : seen.views)
    nearest = std::max(nearest, direction(yaw, pitch).dot(direction(view.yaw, view.pitch)));
  return seen.views.empty() ? std::numbers::pi : std::acos(std::clamp(nearest, -1.0, 1.0));
}

}  // namespace likeness
