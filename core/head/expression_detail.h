// Fine shape that comes and goes with the expression - creases beside a smile, a furrowed forehead - as a
// height along the normal of the posed head, on top of what the head model can represent. After DECA (Feng et
// al., SIGGRAPH 2021), whose detail displacement is decoded from expression and jaw; here the decoder is
// linear and learnt from one person's maps: a mean, a few components, and a ridge regression that predicts
// their amounts from expression and jaw.
//
//   height(a) = mean + basis * clamp(rows * ([expression (E), jaw (3)] of a - middle), low, high)
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"
#include "core/head/pose_head.h"

namespace likeness {

struct ExpressionDetail {
  std::vector<std::int32_t> vertices;  // (K) of the model: those ever displaced; ascending
  Eigen::VectorXf mean;                // (K) m, outwards
  Eigen::MatrixXf basis;               // (K, R) m per unit of a score; columns are orthogonal
  Eigen::VectorXf middle;              // (E + 3) expression and jaw about which it is linear
  Eigen::MatrixXf rows;                // (R, E + 3)
  Eigen::VectorXf low, high;           // (R) range of the maps' scores, never exceeded

  bool empty() const { return vertices.empty(); }
  int components() const { return int(basis.cols()); }
};

inline constexpr float kHighestDetail = 0.010f;  // m: no crease of a face is deeper

// (R) scores of an expression.
Eigen::VectorXf detail_scores(const ExpressionDetail& detail, const Articulation& articulation);

// Moves posed vertices of the head frame, m, along their normals by the heights of these scores.
void add_detail(const HeadModel& model, const ExpressionDetail& detail, const Eigen::VectorXf& scores,
                std::vector<Vec3f>& posed);

// pose_head with detail: from these scores or, if there are none, from those predicted for the articulation.
std::vector<Vec3f> pose_detailed_head(const HeadModel& model, const HeadShape& shape,
                                      const Articulation& articulation, const ExpressionDetail& detail,
                                      const Eigen::VectorXf& scores = {});

// Whether all sizes match each other and a model with this many vertices and expressions, and all numbers are
// finite.
bool is_consistent(const ExpressionDetail& detail, int vertices, int expressions);

// One frame's heights and what the face does in it.
struct DetailFrame {
  int frame = 0;           // number in the source video
  Eigen::VectorXf height;  // (V) m along the normal
  Articulation articulation;
};

struct DetailOptions {
  int max_components = 12;
  double share = 0.98;  // of the maps' variance about their mean; fewer components if they reach it
};

struct LearntDetail {
  ExpressionDetail detail;
  Eigen::MatrixXf scores;  // (F, R) of each frame's own map
  double kept = 0;         // share of the maps' variance about their mean that the components explain
  // Share of it that expression and jaw explain for held-out blocks of neighbouring frames; below zero: worse
  // than the mean.
  double explained = 0;
  double ridge = 0;  // chosen so that the latter is best
};

// frames: at least 10, of training pictures only, in order of time. If nothing learnt predicts held-out
// frames (explained <= 0), rows are zero: a new expression gets the mean. Deterministic.
LearntDetail learn_detail(const std::vector<DetailFrame>& frames, const DetailOptions& options = {});

}  // namespace likeness
