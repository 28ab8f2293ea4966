#include "core/track/photo/photometric_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/quantile.h"
#include "core/scene/head_regions.h"

namespace likeness {
namespace {

constexpr int kMaxSplits = 2;
constexpr float kLidReach = 0.008f, kLipReach = 0.008f, kMouthReach = 0.034f;       // m
constexpr float kCoarseStep = 0.0055f, kSkinStep = 0.004f, kFeatureStep = 0.0019f;  // m

using Mix = std::map<int, double>;  // model vertex -> weight

// Splits every triangle into four; new points are the midpoints of edges.
void split_once(std::vector<Mix>& mixes, std::vector<Triangle>& triangles) {
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [place, fresh] =
        middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(mixes.size()));
    if (fresh) {
      Mix mix;
      for (const auto& [v, w] : mixes[a]) mix[v] += 0.5 * w;
      for (const auto& [v, w] : mixes[b]) mix[v] += 0.5 * w;
      mixes.push_back(std::move(mix));
    }
    return place->second;
  };
  std::vector<Triangle> next;
  next.reserve(4 * triangles.size());
  for (const Triangle& t : triangles) {
    const int ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
    next.insert(next.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
  }
  triangles = std::move(next);
}

double median_edge(const std::vector<Mix>& mixes, const std::vector<Triangle>& triangles,
                   const std::vector<Vec3f>& vertices) {
  const auto place = [&](int p) {
    Vec3d sum = Vec3d::Zero();
    for (const auto& [v, w] : mixes[p]) sum += w * vertices[v].cast<double>();
    return sum;
  };
  std::vector<double> edges;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) edges.push_back((place(t[k]) - place(t[(k + 1) % 3])).norm());
  return median(std::move(edges));
}

void fill_points(const HeadModel& model, const HeadShape& shape, const std::vector<Mix>& mixes,
                 MovingSurface& surface) {
  const int n = static_cast<int>(mixes.size()), expressions = model.expression_count();
  ReducedHead& head = surface.points;
  head.points = n;
  head.base = Eigen::VectorXd::Zero(3 * n);
  head.identity = RowMatrix::Zero(3 * n, 0);
  head.expression = RowMatrix::Zero(3 * n, expressions);
  head.jaw_corrective = RowMatrix::Zero(3 * n, 9);
  head.jaw_weight = Eigen::VectorXd::Zero(n);
  head.jaw_joint = shape.joints[kJaw].cast<double>();
  head.jaw_joint_identity = RowMatrix::Zero(3, 0);
  const bool correctives = model.pose_basis.cols() >= kPoseFeatureCount;
  for (int p = 0; p < n; ++p)
    for (const auto& [v, w] : mixes[p]) {
      head.base.segment<3>(3 * p) += w * shape.vertices[v].cast<double>();
      head.expression.middleRows(3 * p, 3) += w * model.expression_basis.middleRows(3 * v, 3).cast<double>();
      if (correctives)  // joints 1..4 have nine features each; the jaw is joint 2
        head.jaw_corrective.middleRows(3 * p, 3) += w * model.pose_basis.block(3 * v, 9, 3, 9).cast<double>();
      head.jaw_weight[p] += w * model.skinning_weights(v, kJaw);
    }
  surface.person = {head.base, head.jaw_joint};
}

// The skin triangles near the mouth and the inside's (of the model), with the points they need.
MouthSurface mouth_surface(const HeadModel& model, const HeadShape& person, const FaceSurface& face,
                           const std::vector<Mix>& mixes, const std::vector<Triangle>& interior) {
  const auto landmarks = landmark_positions(model, person.vertices);
  Vec3f middle = Vec3f::Zero();
  for (int i = 48; i < kLandmarkCount; ++i) middle += landmarks[i] / 20;
  MouthSurface mouth;
  std::vector<Mix> own;
  const auto add = [&](const Triangle& t, std::vector<int>& numbers, const auto& mix_of) {
    Triangle renumbered;
    for (int k = 0; k < 3; ++k) {
      int& number = numbers[t[k]];
      if (number < 0) {
        number = static_cast<int>(own.size());
        own.push_back(mix_of(t[k]));
      }
      renumbered[k] = number;
    }
    mouth.triangles.push_back(renumbered);
  };
  std::vector<int> skin_numbers(mixes.size(), -1), inside_numbers(model.vertices.size(), -1);
  for (const Triangle& t : face.triangles) {
    if ((face.person.base.segment<3>(3 * t[0]).cast<float>() - middle).norm() >= kMouthReach) continue;
    add(t, skin_numbers, [&](int p) { return mouth.skin.push_back(p), mixes[p]; });
  }
  mouth.skin_triangles = mouth.triangles.size();
  for (const Triangle& t : interior) add(t, inside_numbers, [](int v) { return Mix{{v, 1.0}}; });
  fill_points(model, person, own, mouth);
  return mouth;
}

float line_distance(const Vec3f& p, const Vec3f& a, const Vec3f& b) {
  const Vec3f d = b - a;
  const float t = std::clamp((p - a).dot(d) / std::max(1e-12f, d.squaredNorm()), 0.0f, 1.0f);
  return (p - a - t * d).norm();
}

FaceZone zone_of(const std::array<Vec3f, kLandmarkCount>& landmarks, const Vec3f& p) {
  const auto reach = [&](int first, int last) {  // of a closed line
    float least = 1e9f;
    for (int i = first; i <= last; ++i)
      least = std::min(least, line_distance(p, landmarks[i], landmarks[i == last ? first : i + 1]));
    return least;
  };
  if (std::min(reach(36, 41), reach(42, 47)) < kLidReach) return FaceZone::lid;
  return std::min(reach(48, 59), reach(60, 67)) < kLipReach ? FaceZone::lip : FaceZone::skin;
}

// One point of each cell of a cubic grid, the first in order.
std::vector<int> thinned(const FaceSurface& surface, float skin_step, float feature_step) {
  std::set<std::tuple<int, int, int, int>> taken;
  std::vector<int> chosen;
  for (int p = 0; p < surface.points.points; ++p) {
    const bool feature = surface.zone[p] != FaceZone::skin;
    const Vec3d cell =
        (surface.person.base.segment<3>(3 * p) / (feature ? feature_step : skin_step)).array().floor();
    if (taken
            .insert(
                {feature, static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())})
            .second)
      chosen.push_back(p);
  }
  return chosen;
}

}  // namespace

FaceSurface face_surface(const HeadModel& model, const HeadShape& person, double spacing_m) {
  const HeadRegions regions = head_regions(model);
  FaceSurface surface;
  std::vector<Mix> mixes;
  std::vector<Triangle> interior;
  std::vector<int> point_of(model.vertices.size(), -1);
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    if (regions.mouth_interior[t]) interior.push_back(model.triangles[t]);
    if (!regions.face[t] || !regions.skin[t]) continue;
    Triangle own;
    bool outer = true;
    for (int k = 0; k < 3; ++k) {
      const int v = model.triangles[t][k];
      const HeadPart part = model.parts[v];
      outer = outer && (part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::unknown);
      if (point_of[v] < 0) {
        point_of[v] = static_cast<int>(mixes.size());
        mixes.push_back({{v, 1.0}});
      }
      own[k] = point_of[v];
    }
    if (outer) surface.triangles.push_back(own);
  }
  for (int i = 0; i < kMaxSplits && median_edge(mixes, surface.triangles, person.vertices) > spacing_m; ++i)
    split_once(mixes, surface.triangles);
  fill_points(model, person, mixes, surface);

  surface.mouth = mouth_surface(model, person, surface, mixes, interior);

  const auto landmarks = landmark_positions(model, person.vertices);
  for (int p = 0; p < surface.points.points; ++p)
    surface.zone.push_back(zone_of(landmarks, surface.person.base.segment<3>(3 * p).cast<float>()));
  surface.coarse = thinned(surface, kCoarseStep, 2 * kFeatureStep);
  surface.fine = thinned(surface, kSkinStep, kFeatureStep);
  return surface;
}

PosedSurface posed_surface(const MovingSurface& surface, const Eigen::VectorXd& expression, double jaw) {
  PosedSurface posed;
  posed.points.resize(surface.points.points);
  const ReducedHead& head = surface.points;
  ReducedPerson shaped =
      surface.person;  // the expression in one product; only the jaw is applied point by point
  shaped.base.noalias() += head.expression * expression;
  const JawTurn turned(jaw);
  for (int p = 0; p < head.points; ++p) {
    const Vec3d shape = shaped.base.segment<3>(3 * p) + turned.corrected(head, p);
    const double w = head.jaw_weight[p];
    posed.points[p] =
        ((1 - w) * shape + w * (turned.turn * (shape - shaped.jaw_joint) + shaped.jaw_joint)).cast<float>();
  }
  posed.normals = vertex_normals(posed.points, surface.triangles);
  return posed;
}

}  // namespace likeness
