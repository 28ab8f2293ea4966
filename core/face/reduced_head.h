// The head model reduced to the few surface points that landmarks see: the 68 landmarks and, for the jaw
// line, the skin near it. Linear in identity and expression, plus the jaw's opening; with derivatives.
//
// Notation: point = (1 - w) s + w (R(jaw) (s - j) + j),  s = base + B identity + D expression + C vec(R(jaw)
// - I), w = skinning weight of the jaw, j = jaw joint (moves with the identity), C = the jaw's pose
// correctives, which come before the turn as in the whole head (core/head/pose_head.h). There the joint also
// moves with the expression; this is left out here.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"

namespace likeness {

inline constexpr int kJawLineCount = 17;  // landmarks 0..16

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct ReducedHead {
  int points = 0;              // N >= 68; the first 68 are the landmarks
  Eigen::VectorXd base;        // (3N) m
  RowMatrix identity;          // (3N, I)
  RowMatrix expression;        // (3N, E)
  RowMatrix jaw_corrective;    // (3N, 9) m per element of row-major R - I
  Eigen::VectorXd jaw_weight;  // (N)
  Vec3d jaw_joint = Vec3d::Zero();
  RowMatrix jaw_joint_identity;                         // (3, I)
  std::vector<Vec3d> normals;                           // (N) outward, of the template
  std::array<std::vector<int>, kJawLineCount> contour;  // points that may be jaw landmark i's silhouette

  int identity_count() const { return static_cast<int>(identity.cols()); }
  int expression_count() const { return static_cast<int>(expression.cols()); }
};

// max_identity: only the first so many identity directions are kept. offsets: (V) a personal shape that
// belongs to the base, m; or empty.
ReducedHead reduce_head(const HeadModel& model, int max_identity, std::span<const Vec3f> offsets = {});

// For a known person: their identity beyond the directions kept, and their offsets, become part of the base.
ReducedHead reduce_head(const HeadModel& model, int max_identity, const PersonShape& person);

// The reduced head of one person: identity applied.
struct ReducedPerson {
  Eigen::VectorXd base;  // (3N) m
  Vec3d jaw_joint = Vec3d::Zero();
};
ReducedPerson reduced_person(const ReducedHead& head, const Eigen::VectorXd& identity);

// The jaw turned by an angle, rad: R, d R / d jaw, C vec(R - I) and its derivative.
struct JawTurn {
  explicit JawTurn(double jaw);
  Mat3d turn, rate;
  Vec3d corrected(const ReducedHead& head, int point) const;       // m
  Vec3d corrected_rate(const ReducedHead& head, int point) const;  // m/rad
  double cosine, sine;
};

// One point in the head frame and, if requested, its derivatives.
struct PointDerivatives {
  Vec3d by_jaw;    // m/rad
  Mat3d by_shape;  // d point / d s: (1 - w) I + w R; expression's is by_shape * D
  Mat3d by_joint;  // d point / d j
};
Vec3d reduced_point(const ReducedHead& head, const ReducedPerson& person, int point,
                    const Eigen::VectorXd& expression, double jaw, PointDerivatives* derivatives = nullptr);

}  // namespace likeness
