// When in its performance the demo's person is, and how head and torso are held there.
#pragma once

#include "core/head/pose_head.h"
#include "core/synth/demo_options.h"

namespace likeness {

struct Moment {
  bool walking = true;  // the first part of the performance, in which the camera moves
  double share = 0;     // of the part, [0, 1]
  double phase = 0;     // within the cycle, [0, 1)
  int cycle = 0;
  double time_s = 0;
  double finale = -1;  // how far into the closing cycle, [0, 1); < 0 before
};
// frame: of the performance, also between frames and, for what lags behind, before the first.
Moment moment_of(const DemoOptions& options, double frame);

// Number of frames, from the first, in which the camera moves and the head rests, unless it is restless.
int moving_frames(const DemoOptions& options);

// How many frames the closing cycle has: the last tenth.
int closing_frames(const DemoOptions& options);

// World: the rest position of the head frame (x to the subject's left, y up, z out of the face).
struct BodyPose {
  Pose world_from_head = Pose::Identity(), world_from_torso = Pose::Identity();
};
// Yaw to the subject's left, pitch down and roll, rad, applied from the last to the first.
Mat3d head_turn(double yaw, double pitch, double roll);

BodyPose body_pose(const DemoOptions& options, const HeadShape& shape, double frame);

}  // namespace likeness
