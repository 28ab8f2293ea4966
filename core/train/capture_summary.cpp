// Medians, medoid and percentiles over the views of a training set.
#include "core/train/capture_summary.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

namespace likeness {
namespace {

constexpr double kMetresPerRadian = 0.17;

float quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(share * double(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Articulation typical_articulation(const TrainingSet& set) {
  Articulation typical = neutral_articulation(set.model);
  const Eigen::Index e = typical.expression.size();
  std::vector<float> values(set.views.size());
  for (Eigen::Index i = 0; i < e + 9; ++i) {
    for (std::size_t v = 0; v < values.size(); ++v)
      values[v] = articulation_vector(set.views[v].articulation)[i];
    const float median = quantile(values, 0.5);
    if (i < e)
      typical.expression[i] = median;
    else if (i < e + 3)
      typical.jaw[i - e] = median;
    else if (i < e + 6)
      typical.left_eye[i - e - 3] = median;
    else
      typical.right_eye[i - e - 6] = median;
  }
  return typical;
}

std::size_t typical_view(const TrainingSet& set) {
  const std::size_t count = set.views.size(), stride = std::max<std::size_t>(1, count / 200);
  std::vector<Pose> poses(count);
  for (std::size_t v = 0; v < count; ++v)
    poses[v] = set.views[v].camera.cam_from_world * set.views[v].world_from_head;
  double best = std::numeric_limits<double>::infinity();
  std::size_t chosen = 0;
  for (std::size_t v = 0; v < count; v += stride) {
    double sum = 0;
    for (std::size_t w = 0; w < count; w += stride) {
      const Pose difference = poses[v].inverse() * poses[w];
      sum +=
          difference.translation().norm() + kMetresPerRadian * Eigen::AngleAxisd(difference.linear()).angle();
    }
    if (sum < best) best = sum, chosen = v;
  }
  return chosen;
}

std::vector<ActionRange> action_ranges(const TrainingSet& set) {
  const Eigen::Index e = set.model.expression_count(), actions = Eigen::Index(set.model.actions.size());
  if (actions == 0) return {};
  // The jaw counts by the motion it causes: one radian moves the chin by about 0.1 m, an expression by about
  // 0.01 m.
  constexpr float kJawWeight = 10;
  Eigen::MatrixXf basis = Eigen::MatrixXf::Zero(e + 3, actions);
  for (Eigen::Index a = 0; a < actions; ++a) {
    const NamedAction& action = set.model.actions[std::size_t(a)];
    if (action.expression.size() == e) basis.col(a).head(e) = action.expression;
    basis.col(a).tail<3>() = kJawWeight * action.jaw;
  }
  const Eigen::MatrixXf normal =
      basis.transpose() * basis + 1e-3f * Eigen::MatrixXf::Identity(actions, actions);
  const Eigen::LDLT<Eigen::MatrixXf> solver(normal);
  std::vector<std::vector<float>> values(std::size_t(actions), std::vector<float>(set.views.size()));
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    Eigen::VectorXf x(e + 3);
    x << set.views[v].articulation.expression, kJawWeight * set.views[v].articulation.jaw;
    const Eigen::VectorXf amount = solver.solve(basis.transpose() * x);
    for (Eigen::Index a = 0; a < actions; ++a) values[std::size_t(a)][v] = amount[a];
  }
  std::vector<ActionRange> ranges;
  for (Eigen::Index a = 0; a < actions; ++a)
    ranges.push_back({set.model.actions[std::size_t(a)].name, quantile(values[std::size_t(a)], 0.02),
                      quantile(values[std::size_t(a)], 0.98)});
  return ranges;
}

}  // namespace likeness
