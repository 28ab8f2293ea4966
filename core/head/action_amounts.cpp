// Least squares on the surface: see action_amounts.h.
#include "core/head/action_amounts.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/dense_solves.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

constexpr double kRidge = 1e-6;    // of each action's own squared motion
constexpr double kTie = 1e-3;      // of the mean shape's squared motion, per unit of coefficient
constexpr float kJawStep = 0.05f;  // rad

// (3V, 3) motion per radian of the jaw at rest.
Eigen::MatrixXf jaw_motion(const HeadModel& model) {
  const HeadShape shape = shape_head(model, Eigen::VectorXf());
  Articulation articulation = neutral_articulation(model);
  Eigen::MatrixXf motion(3 * model.vertex_count(), 3);
  for (int axis = 0; axis < 3; ++axis) {
    articulation.jaw = kJawStep * Vec3f::Unit(axis);
    const std::vector<Vec3f> posed = pose_head(model, shape, articulation);
    for (int v = 0; v < model.vertex_count(); ++v)
      motion.col(axis).segment<3>(3 * v) =
          (posed[std::size_t(v)] - shape.vertices[std::size_t(v)]) / kJawStep;
  }
  return motion;
}

Eigen::VectorXf face_vector(const Vec3f& jaw, const Eigen::VectorXf& expression) {
  Eigen::VectorXf v(expression.size() + 3);
  v << expression, jaw;
  return v;
}

}  // namespace

Eigen::MatrixXf face_metric(const HeadModel& model) {
  const Eigen::Index e = model.expression_count();
  const Eigen::MatrixXf jaw = jaw_motion(model);
  Eigen::MatrixXf metric(e + 3, e + 3);
  metric.topLeftCorner(e, e) = model.expression_basis.transpose() * model.expression_basis;
  metric.topRightCorner(e, 3) = model.expression_basis.transpose() * jaw;
  metric.bottomLeftCorner(3, e) = metric.topRightCorner(e, 3).transpose();
  metric.bottomRightCorner(3, 3) = jaw.transpose() * jaw;
  return metric;
}

ActionBasis action_basis(const HeadModel& model) {
  ActionBasis basis;
  basis.actions = model.actions;
  const Eigen::Index e = model.expression_count(), count = Eigen::Index(model.actions.size());
  basis.amounts_from_face = Eigen::MatrixXf::Zero(count, e + 3);
  if (count == 0) return basis;
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(e + 3, count);
  for (Eigen::Index a = 0; a < count; ++a) {
    const NamedAction& action = model.actions[std::size_t(a)];
    if (action.expression.size() == e) coefficients.col(a).head(e) = action.expression.cast<double>();
    coefficients.col(a).tail<3>() = action.jaw.cast<double>();
  }
  Eigen::MatrixXd metric = face_metric(model).cast<double>();
  // Two shapes that undo each other (the mouth to the left and to the right) are distinguished by their
  // names.
  if (e > 0) {
    const double mean = metric.diagonal().head(e).mean();
    metric.diagonal().head(e).array() += kTie * mean;
  }
  Eigen::MatrixXd normal = coefficients.transpose() * metric * coefficients;
  const double largest = normal.diagonal().maxCoeff();
  // An action that moves no vertex (eyeballs only) gets the amount zero.
  for (Eigen::Index a = 0; a < count; ++a) normal(a, a) += kRidge * normal(a, a) + 1e-9 * largest + 1e-30;
  basis.amounts_from_face = solve_symmetric_columns(normal, coefficients.transpose() * metric).cast<float>();
  return basis;
}

Eigen::VectorXf face_amounts(const ActionBasis& basis, const Articulation& articulation) {
  LIKENESS_CHECK(basis.amounts_from_face.cols() == articulation.expression.size() + 3 ||
                     basis.amounts_from_face.rows() == 0,
                 "%d expressions for actions of %d", int(articulation.expression.size()),
                 int(basis.amounts_from_face.cols()) - 3);
  if (basis.amounts_from_face.rows() == 0) return {};
  return basis.amounts_from_face * face_vector(articulation.jaw, articulation.expression);
}

Eigen::VectorXf action_amounts(const ActionBasis& basis, const Articulation& articulation) {
  Eigen::VectorXf amounts = face_amounts(basis, articulation);
  for (Eigen::Index a = 0; a < amounts.size(); ++a) {
    const NamedAction& action = basis.actions[std::size_t(a)];
    const float size = action.left_eye.squaredNorm() + action.right_eye.squaredNorm();
    if (size > 0)
      amounts[a] = std::max(
          0.0f,
          (action.left_eye.dot(articulation.left_eye) + action.right_eye.dot(articulation.right_eye)) / size);
  }
  return amounts;
}

int action_index(const ActionBasis& basis, std::string_view name) {
  const auto found =
      std::ranges::find_if(basis.actions, [&](const NamedAction& action) { return action.name == name; });
  return found == basis.actions.end() ? -1 : int(found - basis.actions.begin());
}

}  // namespace likeness
