// Principal components of the training track's articulations in the metric of vertex motion.
#include "core/train/condition_map.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/dense_solves.h"

namespace likeness {
namespace {

constexpr double kFirstDeviation = 0.5;
constexpr double kSmallestMotion = 1e-5;  // m, rms over the face's vertices
constexpr double kGazeScale = 1.5;        // psi per rad
constexpr float kBeyond = 0.1f;

bool shows_expression(HeadPart part) {
  return part == HeadPart::face || part == HeadPart::teeth || part == HeadPart::gums_tongue ||
         part == HeadPart::unknown;
}

// Motion of the face's vertices per unit of each expression and jaw coefficient, over sqrt(vertices), m.
Eigen::MatrixXf motion_basis(const HeadModel& model, const HeadShape& shape) {
  std::vector<int> vertices;
  for (int v = 0; v < model.vertex_count(); ++v)
    if (model.parts.empty() || shows_expression(model.parts[std::size_t(v)])) vertices.push_back(v);
  const int e = model.expression_count();
  Eigen::MatrixXf basis = Eigen::MatrixXf::Zero(Eigen::Index(3 * vertices.size()), e + 3);
  const Articulation neutral = neutral_articulation(model);
  const std::vector<Vec3f> rest = pose_head(model, shape, neutral);
  constexpr float kJawStep = 0.1f;
  for (int axis = 0; axis < 3; ++axis) {
    Articulation opened = neutral;
    opened.jaw[axis] += kJawStep;
    const std::vector<Vec3f> posed = pose_head(model, shape, opened);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      basis.block<3, 1>(Eigen::Index(3 * i), e + axis) =
          (posed[std::size_t(vertices[i])] - rest[std::size_t(vertices[i])]) / kJawStep;
  }
  for (std::size_t i = 0; i < vertices.size(); ++i)
    basis.block(Eigen::Index(3 * i), 0, 3, e) = model.expression_basis.middleRows(3 * vertices[i], 3);
  return basis / std::sqrt(float(std::max<std::size_t>(vertices.size(), 1)));
}

// (articulations, E + 9), without its mean.
Eigen::MatrixXd centred(const HeadModel& model, std::span<const Articulation> articulations,
                        Eigen::VectorXd& mean) {
  const Eigen::Index e = model.expression_count(), n = e + 9;
  Eigen::MatrixXd data(Eigen::Index(articulations.size()), n);
  for (std::size_t i = 0; i < articulations.size(); ++i) {
    LIKENESS_CHECK(articulations[i].expression.size() == e, "%ld expressions for a model of %ld",
                   long(articulations[i].expression.size()), long(e));
    data.row(Eigen::Index(i)) = articulation_vector(articulations[i]).cast<double>().transpose();
  }
  mean = articulations.empty() ? Eigen::VectorXd::Zero(n) : Eigen::VectorXd(data.colwise().mean());
  data.rowwise() -= mean.transpose();
  return data;
}

// Rotations about the eyes' x (axis 0: up and down) or y (1: left and right), rms, rad.
double gaze_deviation(const Eigen::MatrixXd& data, Eigen::Index e, int axis) {
  const Eigen::VectorXd gaze = 0.5 * (data.col(e + 3 + axis) + data.col(e + 6 + axis));
  return std::sqrt(gaze.squaredNorm() / std::max<double>(1, double(gaze.size())));
}

}  // namespace

ConditionMap learn_condition_map(const HeadModel& model, const HeadShape& shape,
                                 std::span<const Articulation> articulations,
                                 const ConditionOptions& options) {
  const Eigen::Index e = model.expression_count(), n = e + 9, m = e + 3;
  Eigen::VectorXd mean;
  const Eigen::MatrixXd data = centred(model, articulations, mean);

  // -- metric = B^T B; its square root S turns coefficients into metres of rms motion.
  const Eigen::MatrixXd basis = motion_basis(model, shape).cast<double>();
  const SymmetricEigen metric = eigen_of_symmetric(basis.transpose() * basis);
  const Eigen::MatrixXd root =
      metric.vectors * metric.values.cwiseMax(0).cwiseSqrt().asDiagonal() * metric.vectors.transpose();
  const Eigen::MatrixXd motion = data.leftCols(m) * root;
  const SymmetricEigen components =
      eigen_of_symmetric(motion.transpose() * motion / std::max<double>(1, double(data.rows())));
  std::vector<Eigen::VectorXd> rows;
  const double first = std::sqrt(std::max(0.0, components.values[m - 1]));
  for (Eigen::Index k = m - 1; k >= 0 && int(rows.size()) < options.components; --k) {
    if (std::sqrt(std::max(0.0, components.values[k])) < kSmallestMotion) break;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    row.head(m) = root * components.vectors.col(k) * (kFirstDeviation / first);
    if (row.sum() < 0) row = -row;  // a component's sign is arbitrary: fix it
    rows.push_back(row);
  }
  // -- Gaze: rotations about the eyes' x (up and down) and y (left and right).
  for (int axis = 0; options.gaze && axis < 2; ++axis) {
    if (gaze_deviation(data, e, axis) < kSmallestGaze) continue;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    row[e + 3 + axis] = row[e + 6 + axis] = 0.5 * kGazeScale;
    rows.push_back(row);
  }
  ConditionMap map;
  map.mean = mean.cast<float>();
  map.rows.resize(Eigen::Index(rows.size()), n);
  for (std::size_t k = 0; k < rows.size(); ++k)
    map.rows.row(Eigen::Index(k)) = rows[k].cast<float>().transpose();
  // -- Bounds: the extremes seen, and a tenth of their distance more.
  const Eigen::MatrixXf psi = data.cast<float>() * map.rows.transpose();
  map.low = map.high = Eigen::VectorXf::Zero(map.rows.rows());
  if (psi.rows() > 0 && psi.cols() > 0) {
    const Eigen::VectorXf least = psi.colwise().minCoeff(), most = psi.colwise().maxCoeff();
    map.low = least - kBeyond * (most - least);
    map.high = most + kBeyond * (most - least);
  }
  return map;
}

ArticulationSpread articulation_spread(const HeadModel& model, const HeadShape& shape,
                                       std::span<const Articulation> articulations) {
  if (articulations.empty()) return {};
  const Eigen::Index e = model.expression_count();
  Eigen::VectorXd mean;
  const Eigen::MatrixXd data = centred(model, articulations, mean);
  const Eigen::MatrixXd basis = motion_basis(model, shape).cast<double>();
  const Eigen::MatrixXd motion = data.leftCols(e + 3) * (basis.transpose() * basis);
  const double squares = motion.cwiseProduct(data.leftCols(e + 3)).sum();
  return {std::sqrt(std::max(0.0, squares) / double(data.rows())), gaze_deviation(data, e, 0),
          gaze_deviation(data, e, 1)};
}

}  // namespace likeness
