// Carrying a performance over from one person's track to another person's avatar.
//
// What is carried over is the difference from each person's own rest: expression and jaw through named
// actions, gaze as eyeball turns, the head's motion relative to its typical pose about the neck. The driver
// at rest gives the avatar at rest; nothing of the driver's looks is copied.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/head/action_amounts.h"
#include "core/head/head_model.h"
#include "core/scene/avatar_pose.h"
#include "core/scene/track.h"

namespace likeness {

struct Avatar;  // core/render/avatar.h

// One side of the transfer.
struct DriveSubject {
  const HeadModel* model = nullptr;
  PersonShape person;
  Articulation neutral;
  std::vector<SeenAction> seen;
  Pose world_from_head = Pose::Identity();   // typical
  Pose world_from_torso = Pose::Identity();  // typical; the driver's is not used
};

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

struct DrivenFrame {
  int frame = 0;
  double time_s = 0;
  bool bridged = false;  // the driver was lost here
  AvatarPose pose;       // in the avatar's world, of the avatar's head model; attributes at rest
};

// The driver as a subject: typical pose (medoid of the good frames) and seen ranges (2nd to 98th percentile)
// of the track.
Result<DriveSubject> subject_from_track(const Track& track, const HeadModel& model);

// The avatar as the driven side. model: the one the avatar was made with; must outlive the subject.
DriveSubject avatar_subject(const Avatar& avatar, const HeadModel& model);

// Applied gain of each of the avatar's actions, 1 = as performed.
std::vector<float> drive_gains(const DriveSubject& driver, const DriveSubject& avatar,
                               const DriveOptions& options);

// One frame per frame of the track. Fails on an unknown action in `gains`, a track without a usable frame, or
// a track made with a model other than the driver's.
Result<std::vector<DrivenFrame>> drive(const Track& track, const DriveSubject& driver,
                                       const DriveSubject& avatar, const DriveOptions& options);

// x within [low, high]; beyond, it bends smoothly towards a limit `margin` further out.
float soft_clamp(float x, float low, float high, float margin);

}  // namespace likeness
