#include "core/face/reduced_head.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

constexpr double kContourReach =
    0.045;                              // m, how far along the surface a landmark may slide to the silhouette
constexpr double kContourBand = 0.028;  // m, skin further away does not count as jaw line
constexpr double kContourBelow = 0.010;    // m, below the jaw line the neck begins
constexpr std::size_t kContourLimit = 90;  // points per landmark; thinned evenly above that

double segment_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d d = b - a;
  const double t = std::clamp((p - a).dot(d) / std::max(1e-12, d.squaredNorm()), 0.0, 1.0);
  return (p - a - t * d).norm();
}

// Vertices near jaw landmark i and near the jaw line, not below it.
std::vector<int> contour_vertices(const HeadModel& model, const std::vector<Vec3d>& jaw_line, int landmark) {
  std::vector<int> found;
  for (int v = 0; v < model.vertex_count(); ++v) {
    const HeadPart part = model.parts.empty() ? HeadPart::unknown : model.parts[v];
    if (part != HeadPart::face && part != HeadPart::scalp_neck && part != HeadPart::unknown) continue;
    const Vec3d p = model.vertices[v].cast<double>();
    if ((p - jaw_line[landmark]).norm() > kContourReach || p.y() < jaw_line[landmark].y() - kContourBelow)
      continue;
    double nearest = 1e9;
    for (std::size_t k = 0; k + 1 < jaw_line.size(); ++k)
      nearest = std::min(nearest, segment_distance(p, jaw_line[k], jaw_line[k + 1]));
    if (nearest < kContourBand) found.push_back(v);
  }
  if (found.size() > kContourLimit) {
    std::vector<int> thinned;
    for (std::size_t k = 0; k < kContourLimit; ++k)
      thinned.push_back(found[k * found.size() / kContourLimit]);
    found = std::move(thinned);
  }
  return found;
}

}  // namespace

ReducedHead reduce_head(const HeadModel& model, int max_identity, std::span<const Vec3f> offsets) {
  LIKENESS_CHECK(model.vertex_count() > 0 && !model.triangles.empty(), "an empty head model");
  const int identities = std::min(max_identity, model.identity_count());
  const int expressions = model.expression_count();
  LIKENESS_CHECK(offsets.empty() || offsets.size() == model.vertices.size(), "%d offsets for %d vertices",
                 static_cast<int>(offsets.size()), model.vertex_count());
  const auto place = [&](int v) {
    return (offsets.empty() ? model.vertices[v] : Vec3f(model.vertices[v] + offsets[v]))
        .cast<double>()
        .eval();
  };

  // -- Which vertices, with which weights, make each point.
  struct Mix {
    int vertex[3];
    double weight[3];
  };
  std::vector<Mix> mixes;
  std::vector<Vec3d> jaw_line;
  for (int i = 0; i < kLandmarkCount; ++i) {
    const Triangle t = model.triangles[model.landmark_triangle[i]];
    const Vec3d b = model.landmark_barycentric[i].cast<double>();
    mixes.push_back({{t[0], t[1], t[2]}, {b[0], b[1], b[2]}});
    if (i < kJawLineCount)
      jaw_line.push_back(b[0] * model.vertices[t[0]].cast<double>() +
                         b[1] * model.vertices[t[1]].cast<double>() +
                         b[2] * model.vertices[t[2]].cast<double>());
  }
  ReducedHead head;
  std::vector<int> point_of_vertex(model.vertex_count(), -1);
  for (int i = 0; i < kJawLineCount; ++i)
    for (int v : contour_vertices(model, jaw_line, i)) {
      if (point_of_vertex[v] < 0) {
        point_of_vertex[v] = static_cast<int>(mixes.size());
        mixes.push_back({{v, v, v}, {1, 0, 0}});
      }
      head.contour[i].push_back(point_of_vertex[v]);
    }

  // -- Rows of the bases.
  const int n = head.points = static_cast<int>(mixes.size());
  const bool correctives = model.pose_basis.cols() >= kPoseFeatureCount;
  const std::vector<Vec3f> normals = vertex_normals(model.vertices, model.triangles);
  head.base = Eigen::VectorXd::Zero(3 * n);
  head.identity = RowMatrix::Zero(3 * n, identities);
  head.expression = RowMatrix::Zero(3 * n, expressions);
  head.jaw_corrective = RowMatrix::Zero(3 * n, 9);
  head.jaw_weight = Eigen::VectorXd::Zero(n);
  head.normals.assign(n, Vec3d::Zero());
  for (int p = 0; p < n; ++p) {
    for (int k = 0; k < 3; ++k) {
      const int v = mixes[p].vertex[k];
      const double w = mixes[p].weight[k];
      if (w == 0) continue;
      head.base.segment<3>(3 * p) += w * place(v);
      head.identity.middleRows(3 * p, 3) +=
          w * model.identity_basis.block(3 * v, 0, 3, identities).cast<double>();
      head.expression.middleRows(3 * p, 3) += w * model.expression_basis.middleRows(3 * v, 3).cast<double>();
      if (correctives)  // joints 1..4 have nine features each; the jaw is joint 2
        head.jaw_corrective.middleRows(3 * p, 3) += w * model.pose_basis.block(3 * v, 9, 3, 9).cast<double>();
      head.jaw_weight[p] += w * model.skinning_weights(v, kJaw);
      head.normals[p] += w * normals[v].cast<double>();
    }
    head.normals[p].normalize();
  }
  head.jaw_joint_identity = RowMatrix::Zero(3, identities);
  for (int v = 0; v < model.vertex_count(); ++v) {
    const double w = model.joint_regressor(kJaw, v);
    if (w == 0) continue;
    head.jaw_joint += w * place(v);
    head.jaw_joint_identity += w * model.identity_basis.block(3 * v, 0, 3, identities).cast<double>();
  }
  return head;
}

ReducedHead reduce_head(const HeadModel& model, int max_identity, const PersonShape& person) {
  const Eigen::Index fine = person.identity.size() - max_identity;
  if (fine <= 0 || person.identity.tail(fine).isZero(0))
    return reduce_head(model, max_identity, person.offsets);
  const Eigen::VectorXf moved =
      model.identity_basis.middleCols(max_identity, fine) * person.identity.tail(fine);
  std::vector<Vec3f> offsets = person.offsets;
  offsets.resize(model.vertices.size(), Vec3f::Zero());
  for (std::size_t v = 0; v < offsets.size(); ++v) offsets[v] += moved.segment<3>(3 * Eigen::Index(v));
  return reduce_head(model, max_identity, offsets);
}

ReducedPerson reduced_person(const ReducedHead& head, const Eigen::VectorXd& identity) {
  LIKENESS_CHECK(identity.size() == head.identity_count(), "%d identity numbers for %d directions",
                 static_cast<int>(identity.size()), head.identity_count());
  return {head.base + head.identity * identity, head.jaw_joint + head.jaw_joint_identity * identity};
}

JawTurn::JawTurn(double jaw) : cosine(std::cos(jaw)), sine(std::sin(jaw)) {
  turn << 1, 0, 0, 0, cosine, -sine, 0, sine, cosine;
  rate << 0, 0, 0, 0, -sine, -cosine, 0, cosine, -sine;
}

// R - I of a turn about x: rows (0,0,0), (0, c-1, -s), (0, s, c-1).
Vec3d JawTurn::corrected(const ReducedHead& head, int point) const {
  const auto c = head.jaw_corrective.middleRows(3 * point, 3);
  return (cosine - 1) * (c.col(4) + c.col(8)) + sine * (c.col(7) - c.col(5));
}

Vec3d JawTurn::corrected_rate(const ReducedHead& head, int point) const {
  const auto c = head.jaw_corrective.middleRows(3 * point, 3);
  return -sine * (c.col(4) + c.col(8)) + cosine * (c.col(7) - c.col(5));
}

Vec3d reduced_point(const ReducedHead& head, const ReducedPerson& person, int point,
                    const Eigen::VectorXd& expression, double jaw, PointDerivatives* derivatives) {
  const double w = head.jaw_weight[point];
  const JawTurn turned(jaw);
  const Vec3d shape = person.base.segment<3>(3 * point) +
                      head.expression.middleRows(3 * point, 3) * expression + turned.corrected(head, point);
  const Vec3d arm = shape - person.jaw_joint;
  if (derivatives) {
    derivatives->by_shape = (1 - w) * Mat3d::Identity() + w * turned.turn;
    derivatives->by_joint = w * (Mat3d::Identity() - turned.turn);
    derivatives->by_jaw =
        w * (turned.rate * arm) + derivatives->by_shape * turned.corrected_rate(head, point);
  }
  return (1 - w) * shape + w * (turned.turn * arm + person.jaw_joint);
}

}  // namespace likeness
