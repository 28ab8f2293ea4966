// Tracking a head from picture to picture by points on it, from a picture of known pose: no landmarks are
// used, so that reflections, hands and jumps of a predictor do no harm.
//
// Poses are solved against points placed on the person's own surface. On smooth skin, points follow the light
// rather than the head, by half a degree per picture at worst: call correct() after each picture in which the
// face itself can be fitted.
#pragma once

#include <optional>
#include <vector>

#include "core/camera/camera.h"
#include "core/image/image.h"
#include "core/track/points/bundle.h"
#include "core/track/points/point_tracks.h"
#include "core/track/points/rigid_head.h"

namespace likeness {

struct FollowedFrame {
  bool solved = false;                    // enough points agree on the pose
  Pose cam_from_head = Pose::Identity();  // if not solved: the last solved pose
};

class HeadFollower {
 public:
  // grey: the working picture that shows the head at this pose. The head must outlive the follower.
  HeadFollower(const RigidHead& head, const Intrinsics& intrinsics, const Image8& grey,
               const Pose& cam_from_head);
  // The next picture, before or after in time. After one that does not show the head, the same points are
  // searched for in the next.
  FollowedFrame next(const Intrinsics& intrinsics, const Image8& grey);
  // Sets the head's pose in that picture from a more reliable source: the points are placed again.
  void correct(const Pose& cam_from_head);

 private:
  struct Point {
    Vec3d place;  // head frame, m
    Vec2d pixel;  // in picture_
  };
  std::optional<Vec3d> place_of(const Vec2d& pixel) const;
  void add_points();

  const RigidHead& head_;
  Intrinsics intrinsics_;  // of picture_
  TrackPicture picture_;   // the last one in which the pose was solved
  Pose pose_;
  std::vector<Point> points_;
};

}  // namespace likeness
