// A head followed from picture to picture by the points on it, from one whose pose is known: no landmark is
// asked, so that reflections, hands and jumps of a predictor lead nowhere.
//
// Poses are solved against points placed on the person's own surface. On smooth skin points go with the light
// rather than with the head, by half a degree a picture at worst: correct() after each picture where the face
// itself can be fitted.
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
  Pose cam_from_head = Pose::Identity();  // where it is not: the last one that was
};

class HeadFollower {
 public:
  // grey: the working picture that shows the head at this pose. The head must outlive the follower.
  HeadFollower(const RigidHead& head, const Intrinsics& intrinsics, const Image8& grey,
               const Pose& cam_from_head);
  // The next picture, before or after in time. After one that does not show the head the same points are
  // sought in the next one.
  FollowedFrame next(const Intrinsics& intrinsics, const Image8& grey);
  // Something surer than the points says where the head is in that picture: they are placed anew.
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
