// Rows and columns of the built-in head's chart: dense on the face, sparse elsewhere.
#include "core/head/builtin_chart.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/head/builtin_sculpt.h"

namespace likeness::builtin {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct RowNode {
  double row, origin_y, origin_z, front_deg, back_deg;
};
// Where the rays of some rows start and how they tilt; a natural cubic spline fills in the others. Rays point
// down over the lower face so that the underside of the nose and of the chin are seen from within.
constexpr std::array<RowNode, 11> kNodes{{{0, 48, 10, 90, 90},
                                          {9, 45, 10, 41, 44},
                                          {19, 42, 10, 9, 10},
                                          {37, 40, 10, -18, -14},
                                          {44, 36, 10, -25, -19},
                                          {52, 31, 10, -32.5, -24},
                                          {62, 25, 10, -46, -30},
                                          {67, 6, 9, -52, -30},
                                          {71, -25, 5, -51, -27},
                                          {76, -85, -5, -38, -18},
                                          {79, -112, -9, -27, -10}}};

// Target distance between rows, mm, at a node's row number; rows crowd at the nose's underside and the lips.
constexpr std::array<Vec2d::Scalar, 11> kSpacing{11, 8, 4.6, 3.5, 1.8, 3.4, 4.0, 5.0, 6.5, 8.0, 8.5};

// Natural cubic spline through (x, y) at the whole numbers x.front() .. x.back().
std::vector<double> spline_at_integers(const std::vector<double>& x, const std::vector<double>& y) {
  const int n = int(x.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  a(0, 0) = a(n - 1, n - 1) = 1;
  for (int i = 1; i + 1 < n; ++i) {
    const double h0 = x[i] - x[i - 1], h1 = x[i + 1] - x[i];
    a(i, i - 1) = h0, a(i, i) = 2 * (h0 + h1), a(i, i + 1) = h1;
    b(i) = 6 * ((y[i + 1] - y[i]) / h1 - (y[i] - y[i - 1]) / h0);
  }
  const Eigen::VectorXd m = a.partialPivLu().solve(b);
  std::vector<double> values;
  int k = 0;
  for (int row = int(x.front()); row <= int(x.back()); ++row) {
    while (k + 2 < n && row > x[k + 1]) ++k;
    const double h = x[k + 1] - x[k], u = x[k + 1] - row, v = row - x[k];
    values.push_back((m[k] * u * u * u + m[k + 1] * v * v * v) / (6 * h) + (y[k] / h - m[k] * h / 6) * u +
                     (y[k + 1] / h - m[k + 1] * h / 6) * v);
  }
  return values;
}

double sample(const std::vector<double>& values, double at) {
  const double clamped = std::clamp(at, 0.0, double(values.size() - 1));
  const int i = std::min(int(clamped), int(values.size()) - 2);
  return mix(values[i], values[i + 1], clamped - i);
}

double elevation(const Chart& chart, double row, double azimuth) {
  const double back = smoothstep(60 * kDegree, 150 * kDegree, azimuth);
  return mix(sample(chart.front_elevation, row), sample(chart.back_elevation, row), back);
}

}  // namespace

Chart make_chart() {
  Chart chart;
  // Column widths grow smoothly from the nose to the back.
  std::vector<double> edges{0};
  while (edges.back() < 180) {
    const double a = edges.back();
    edges.push_back(a + 1.25 + 1.15 * smoothstep(9, 24, a) + 2.4 * smoothstep(40, 85, a) +
                    4.6 * smoothstep(85, 125, a));
  }
  for (double edge : edges) chart.azimuth.push_back(edge * std::numbers::pi / edges.back());
  chart.azimuth.back() = std::numbers::pi;

  std::vector<double> row, y, z, front, back, spacing;
  for (std::size_t i = 0; i < kNodes.size(); ++i) {
    const RowNode& node = kNodes[i];
    row.push_back(node.row), y.push_back(node.origin_y), z.push_back(node.origin_z);
    front.push_back(node.front_deg * kDegree), back.push_back(node.back_deg * kDegree);
    spacing.push_back(kSpacing[i]);
  }
  Chart raw = chart;
  raw.origin_y = spline_at_integers(row, y);
  raw.origin_z = spline_at_integers(row, z);
  raw.front_elevation = spline_at_integers(row, front);
  raw.back_elevation = spline_at_integers(row, back);
  const std::vector<double> wanted = spline_at_integers(row, spacing);

  // Number of rows of the target spacing above each quarter of a raw row, measured on the front and the
  // cheek.
  constexpr int kFine = 4;
  const double cheek = chart_of(raw, frontal_hit(48, 0)).x();
  std::vector<double> above{0};
  Vec3d last_front = skin_at(raw, {0, 0}), last_cheek = last_front;
  for (int i = 1; i <= kFine * (raw.rows() - 1); ++i) {
    const double at = double(i) / kFine;
    const Vec3d on_front = skin_at(raw, {0, at}), on_cheek = skin_at(raw, {cheek, at});
    const double length = 0.5 * ((on_front - last_front).norm() + (on_cheek - last_cheek).norm());
    above.push_back(above.back() + length / sample(wanted, at));
    last_front = on_front, last_cheek = on_cheek;
  }
  // Even out the staircase that the nose leaves in the spacing.
  for (int pass = 0; pass < 60; ++pass)
    for (std::size_t i = 1; i + 1 < above.size(); ++i)
      above[i] = 0.5 * above[i] + 0.25 * (above[i - 1] + above[i + 1]);
  const int rows = int(std::lround(above.back()));
  std::size_t i = 0;
  for (int r = 0; r <= rows; ++r) {
    const double target = above.back() * r / rows;
    while (i + 2 < above.size() && above[i + 1] < target) ++i;
    const double at = (i + (target - above[i]) / (above[i + 1] - above[i])) / kFine;
    chart.origin_y.push_back(sample(raw.origin_y, at));
    chart.origin_z.push_back(sample(raw.origin_z, at));
    chart.front_elevation.push_back(sample(raw.front_elevation, at));
    chart.back_elevation.push_back(sample(raw.back_elevation, at));
  }
  return chart;
}

Vec3d skin_at(const Chart& chart, const Vec2d& at) {
  const double azimuth = sample(chart.azimuth, at.x());
  const double e = elevation(chart, at.y(), azimuth);
  const Vec3d origin(0, sample(chart.origin_y, at.y()), sample(chart.origin_z, at.y()));
  const Vec3d direction(std::sin(azimuth) * std::cos(e), std::sin(e), std::cos(azimuth) * std::cos(e));
  return outermost_hit(origin, direction, 200);
}

Vec2d chart_of(const Chart& chart, const Vec3d& point) {
  // How far the point lies below the ray of a row, as an angle; monotone in the row.
  const auto below = [&](double row) {
    const double dx = point.x(), dz = point.z() - sample(chart.origin_z, row);
    const double azimuth = std::atan2(dx, dz);
    const double e = std::atan2(point.y() - sample(chart.origin_y, row), std::hypot(dx, dz));
    return elevation(chart, row, azimuth) - e;
  };
  double low = 0, high = chart.rows() - 1;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (below(middle) > 0 ? low : high) = middle;
  }
  const double row = 0.5 * (low + high);
  const double azimuth = std::atan2(point.x(), point.z() - sample(chart.origin_z, row));
  const auto next = std::upper_bound(chart.azimuth.begin(), chart.azimuth.end(), azimuth);
  const int i = std::clamp(int(next - chart.azimuth.begin()) - 1, 0, chart.columns() - 2);
  return {i + (azimuth - chart.azimuth[i]) / (chart.azimuth[i + 1] - chart.azimuth[i]), row};
}

}  // namespace likeness::builtin
