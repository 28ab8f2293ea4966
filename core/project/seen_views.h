// From where a project's training pictures show the head: what an orbit or a head turn may be compared with.
#pragma once

#include <vector>

#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/scene/track.h"

namespace likeness {

// Where the camera stands as seen from the head, rad: yaw positive to the subject's left, pitch positive
// above (those of orbit_camera), and by how much the head is rolled in the picture (that of turned_head).
// Zero looks straight into the face.
struct ViewAngle {
  double yaw = 0, pitch = 0, roll = 0;
};
ViewAngle view_angle(const Pose& cam_from_head);

// 2nd to 98th percentile of the views, rad.
struct SeenViews {
  ViewAngle low, high;
  std::vector<ViewAngle> views;  // one a training frame whose head and camera are known
};
SeenViews seen_views(const Capture& capture, const CameraSet& cameras, const Track& track);

// As if the frames of both were of one clip.
SeenViews joined(const SeenViews& a, const SeenViews& b);

// Angle between the direction of a view and the nearest seen one, rad; pi where nothing was seen. Roll does
// not count: it shows nothing new.
double from_nearest_view(const SeenViews& seen, double yaw, double pitch);

}  // namespace likeness
