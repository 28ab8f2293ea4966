// What happens in the demo: the path of the camera, the turns of the head and the expressions of the face, as
// functions of the frame number. World: the rest position of the head frame (x to the subject's left, y up, z
// out of the face).
#pragma once

#include <string>

#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/head/pose_head.h"
#include "core/synth/demo_options.h"

namespace likeness {

struct Shot {
  Camera camera;  // frame, intrinsics, cam_from_world
  Pose world_from_head = Pose::Identity();
  Pose world_from_torso = Pose::Identity();
  Articulation articulation;
  float habit = 0;  // 0..1, of the person's own (DemoOptions::habit)
};

// How much of the habit a frame shows: some swells of different lengths, at independent times.
float habit_strength(const DemoOptions& options, int frame);

// Number of frames, from the first, in which the camera moves and the head rests, unless it is restless.
int moving_frames(const DemoOptions& options);

// Deterministic. model: its named actions are used, those it lacks are left out.
Shot perform(const HeadModel& model, const HeadShape& shape, const DemoOptions& options, int frame);

}  // namespace likeness
