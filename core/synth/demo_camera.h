// Where the demo's camera is and through which lens it looks, in every frame, for every kind of camera.
//
// A hand's sway is a sum of sines: slow drift whose amplitude falls with frequency, and the tremor of an
// outstretched arm at 1 to 3 Hz.
#pragma once

#include <string>
#include <vector>

#include "core/camera/camera.h"
#include "core/head/pose_head.h"
#include "core/synth/demo_options.h"
#include "core/synth/demo_shots.h"

namespace likeness {

const std::vector<std::string>& demo_camera_names();  // in DemoCamera's order: "guided", "resting", ...

// Where the person sits in the room and looks to, for a shot's place: from where they sit in place 0.
Pose placed_person(int place);

// options: uncut. frame: of the performance, also between frames. The camera's `frame` stays 0.
Camera demo_camera(const DemoOptions& options, const HeadShape& shape, const DemoShot& shot, double frame);

// Whether the camera is the same in every frame around this one of the performance.
bool camera_rests(const DemoOptions& options, double frame);

// As phones write it: mm on 35 mm film by the picture's longer side, whole. Of the lens as it is without zoom
// and crop.
int focal_35mm(const DemoOptions& options);

// The bounds of hand_turn_deg and hand_shift_m.
inline constexpr double kMostHandTurn_deg = 10, kMostHandShift_m = 0.05;

}  // namespace likeness
