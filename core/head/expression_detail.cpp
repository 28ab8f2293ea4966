// Principal components of the heights, and a ridge regression on expression and jaw: see expression_detail.h.
#include "core/head/expression_detail.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/dense_solves.h"

namespace likeness {
namespace {

constexpr float kStill = 2e-5f;  // m; vertices that no map moves further are left out
constexpr int kBlocks = 5;       // of neighbouring frames, each held out once
constexpr double kRidges[] = {1e-4, 1e-3, 1e-2, 1e-1, 1, 10, 100};  // times the inputs' mean square
constexpr double kSmallest = 1e-14;                                 // m^2; less is rounding

Eigen::VectorXd detail_inputs(const Articulation& a) {
  Eigen::VectorXd x(a.expression.size() + 3);
  x << a.expression.cast<double>(), a.jaw.cast<double>();
  return x;
}

// W of min |X W - S|^2 + ridge |W|^2. (inputs, scores)
Eigen::MatrixXd regress(const Eigen::MatrixXd& x, const Eigen::MatrixXd& s, double ridge) {
  Eigen::MatrixXd normal = x.transpose() * x;
  normal.diagonal().array() += ridge;
  return solve_symmetric_columns(normal, x.transpose() * s);
}

// Squared error of the scores of blocks held out from the regression, about the means of the others.
double unseen_error(const Eigen::MatrixXd& x, const Eigen::MatrixXd& s, double ridge) {
  const Eigen::Index n = x.rows();
  double sum = 0;
  for (Eigen::Index b = 0; b < kBlocks; ++b) {
    const Eigen::Index first = b * n / kBlocks, count = (b + 1) * n / kBlocks - first, rest = n - count;
    Eigen::MatrixXd seen(rest, x.cols()), wanted(rest, s.cols());
    seen << x.topRows(first), x.bottomRows(rest - first);
    wanted << s.topRows(first), s.bottomRows(rest - first);
    const Eigen::RowVectorXd middle = seen.colwise().mean(), mean = wanted.colwise().mean();
    const Eigen::MatrixXd w =
        regress(seen.rowwise() - middle, wanted.rowwise() - mean, ridge * double(rest) / double(n));
    const Eigen::MatrixXd found = ((x.middleRows(first, count).rowwise() - middle) * w).rowwise() + mean;
    sum += (found - s.middleRows(first, count)).squaredNorm();
  }
  return sum;
}

}  // namespace

Eigen::VectorXf detail_scores(const ExpressionDetail& detail, const Articulation& articulation) {
  LIKENESS_CHECK(articulation.expression.size() + 3 == detail.middle.size(),
                 "detail of %d expressions for a face of %d", int(detail.middle.size()) - 3,
                 int(articulation.expression.size()));
  Eigen::VectorXf x(detail.middle.size());
  x << articulation.expression, articulation.jaw;
  return (detail.rows * (x - detail.middle)).cwiseMax(detail.low).cwiseMin(detail.high);
}

void add_detail(const HeadModel& model, const ExpressionDetail& detail, const Eigen::VectorXf& scores,
                std::vector<Vec3f>& posed) {
  if (detail.empty()) return;
  LIKENESS_CHECK(scores.size() == detail.basis.cols(), "%d scores for %d components", int(scores.size()),
                 detail.components());
  const Eigen::VectorXf height =
      (detail.mean + detail.basis * scores).cwiseMax(-kHighestDetail).cwiseMin(kHighestDetail);
  const std::vector<Vec3f> normals = vertex_normals(posed, model.triangles);
  for (std::size_t k = 0; k < detail.vertices.size(); ++k) {
    const auto v = std::size_t(detail.vertices[k]);
    posed[v] += height[Eigen::Index(k)] * normals[v];
  }
}

std::vector<Vec3f> pose_detailed_head(const HeadModel& model, const HeadShape& shape,
                                      const Articulation& articulation, const ExpressionDetail& detail,
                                      const Eigen::VectorXf& scores) {
  std::vector<Vec3f> posed = pose_head(model, shape, articulation);
  if (!detail.empty())
    add_detail(model, detail, scores.size() > 0 ? scores : detail_scores(detail, articulation), posed);
  return posed;
}

bool is_consistent(const ExpressionDetail& d, int vertices, int expressions) {
  const auto k = Eigen::Index(d.vertices.size()), r = d.basis.cols(), inputs = Eigen::Index(expressions) + 3;
  const bool sizes = d.mean.size() == k && d.basis.rows() == k && d.rows.rows() == r &&
                     d.rows.cols() == inputs && d.middle.size() == inputs && d.low.size() == r &&
                     d.high.size() == r;
  if (!sizes) return false;
  const bool numbers = d.mean.allFinite() && d.basis.allFinite() && d.rows.allFinite() &&
                       d.middle.allFinite() && d.low.allFinite() && d.high.allFinite();
  return numbers && (d.low.array() <= d.high.array()).all() &&
         std::ranges::all_of(d.vertices, [&](int v) { return v >= 0 && v < vertices; });
}

LearntDetail learn_detail(const std::vector<DetailFrame>& frames, const DetailOptions& options) {
  LIKENESS_CHECK(frames.size() >= 10, "detail from %zu frames", frames.size());
  const auto n = Eigen::Index(frames.size());
  LearntDetail learnt;
  ExpressionDetail& detail = learnt.detail;

  // -- The vertices that move, and their heights.
  Eigen::VectorXf most = Eigen::VectorXf::Zero(frames.front().height.size());
  for (const DetailFrame& f : frames) most = most.cwiseMax(f.height.cwiseAbs());
  for (Eigen::Index v = 0; v < most.size(); ++v)
    if (most[v] > kStill) detail.vertices.push_back(std::int32_t(v));
  if (detail.empty()) {  // flat maps
    const Eigen::VectorXd x = detail_inputs(frames.front().articulation);
    detail.middle = Eigen::VectorXf::Zero(x.size());
    detail.rows.resize(0, x.size()), detail.basis.resize(0, 0);
    learnt.scores.resize(n, 0);
    return learnt;
  }
  const auto count = Eigen::Index(detail.vertices.size());
  Eigen::MatrixXd height(n, count), x(n, detail_inputs(frames.front().articulation).size());
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < count; ++k)
      height(i, k) = double(frames[std::size_t(i)].height[detail.vertices[std::size_t(k)]]);
    x.row(i) = detail_inputs(frames[std::size_t(i)].articulation).transpose();
  }
  const Eigen::RowVectorXd mean = height.colwise().mean(), middle = x.colwise().mean();
  height.rowwise() -= mean, x.rowwise() -= middle;
  detail.mean = mean.transpose().cast<float>(), detail.middle = middle.transpose().cast<float>();

  // -- Components, by the frames' inner products: there are fewer frames than vertices.
  const SymmetricEigen spectrum = eigen_of_symmetric(height * height.transpose());
  const double total = height.squaredNorm();
  Eigen::Index r = 0;
  double held = 0;
  while (r < std::min<Eigen::Index>(options.max_components, n - 1) && held < options.share * total &&
         spectrum.values[n - 1 - r] > kSmallest)
    held += spectrum.values[n - 1 - r++];
  learnt.kept = total > 0 ? held / total : 1;
  Eigen::MatrixXd scores(n, r), basis(count, r);
  for (Eigen::Index c = 0; c < r; ++c) {
    // A score's mean square is 1, so that ridge and bounds mean the same for all.
    scores.col(c) = spectrum.vectors.col(n - 1 - c) * std::sqrt(double(n));
    basis.col(c) = height.transpose() * spectrum.vectors.col(n - 1 - c) / std::sqrt(double(n));
    // Eigenvectors have no sign of their own.
    if (basis.col(c).sum() < 0) scores.col(c) = -scores.col(c), basis.col(c) = -basis.col(c);
  }
  detail.basis = basis.cast<float>(), learnt.scores = scores.cast<float>();
  detail.low = learnt.scores.colwise().minCoeff(), detail.high = learnt.scores.colwise().maxCoeff();

  // -- What expression and jaw explain of them, weighted as on the surface.
  const Eigen::RowVectorXd weight = basis.colwise().norm();
  const Eigen::MatrixXd weighted = scores * weight.asDiagonal();
  const double unit = std::max(1e-12, x.squaredNorm() / double(x.cols()));
  double best = weighted.squaredNorm();  // of the mean alone
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(x.cols(), r);
  for (const double ridge : kRidges) {
    const double error = unseen_error(x, weighted, ridge * unit);
    if (!(error < best)) continue;
    best = error, learnt.ridge = ridge;
    w = regress(x, scores, ridge * unit);
  }
  learnt.explained = total > 0 ? (weighted.squaredNorm() - best) / total : 0;
  detail.rows = w.transpose().cast<float>();
  return learnt;
}

}  // namespace likeness
