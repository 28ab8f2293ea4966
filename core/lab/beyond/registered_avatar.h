// An avatar posed by the truth of the demo that it was made from: registered once to the true head and torso,
// so that what a picture shows is the avatar's doing and not the tracker's. A head that hardly moves does not
// say how large it is and where in its frame: that is taken from the fitted and the true face, and only turns
// and distance from the poses.
#pragma once

#include <set>

#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/lab/truth/track_truth.h"
#include "core/render/avatar.h"
#include "core/render/pose_avatar.h"
#include "core/scene/track.h"
#include "core/synth/performance.h"

namespace likeness {

struct Registration {
  double scale = 1;  // true metres / the avatar's: of the faces
  Mat3d true_head_from_head = Mat3d::Identity();
  Vec3d true_face = Vec3d::Zero(),
        face = Vec3d::Zero();  // m, middle of either face at rest, in its head frame
  double lens = 1;  // focal length that was found / the true one; the distance of the face makes up for it
  // The rest of the face's distance from the camera, of the true one: the fitted face need not be as large.
  double farther = 1;
  Pose true_torso_from_torso = Pose::Identity();  // in true metres
  Intrinsics picture;                             // of the project's pictures, through the lens it found
};

// From the training frames of the track that the avatar was trained on. Error: too few of them are tracked.
Result<Registration> register_to_truth(const Capture& capture, const CameraSet& cameras, const Track& track,
                                       const HeadModel& model, const TrackTruth& truth);

// What the avatar has to show of a true shot, in a world of its own.
struct PosedShot {
  Camera camera;
  AvatarPose pose;
};
// The face performs on top of the avatar's rest what the true one performs on top of its own. The avatar's
// head model is the truth's.
PosedShot pose_as(const Registration& registration, const Avatar& avatar, const Shot& shot);

}  // namespace likeness
