#include "core/track/fit/shape_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/head/pose_head.h"
#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr double kMinShare = 0.03;   // of the usual size; vertices with less stay fixed
constexpr float kLidReach = 0.006f;  // m from the eyeball's surface
constexpr float kLipReach = 0.006f;  // m from the line between the lips
constexpr double kTie = 3;           // times the springs' play: ties of lids to eyeballs and lips to teeth

using Triplets = std::vector<Eigen::Triplet<double>>;
using Landmarks3 = std::array<Vec3f, kLandmarkCount>;

bool is_hard_mouth(HeadPart part) { return part == HeadPart::teeth || part == HeadPart::gums_tongue; }

HeadPart part_of(const HeadModel& model, int v) {
  return model.parts.empty() ? HeadPart::unknown : model.parts[v];
}

// One node per vertex, but a single one for each eyeball and one for the mouth's hard parts; none for the
// torso.
struct Nodes {
  std::vector<int> of;
  int count = 0;
  std::array<int, 2> eyeball{-1, -1};
  int mouth = -1;
};

Nodes number_nodes(const HeadModel& model, const std::vector<double>& share) {
  Nodes nodes;
  nodes.of.assign(model.vertices.size(), -1);
  for (int v = 0; v < model.vertex_count(); ++v) {
    const HeadPart part = part_of(model, v);
    int* shared = part == HeadPart::left_eyeball    ? &nodes.eyeball[0]
                  : part == HeadPart::right_eyeball ? &nodes.eyeball[1]
                  : is_hard_mouth(part)             ? &nodes.mouth
                                                    : nullptr;
    if (part == HeadPart::torso || share[v] < kMinShare) continue;
    if (shared && *shared < 0) *shared = nodes.count++;
    nodes.of[v] = shared ? *shared : nodes.count++;
  }
  return nodes;
}

float line_distance(const Vec3f& p, const Vec3f& a, const Vec3f& b) {
  const Vec3f d = b - a;
  const float t = std::clamp((p - a).dot(d) / std::max(1e-12f, d.squaredNorm()), 0.0f, 1.0f);
  return (p - a - t * d).norm();
}

// 0: neither, 1 and 2: lids of the left and right eye, 3: lips.
std::vector<int> soft_rims(const HeadModel& model, const std::vector<Vec3f>& rest) {
  std::array<Vec3f, 2> centre{Vec3f::Zero(), Vec3f::Zero()};
  std::array<int, 2> count{};
  std::array<float, 2> radius{};
  const auto side_of = [&](int v) {
    const HeadPart part = part_of(model, v);
    return part == HeadPart::left_eyeball ? 0 : part == HeadPart::right_eyeball ? 1 : -1;
  };
  for (int v = 0; v < model.vertex_count(); ++v)
    if (const int side = side_of(v); side >= 0) centre[side] += rest[v], ++count[side];
  for (int side = 0; side < 2; ++side) centre[side] /= static_cast<float>(std::max(1, count[side]));
  for (int v = 0; v < model.vertex_count(); ++v)
    if (const int side = side_of(v); side >= 0)
      radius[side] = std::max(radius[side], (rest[v] - centre[side]).norm());
  const Landmarks3 landmarks = landmark_positions(model, rest);
  std::vector<int> rim(model.vertices.size(), 0);
  for (int v = 0; v < model.vertex_count(); ++v) {
    for (int side = 0; side < 2; ++side)
      if (count[side] > 0 && (rest[v] - centre[side]).norm() < radius[side] + kLidReach) rim[v] = 1 + side;
    if (rim[v] == 0 && lip_distance(landmarks, rest[v]) < kLipReach) rim[v] = 3;
  }
  return rim;
}

// The share of the usual size at each vertex: 1 on the face, fading away from it.
std::vector<double> share_of_size(const HeadModel& model, const std::vector<Vec3f>& rest, double fade_m) {
  const MeshScene face(rest, region_triangles(model, head_regions(model).face));
  std::vector<double> share(model.vertices.size(), 0);
  for (int v = 0; v < model.vertex_count(); ++v)
    if (const auto nearest = face.closest(rest[v])) {
      const double t = nearest->distance / fade_m;
      share[v] = std::exp(-t * t);
    }
  return share;
}

// Area and cotangent stiffness of the triangles whose corners move on their own.
void add_surface(const HeadModel& model, const std::vector<Vec3f>& rest, const Nodes& nodes,
                 Eigen::VectorXd& area, Triplets& stiffness) {
  for (const Triangle& t : model.triangles) {
    const auto alone = [&](int v) {
      const int n = nodes.of[v];
      return n >= 0 && n != nodes.eyeball[0] && n != nodes.eyeball[1] && n != nodes.mouth;
    };
    if (!alone(t[0]) || !alone(t[1]) || !alone(t[2])) continue;
    const Vec3d a = rest[t[0]].cast<double>(), b = rest[t[1]].cast<double>(), c = rest[t[2]].cast<double>();
    const double twice = (b - a).cross(c - a).norm();
    if (twice < 1e-14) continue;
    for (int k = 0; k < 3; ++k) {
      const int i = nodes.of[t[(k + 1) % 3]], j = nodes.of[t[(k + 2) % 3]];
      const Vec3d at = rest[t[k]].cast<double>();
      const Vec3d u = rest[t[(k + 1) % 3]].cast<double>() - at, w = rest[t[(k + 2) % 3]].cast<double>() - at;
      const double half_cot = std::clamp(0.5 * u.dot(w) / twice, 0.02, 3.0);  // slivers stay harmless
      stiffness.insert(stiffness.end(),
                       {{i, i, half_cot}, {j, j, half_cot}, {i, j, -half_cot}, {j, i, -half_cot}});
      area[nodes.of[t[k]]] += twice / 6;
    }
  }
}

void add_spring(Triplets& list, int i, int j, double weight) {
  if (i < 0 || j < 0 || i == j) return;
  list.insert(list.end(), {{i, i, weight}, {j, j, weight}, {i, j, -weight}, {j, i, -weight}});
}

void add_springs(const HeadModel& model, const std::vector<Vec3f>& rest, const Nodes& nodes, double spring_m,
                 Triplets& springs) {
  const std::vector<int> rim = soft_rims(model, rest);
  const double stiff = 1 / (spring_m * spring_m), tie = stiff / (kTie * kTie);
  for (const Triangle& t : model.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (rim[a] > 0 && rim[a] == rim[b]) add_spring(springs, nodes.of[a], nodes.of[b], stiff);
    }
  for (int v = 0; v < model.vertex_count(); ++v) {
    if (rim[v] == 1 || rim[v] == 2) add_spring(springs, nodes.of[v], nodes.eyeball[rim[v] - 1], tie);
    if (rim[v] == 3 || part_of(model, v) == HeadPart::mouth_socket)
      add_spring(springs, nodes.of[v], nodes.mouth, tie);
  }
}

}  // namespace

float lip_distance(const Landmarks3& landmarks, const Vec3f& point) {
  float least = 1e9f;
  for (int i = 60; i < 68; ++i)
    least = std::min(least, line_distance(point, landmarks[i], landmarks[i == 67 ? 60 : i + 1]));
  return least;
}

ShapeField shape_field(const HeadModel& model, const std::vector<Vec3f>& rest,
                       const ShapeFieldOptions& options) {
  const std::vector<double> share = share_of_size(model, rest, options.fade_m);
  const Nodes nodes = number_nodes(model, share);
  const int n = nodes.count;
  Eigen::VectorXd area = Eigen::VectorXd::Zero(n);
  Triplets stiffness, springs;
  add_surface(model, rest, nodes, area, stiffness);
  const double k = std::sqrt(8.0) / options.range_m;
  for (int i = 0; i < n; ++i) {
    area[i] = std::max(area[i], 1e-8);  // vertices in no triangle get a tiny area
    stiffness.push_back({i, i, k * k * area[i]});
  }
  Eigen::SparseMatrix<double> wave(n, n);
  wave.setFromTriplets(stiffness.begin(), stiffness.end());
  Eigen::VectorXd per_size = Eigen::VectorXd::Constant(n, 1 / options.usual_m);
  for (int v = 0; v < model.vertex_count(); ++v)
    if (nodes.of[v] >= 0) per_size[nodes.of[v]] = 1 / (options.usual_m * share[v]);
  const Eigen::SparseMatrix<double> right = wave * per_size.asDiagonal();
  ShapeField field;
  field.node_of = nodes.of;
  field.nodes = n;
  field.precision = Eigen::SparseMatrix<double>(right.transpose()) * area.cwiseInverse().asDiagonal() * right;
  field.precision /= 4 * std::numbers::pi * k * k;
  add_springs(model, rest, nodes, options.spring_m, springs);
  Eigen::SparseMatrix<double> tied(n, n);
  tied.setFromTriplets(springs.begin(), springs.end());
  field.precision += tied;
  return field;
}

}  // namespace likeness
