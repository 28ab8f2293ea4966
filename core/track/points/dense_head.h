// Dense rigid head tracking of a clip: point tracks and bundle adjustment on the training frames, then every
// other frame by itself against the frozen points, found by Lucas-Kanade from the training frames nearest in
// pose.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/track/clip_frames.h"
#include "core/track/points/bundle.h"
#include "core/track/points/rigid_head.h"
#include "core/track/points/withheld_points.h"

namespace likeness {

struct DenseFrame {
  bool known = false;                     // has a landmark pose to start from
  bool solved = false;                    // the dense pose replaced it
  Intrinsics intrinsics;                  // of the working picture
  Pose cam_from_head = Pose::Identity();  // in: landmark pose; out: dense pose where solved
  int points = 0;                         // points that agree with the pose
  double median_px = 0;
};

// A point of the head as the adjustment left it, and where training frames saw it.
struct HeadPoint {
  BundleTrack track;
  bool on_skin = false;  // started on the head's surface, not on the hull of the hair
};

struct DenseSummary {
  std::vector<HeadPoint> points;  // those kept
  BundleSummary bundle;
  int found_tracks = 0;
  double mean_track_length = 0;
  double turn_change_deg = 0, shift_change_m = 0;  // rms change by the dense poses, training frames
};

// resting_camera: the neck's depth then hardly changes (BundleOptions::neck_rest). withheld: null, or
// receives a share of the point tracks, which then do not enter the adjustment.
Result<DenseSummary> track_dense_head(const ClipFrames& clip, const RigidHead& head, bool resting_camera,
                                      std::vector<DenseFrame>& frames, const Progress& progress,
                                      std::stop_token stop, WithheldPoints* withheld = nullptr);

// Intrinsics of the working picture of a region of the source.
Intrinsics working_intrinsics(const Intrinsics& source, const ClipFrames& clip);

}  // namespace likeness
