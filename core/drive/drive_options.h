// What is asked of driving, and the gains that follow.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/drive/drive_subject.h"

namespace likeness {

struct DriveOptions {
  std::map<std::string, float> gains = {};  // per named action, on top of the calibrated ones
  // A gain above 1 amplifies the motion of an action but not its jitter.
  bool calibrate_gains = true;  // bring the driver's seen range nearer to the avatar's, by a third at most
  bool clamp = true;            // keep to what the avatar's capture showed, softly
  bool move_head = true;        // false: the head rests in its typical pose
  double torso_share = 0.1;     // of the neck's travel that the torso follows
  double torso_s = 0.3;         // time constant with which it follows
  double reach_m = 0.03;  // the head leaves the torso by no more than this; beyond, the whole body moves
  // The head leaves its typical place by at most half as much again: a driver filmed hand-held would carry
  // the avatar out of its picture. The body hardly rises, since below the picture's edge it was never seen.
  double span_m = 0.06, rise_m = 0.003;
  bool smooth = false;  // one-euro filter on pose and face; costs a little lag
};

// Applied gain of each of the avatar's actions, 1 = as performed.
std::vector<float> drive_gains(const DriveSubject& driver, const DriveSubject& avatar,
                               const DriveOptions& options);

}  // namespace likeness
