// Whether a tracked frame can be believed: good, weak or lost, with the reason in words.
#pragma once

#include <vector>

#include "core/scene/track.h"

namespace likeness {

// What is known of one frame when its verdict falls. Lengths in working px.
struct FrameEvidence {
  bool in_shot = true;  // false: in a part of the film that is left out
  bool camera_known = false;
  bool seen = false;           // it has landmarks
  bool detected = false;       // the detector itself found the face in this frame
  bool dense_solved = false;   // the dense tracks agree on a pose
  double source_px = 1;        // source px per working px: reasons speak of the source picture
  double inner_error_px = 0;   // of the fitted head model to the landmarks 17..67
  double eyes_px = 0;          // between the landmarks of the eyes' outer corners; 0: unknown
  double cluster_share = 1;    // share of the landmark runs that agree, 0..1
  double spread = 0;           // mean of the inner landmarks, in distances of the outer eye corners
  int votes = 0;               // landmarks that neighbouring frames could be followed to
  double disagreement_px = 0;  // median distance of those votes to the frame's own landmarks
  bool carried = false;        // the landmarks are those of neighbouring frames, followed here
  double look = 1;             // correlation with the person's other frames
};

struct FrameVerdict {
  FrameStatus status = FrameStatus::good;
  std::string reason;  // empty for good
};

// usual_error_px: the clip's median inner error, training frames only.
FrameVerdict judge_frame(const FrameEvidence& evidence, double usual_error_px);

// The pose a share t of the way from a to b.
Pose pose_between(const Pose& a, const Pose& b, double t);

// Lost frames get the pose and face between their neighbours, so that players need no special case. held_out:
// of the frames, or empty: a training frame lies between training frames, a held-out one goes on from what
// came before it. Where no such neighbour is, it stays as it is. shots: of the frames, or empty; a frame lies
// between those of its own shot if there is any, else between those of the others.
void bridge_lost(std::vector<TrackedFrame>& frames, const std::vector<bool>& held_out = {},
                 const std::vector<int>& shots = {});

}  // namespace likeness
