// Fits head pose, expression and jaw of one frame to its 68 landmarks, the person's identity given.
//
// Landmarks are rays of the camera (x/z, y/z), so distortion and crop are already accounted for; errors are
// in working pixels, focal_px * (x/z, y/z). Robust (Huber), with quadratic one-sided penalties instead of
// hard bounds.
#pragma once

#include <array>
#include <vector>

#include "core/face/reduced_head.h"

namespace likeness {

// Height between the margins of an eye's lids, from the pixels (lids.h).
struct LidEvidence {
  bool known = false;
  double gap_m = 0, sigma_m = 1;
};

// Height between the inner edges of the lips, from the pixels (photometric_mouth.h).
struct LipEvidence {
  bool known = false;
  double gap_m = 0, sigma_m = 1;
};

struct FaceObservation {
  std::array<Vec2d, kLandmarkCount> rays;
  std::array<double, kLandmarkCount> sigma_px{};  // working px
  double focal_px = 1000;                         // of the working picture
  std::array<LidEvidence, 2> lids;                // subject's right eye, left
  LipEvidence lips;
};

struct FaceState {
  Pose cam_from_head = Pose::Identity();
  double jaw = 0;              // rad, opening
  Eigen::VectorXd expression;  // (E)
};

struct ExpressionPrior {
  Eigen::VectorXd weight;     // (E) residual per unit; shapes that landmarks hardly see weigh more
  Eigen::VectorXd rest;       // (E) origin for `weight` and pairs; the person's resting face (rest.h)
  Eigen::VectorXd low, high;  // (E) valid range of the expression
  Eigen::VectorXd change;     // (E) share of a pull's weight: faster shapes are pulled less
  std::vector<std::array<int, 2>> pairs;  // left and right half of a shape: faces mostly move both
  double pair_weight = 8;                 // per unit of difference between the halves
  double jaw_weight = 1.0;                // per rad
  double jaw_high = 0.5;                  // rad
};
ExpressionPrior expression_prior(const HeadModel& model);

// A quadratic pull of the frame's unknowns towards given values (temporal neighbours, dense poses); zero
// weight = none.
struct FramePull {
  double expression_weight = 0, jaw_weight = 0;
  Eigen::VectorXd expression;  // (E)
  double jaw = 0;
  double turn_weight = 0, shift_weight = 0;  // per rad, per m
  Pose cam_from_head = Pose::Identity();
};

// Which model point stands for each jaw landmark: the landmark itself where it faces the camera, else the
// silhouette.
struct JawLine {
  std::array<int, kJawLineCount> point;
  std::array<Vec2d, kJawLineCount> normal;  // in the picture, unit; errors along the line count less
};
JawLine pick_jaw_line(const ReducedHead& head, const ReducedPerson& person,
                      const FaceObservation& observation, const FaceState& state);

struct FrameFitOptions {
  bool free_pose = true, free_face = true;
  bool jaw_line = true;  // use landmarks 0..16
  int max_iterations = 12;
};

// Unknowns in this order: turn (3, left increment of the rotation), shift (3), jaw, expression (E), identity
// (I).
struct FrameSystem {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  double cost = 0;  // half the sum of squares, Huber-limited
};
// with_identity: the identity's columns are added (for the joint fit); its prior is not.
void frame_system(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
                  const JawLine& jaw_line, const ExpressionPrior& prior, const FramePull& pull,
                  const FrameFitOptions& options, const FaceState& state, bool with_identity,
                  FrameSystem* system);
double frame_cost(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
                  const JawLine& jaw_line, const ExpressionPrior& prior, const FramePull& pull,
                  const FrameFitOptions& options, const FaceState& state);
// state moved by an increment of the first 7 + E unknowns.
FaceState moved(const FaceState& state, const Eigen::VectorXd& increment);

// Levenberg-Marquardt from `guess`; the jaw line is picked once from the guess.
FaceState fit_frame(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
                    const ExpressionPrior& prior, const FramePull& pull, const FrameFitOptions& options,
                    const FaceState& guess);

// Pose alone from the inner landmarks, without a guess.
FaceState start_frame(const ReducedHead& head, const ReducedPerson& person,
                      const FaceObservation& observation, const ExpressionPrior& prior);

// Height between an eye's lids: mean over its two pairs of lid landmarks, along the head's y, m. The jaw
// does not move them.
double lid_gap(const ReducedHead& head, const ReducedPerson& person, int side,
               const Eigen::VectorXd& expression);

// Height between the lips: mean over the three inner pairs, along the head's y, m.
double lip_gap(const ReducedHead& head, const ReducedPerson& person, const FaceState& state);

// Mean distance of fitted to observed landmarks 17..67, working px.
double inner_error(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
                   const FaceState& state);

}  // namespace likeness
