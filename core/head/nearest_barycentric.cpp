#include "core/head/nearest_barycentric.h"

#include <algorithm>
#include <limits>

#include "core/base/dense_solves.h"

namespace likeness {

Vec3d nearest_barycentric(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  Vec3d best(1, 0, 0);
  double best_distance = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Vec3d& w) {
    const double d = (w.x() * a + w.y() * b + w.z() * c - p).squaredNorm();
    if (d < best_distance) best_distance = d, best = w;
  };
  const auto edge = [&](const Vec3d& s, const Vec3d& t, int i, int j) {
    const double at = std::clamp((p - s).dot(t - s) / (t - s).squaredNorm(), 0.0, 1.0);
    Vec3d w = Vec3d::Zero();
    w[i] = 1 - at, w[j] = at;
    consider(w);
  };
  edge(a, b, 0, 1), edge(b, c, 1, 2), edge(c, a, 2, 0);
  Eigen::Matrix<double, 3, 2> e;
  e << b - a, c - a;
  const Vec2d st = solve_symmetric<2>(e.transpose() * e, e.transpose() * (p - a));
  if (st.x() >= 0 && st.y() >= 0 && st.sum() <= 1) consider({1 - st.sum(), st.x(), st.y()});
  return best;
}

}  // namespace likeness
