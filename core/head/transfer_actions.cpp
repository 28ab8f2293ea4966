// Actions carried from one head to another: see transfer_actions.h.
#include "core/head/transfer_actions.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/align_points.h"
#include "core/base/dense_solves.h"
#include "core/base/parallel.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

using Points = Eigen::Matrix3Xd;

Points landmarks_of(const HeadModel& model) {
  const auto positions = landmark_positions(model, model.vertices);
  Points points(3, kLandmarkCount);
  for (int l = 0; l < kLandmarkCount; ++l) points.col(l) = positions[std::size_t(l)].cast<double>();
  return points;
}

struct Warp {
  Eigen::Matrix4d similarity = Eigen::Matrix4d::Identity();
  Points centres, weights;  // of the radial part, in source space

  Vec3d operator()(const Vec3d& p) const {
    Vec3d out = (similarity * p.homogeneous()).head<3>();
    for (Eigen::Index i = 0; i < centres.cols(); ++i) out += weights.col(i) * (p - centres.col(i)).norm();
    return out;
  }
};

// nullopt if the landmarks of the two heads do not correspond.
std::optional<Warp> fit_warp(const Points& from, const Points& to, double max_misfit) {
  Warp warp;
  warp.similarity = similarity_between(from, to);
  if (!warp.similarity.allFinite()) return std::nullopt;
  const Points moved = (warp.similarity * from.colwise().homogeneous()).topRows<3>();
  const Points centred = to.colwise() - to.rowwise().mean();
  const double size = std::sqrt(centred.squaredNorm() / double(to.cols()));
  const double misfit = std::sqrt((moved - to).squaredNorm() / double(to.cols()));
  if (!(misfit < max_misfit * size)) return std::nullopt;
  // Landmarks that coincide (closed lips) would make the system singular: a little smoothing keeps it
  // regular.
  Eigen::MatrixXd kernel(from.cols(), from.cols());
  for (Eigen::Index i = 0; i < from.cols(); ++i)
    for (Eigen::Index j = 0; j < from.cols(); ++j) kernel(i, j) = (from.col(i) - from.col(j)).norm();
  kernel.diagonal().array() -= 1e-3 * size;  // the kernel |x| is negative definite off its diagonal
  warp.centres = from;
  warp.weights = kernel.partialPivLu().solve((to - moved).transpose()).transpose();
  return warp.weights.allFinite() ? std::optional(warp) : std::nullopt;
}

struct Correspondence {
  int target = 0;   // vertex
  Triangle source;  // corners of the closest triangle
  Vec3f barycentric;
  float weight = 1;  // less if the surfaces are apart: teeth under a lip are not the lip
};

// Barycentric coordinates of the point of a triangle closest to p.
Vec3d closest_on_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(p - b), d4 = ac.dot(p - b);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const double d5 = ab.dot(p - c), d6 = ac.dot(p - c);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / (d4 - d3 + d5 - d6);
    return {0, 1 - t, t};
  }
  const double sum = va + vb + vc;
  return sum > 0 ? Vec3d(va / sum, vb / sum, vc / sum) : Vec3d(1, 0, 0);
}

constexpr double kApart = 0.002;  // m: surfaces this far apart count half

bool is_face(HeadPart part) { return part == HeadPart::face || part == HeadPart::unknown; }

// Closest points of the target's face vertices on the warped source's face. A grid over the source's
// triangles keeps the search short; a triangle lies in every cell its box touches, widened by the reach.
std::vector<Correspondence> correspond(const HeadModel& source, const HeadModel& target, const Warp& warp,
                                       double reach) {
  std::vector<Vec3d> warped(source.vertices.size());
  parallel_for(warped.size(), [&](std::size_t v) { warped[v] = warp(source.vertices[v].cast<double>()); });
  const std::vector<Vec3f> normals = vertex_normals(target.vertices, target.triangles);
  Vec3d low = Vec3d::Constant(1e9), high = Vec3d::Constant(-1e9);
  std::vector<int> faces;
  for (std::size_t t = 0; t < source.triangles.size(); ++t) {
    const Triangle& corners = source.triangles[t];
    bool face = true;
    for (int k = 0; k < 3; ++k)
      face = face && (source.parts.empty() || is_face(source.parts[std::size_t(corners[k])]));
    if (!face) continue;
    faces.push_back(int(t));
    for (int k = 0; k < 3; ++k) {
      low = low.cwiseMin(warped[std::size_t(corners[k])]);
      high = high.cwiseMax(warped[std::size_t(corners[k])]);
    }
  }
  if (faces.empty()) return {};
  constexpr int kCells = 24;
  const Vec3d cell = ((high - low) / kCells).cwiseMax(1e-6);
  const auto index_of = [&](const Vec3d& p) -> Eigen::Vector3i {
    return ((p - low).cwiseQuotient(cell)).cwiseMax(0).cwiseMin(kCells - 1).cast<int>();
  };
  std::vector<std::vector<int>> grid(kCells * kCells * kCells);
  const auto at = [&](int x, int y, int z) -> std::vector<int>& {
    return grid[std::size_t((z * kCells + y) * kCells + x)];
  };
  for (const int t : faces) {
    const Triangle& corners = source.triangles[std::size_t(t)];
    Vec3d least = Vec3d::Constant(1e9), most = Vec3d::Constant(-1e9);
    for (int k = 0; k < 3; ++k)
      least = least.cwiseMin(warped[std::size_t(corners[k])]),
      most = most.cwiseMax(warped[std::size_t(corners[k])]);
    const Eigen::Vector3i from = index_of(least - Vec3d::Constant(reach)),
                          to = index_of(most + Vec3d::Constant(reach));
    for (int z = from.z(); z <= to.z(); ++z)
      for (int y = from.y(); y <= to.y(); ++y)
        for (int x = from.x(); x <= to.x(); ++x) at(x, y, z).push_back(t);
  }

  std::vector<std::optional<Correspondence>> found(target.vertices.size());
  parallel_for(target.vertices.size(), [&](std::size_t v) {
    if (!target.parts.empty() && !is_face(target.parts[v])) return;
    const Vec3d p = target.vertices[v].cast<double>();
    const Eigen::Vector3i here = index_of(p);
    double best = reach;
    for (const int t : at(here.x(), here.y(), here.z())) {
      const Triangle& c = source.triangles[std::size_t(t)];
      const Vec3d &a = warped[std::size_t(c[0])], &b = warped[std::size_t(c[1])],
                  &d = warped[std::size_t(c[2])];
      // Upper and lower lip touch: only surfaces that face the same way are matched.
      if ((b - a).cross(d - a).dot(normals[v].cast<double>()) <= 0) continue;
      const Vec3d w = closest_on_triangle(p, a, b, d);
      const double distance = (w[0] * a + w[1] * b + w[2] * d - p).norm();
      if (distance >= best) continue;
      best = distance;
      found[v] = Correspondence{int(v), c, w.cast<float>(), float(1 / (1 + std::pow(distance / kApart, 2)))};
    }
  });
  std::vector<Correspondence> pairs;
  for (const auto& pair : found)
    if (pair) pairs.push_back(*pair);
  return pairs;
}

std::vector<Vec3f> motion_of(const HeadModel& model, const HeadShape& shape, const NamedAction& action) {
  Articulation articulation = neutral_articulation(model);
  add_action(articulation, action, 1);
  articulation.left_eye.setZero(), articulation.right_eye.setZero();
  std::vector<Vec3f> moved = pose_head(model, shape, articulation);
  for (std::size_t v = 0; v < moved.size(); ++v) moved[v] -= shape.vertices[v];
  return moved;
}

}  // namespace

std::vector<NamedAction> transfer_actions(const HeadModel& source, const HeadModel& target,
                                          const TransferOptions& options) {
  const auto warp = fit_warp(landmarks_of(source), landmarks_of(target), options.max_misfit);
  const int count = target.expression_count();
  if (!warp || count == 0) return {};
  const std::vector<Correspondence> pairs = correspond(source, target, *warp, options.reach);
  if (pairs.size() < 100) return {};

  // -- The target's expressions at the corresponding vertices
  const Eigen::Index rows = 3 * Eigen::Index(pairs.size());
  Eigen::MatrixXf basis(rows, count);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    basis.middleRows<3>(3 * Eigen::Index(i)) =
        pairs[i].weight * target.expression_basis.middleRows<3>(3 * pairs[i].target);
  Eigen::MatrixXd gram = (basis.transpose() * basis).cast<double>();
  gram.diagonal().array() += options.ridge * gram.trace() / count + 1e-12;
  const SymmetricFactor factor(gram);

  const HeadShape source_shape = shape_head(source, PersonShape{}),
                  target_shape = shape_head(target, PersonShape{});
  const Eigen::Matrix3f turn = warp->similarity.topLeftCorner<3, 3>().cast<float>();
  std::vector<NamedAction> actions;
  for (const NamedAction& action : source.actions) {
    // -- The target motion
    const std::vector<Vec3f> moved = motion_of(source, source_shape, action);
    Eigen::VectorXf wanted(rows);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto& [v, corners, w, weight] = pairs[i];
      wanted.segment<3>(3 * Eigen::Index(i)) =
          weight * turn *
          (w[0] * moved[std::size_t(corners[0])] + w[1] * moved[std::size_t(corners[1])] +
           w[2] * moved[std::size_t(corners[2])]);
    }
    const float size = wanted.norm();
    if (size == 0) continue;
    // -- The jaw's part of it, then the expressions' part of the rest
    NamedAction made;
    made.name = action.name;
    made.jaw = action.jaw;
    made.left_eye = action.left_eye, made.right_eye = action.right_eye;
    made.expression = Eigen::VectorXf::Zero(count);
    if (made.jaw.squaredNorm() > 0) {
      const std::vector<Vec3f> by_jaw = motion_of(target, target_shape, made);
      for (std::size_t i = 0; i < pairs.size(); ++i)
        wanted.segment<3>(3 * Eigen::Index(i)) -= pairs[i].weight * by_jaw[std::size_t(pairs[i].target)];
    }
    made.expression = factor.solve((basis.transpose() * wanted).cast<double>()).cast<float>();
    made.residual = (wanted - basis * made.expression).norm() / size;
    if (made.expression.allFinite() && made.residual < options.worst) actions.push_back(std::move(made));
  }
  return actions;
}

}  // namespace likeness
