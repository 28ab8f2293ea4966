// Rigid bundle adjustment of a head: one pose per key frame and one 3-D point per track, robust, around given
// poses.
//
// Key frames bound the cost; every other frame's pose is then solved alone against the frozen points
// (solve_pose).
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/progress.h"
#include "core/base/result.h"

namespace likeness {

struct BundleObservation {
  int frame = 0;  // index into the poses
  Vec2d ray;      // x/z, y/z
};

struct BundleTrack {
  Vec3d point = Vec3d::Zero();  // head frame, m; start in, result out
  std::vector<BundleObservation> seen;
  bool kept = true;  // false once dropped as not moving with the head
};

struct BundleFrame {
  bool known = false;                     // has a prior pose
  double focal_px = 1000;                 // rays times this are working px
  Pose cam_from_head = Pose::Identity();  // prior in, result out
  int shot = 0;                           // no motion is smooth from one to another
};

struct BundleOptions {
  // Poses that are solved for together: every frame up to this many, then every second to fourth; only if
  // that leaves more than `max_key_frames`, in clips of minutes, fewer: the cost of an iteration grows with
  // their cube. The poses between follow from the points.
  int key_frames = 150, max_key_frames = 500;
  int max_dense = 200;  // key frames up to which the poses are solved for as one full matrix
  int rounds = 3;
  double turn_prior = 20;   // per rad, robust: the landmark pose is no more certain than this
  double shift_prior = 60;  // per m
  // Per m, for heads that turn by full_turn or more (rms about the mean, rad), and up to max_point_prior for
  // those that turn less. Tracked points drift with the light by some tenths of a pixel, all observations of
  // one alike, and the resulting depth error grows with 1 / turn: there the initial guess is better.
  double point_prior = 30, max_point_prior = 120, full_turn = 0.17;
  double turn_smooth = 20;   // second difference between neighbouring frames, per rad
  double shift_smooth = 50;  // per m
  // Per m, robust, in depth: a head turns about its neck, and the neck of a seated person stays in place.
  // Views that share few points with the others say little about their depth. 0: the camera moves.
  double neck_rest = 0;
};

struct BundleSummary {
  int tracks = 0, observations = 0;
  double median_px = 0;  // residual of the kept observations
};

// `frames` must be ascending in time without gaps in the index; second differences use known neighbours.
Result<BundleSummary> bundle_adjust(std::vector<BundleFrame>& frames, std::vector<BundleTrack>& tracks,
                                    const BundleOptions& options, const Progress& progress,
                                    std::stop_token stop);

struct PoseObservation {
  Vec3d point;  // head frame
  Vec2d ray;
};
struct SolvedPose {
  Pose cam_from_head;
  int inliers = 0;       // within 3 px
  double median_px = 0;  // of the inliers
};
// Pose alone, Cauchy 0.5 px after a coarser start, with a weak pull to `prior`. nullopt with fewer than 8
// inliers.
std::optional<SolvedPose> solve_pose(const std::vector<PoseObservation>& seen, double focal_px,
                                     const Pose& prior, const BundleOptions& options);

}  // namespace likeness
