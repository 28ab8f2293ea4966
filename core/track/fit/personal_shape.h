// A person's own surface on top of the identity: one smooth offset per vertex of the head at rest, from the
// evidence of all training frames. (In place of MICA's metric shape in Li 2022, found in the clip itself.)
//
// Least squares over the offsets with the prior of shape_field.h. A term is linear, g . offset = wanted:
//   points     of the dense step: distance from the surface, along its normal, after one similarity has
//              carried all of them onto it (pictures know neither size nor place of a cloud of points)
//   contours   of the posed face: the picture's edge found near the outline (face_contour.h)
//   landmarks  what the fit leaves of them, in the picture
// Terms are robust (Geman and McClure) and found again in every round, from the surface of that round.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/face/fit_frame.h"
#include "core/image/image.h"
#include "core/track/fit/shape_field.h"
#include "core/track/points/dense_head.h"

namespace likeness {

// A point of the skin, as the pictures place it for the face in its usual state.
struct ShapePoint {
  Vec3d point = Vec3d::Zero();       // head frame, m
  Mat3d covariance = Mat3d::Zero();  // m^2
};

// The skin's points among those of the dense step, with uncertainties from their lines of sight. Points
// started on the hull of the hair are excluded. frames: as the dense step left them.
std::vector<ShapePoint> skin_points(std::span<const HeadPoint> points, std::span<const DenseFrame> frames);

struct ShapeFrame {
  const Image8* grey = nullptr;  // working picture; null: the frame is left out
  bool held_out = false;         // left out as well
  Intrinsics intrinsics;         // of the working picture
  FaceState state;
  const FaceObservation* observation = nullptr;  // null: its landmarks are left out
};

struct PersonalShapeOptions {
  ShapeFieldOptions field;
  int rounds = 3;                  // each finds the terms again; cost is linear in it
  int frames = 40;                 // training frames used for contours; cost is linear in it
  double point_m = 0.004;          // in addition to a point's own covariance
  double contour_m = 0.003;        // of one edge: neighbouring ones err together
  double landmark_px = 2;          // of a landmark's mean over all frames
  double contour_reach_m = 0.005;  // in the first round; it halves until the last
  double max_m = 0.008;            // no offset is longer; beyond half of it they are shortened
  bool points = true, contours = true, landmarks = true;
};

// (V) offsets of the head at rest, m; empty if there is no evidence for any. identity: the head they are
// added to. No held-out frame takes part; the caller must keep `points` free of them.
Result<std::vector<Vec3f>> fit_personal_shape(const HeadModel& model, const Eigen::VectorXf& identity,
                                              std::span<const ShapePoint> points,
                                              std::span<const ShapeFrame> frames,
                                              const PersonalShapeOptions& options, const Progress& progress,
                                              std::stop_token stop);

}  // namespace likeness
