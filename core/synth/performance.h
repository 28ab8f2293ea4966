// What happens in the demo: where the camera is, the turns of the head and the expressions of the face, as
// functions of the frame number. World: the rest position of the head frame (x to the subject's left, y up, z
// out of the face).
#pragma once

#include <string>

#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/head/pose_head.h"
#include "core/synth/body_pose.h"
#include "core/synth/demo_options.h"

namespace likeness {

struct Shot {
  Camera camera;  // frame, intrinsics, cam_from_world
  Pose world_from_head = Pose::Identity();
  Pose world_from_torso = Pose::Identity();
  Pose world_from_late_head = Pose::Identity();  // loose hair alone: of the head a moment ago
  Articulation articulation;
  float habit = 0;  // 0..1, of the person's own (DemoOptions::habit)
};

// How much of the habit a frame shows: some swells of different lengths, at independent times.
float habit_strength(const DemoOptions& options, double frame);

// What the film's frame shows; later_s: that long after its middle, s. Deterministic. model: its named
// actions are used, those it lacks are left out.
Shot perform(const HeadModel& model, const HeadShape& shape, const DemoOptions& film, int frame,
             double later_s = 0);

}  // namespace likeness
