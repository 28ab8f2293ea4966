// See torso_hem.h.
#include "core/train/torso_hem.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "core/base/quantile.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr float kLift = 0.003f;                  // m: the last row of a picture is only half seen
constexpr double kDeepest = 0.03;                // of the views, at least
constexpr std::size_t kFewest = 2;               // two, that teach too little of what they alone see
constexpr float kAside = 0.2f;                   // m from the middle: where shoulders and chest are cut off
constexpr float kBehind = 0.1f, kAhead = 0.13f;  // m of the middle

// The plane through a view's camera and the lower edge of what was filmed, torso frame.
std::optional<TorsoHem> lower_edge(const TrainingView& view) {
  const Pose torso_from_cam = inverse(view.camera.cam_from_world * view.pose.world_from_torso);
  const Intrinsics& k = view.camera.intrinsics;
  const double bottom = view.inside.empty() ? k.height : view.inside.y + view.inside.height;
  const Vec3d left = torso_from_cam.linear() * ray_direction(k, Vec2d(0, bottom)),
              right = torso_from_cam.linear() * ray_direction(k, Vec2d(k.width, bottom));
  const Vec3d normal = left.cross(right).normalized(), eye = torso_from_cam.translation();
  if (!(std::abs(normal.y()) > 0.3)) return std::nullopt;  // seen from far above, or lying
  return TorsoHem{float(normal.dot(eye) / normal.y()), float(-normal.x() / normal.y()),
                  float(-normal.z() / normal.y())};
}

}  // namespace

std::optional<TorsoHem> find_hem(const TrainingSet& set, const FieldCube& torso) {
  std::vector<TorsoHem> edges;
  for (const TrainingView& view : own_views(set))
    if (const auto edge = lower_edge(view)) edges.push_back(*edge);
  if (edges.empty()) return std::nullopt;
  const auto usual = [&](float TorsoHem::*number) {
    std::vector<float> values;
    for (const TorsoHem& edge : edges) values.push_back(edge.*number);
    return median(std::move(values));
  };
  TorsoHem hem{0, usual(&TorsoHem::slope_x), usual(&TorsoHem::slope_z)};
  // Pictures from other sides end along other planes: one counts where it reaches deepest.
  const float middle = torso.origin.z() + 0.5f * torso.side;
  std::vector<float> heights;
  for (const TorsoHem& edge : edges) {
    float deepest = 1e9f;
    for (const float x : {-kAside, kAside})
      for (const float z : {middle - kBehind, middle + kAhead})
        deepest = std::min(deepest, edge.at(x, z) - hem.at(x, z));
    heights.push_back(deepest);
  }
  std::ranges::sort(heights);
  const std::size_t passed = std::max(kFewest, std::size_t(kDeepest * double(edges.size())));
  hem.height = heights[std::min(passed, heights.size() - 1)] + kLift;
  return hem;
}

void extend_below(const TorsoHem& hem, FieldPart& torso) {
  const int n = torso.occupancy.resolution;
  const float cell = torso.cube.side / float(n);
  for (int z = 0; z < n; ++z)
    for (int x = 0; x < n; ++x) {
      const Vec3f place = torso.cube.origin + cell * Vec3f(float(x) + 0.5f, 0.5f, float(z) + 0.5f);
      // The first row whose middle lies at the hem or above it.
      const float first = std::ceil((hem.at(place.x(), place.z()) - place.y()) / cell);
      if (!(first >= 1 && first < float(n))) continue;
      const int row = int(first), lowest = std::max(0, row - int(std::ceil(kBelowHem / cell)));
      const auto index = [&](int y) { return (std::size_t(z) * std::size_t(n) + std::size_t(y)) * n + x; };
      const bool there = torso.occupancy.occupied(x, row, z);
      for (int y = 0; y < row; ++y) {
        set_occupied(torso.occupancy, x, y, z, there && y >= lowest);
        if (!torso.opacity.empty()) torso.opacity[index(y)] = y >= lowest ? torso.opacity[index(row)] : 0;
      }
    }
}

}  // namespace likeness
