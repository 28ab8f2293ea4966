// Template pixels lie on Z(x) = Z0 + bend (x - x0)^2 in the reference camera, the shape of a chest seen from
// the front.
#include "core/track/torso/torso_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr double kChestForward = 0.04;    // m, chest before the head's origin
constexpr double kBend = 1.75;            // 1/m, shoulders lie this much behind
constexpr double kHalfWidth = 0.3;        // m of body used each side
constexpr double kNeckHalf = 0.065;       // m, the neck moves with the head and is left out
constexpr double kShouldersBelow = 0.01;  // m below the chin where shoulders may begin
constexpr double kBeside = 0.1;           // m from the middle on, in a picture cut off at the chin,
constexpr double kBesideRise = 0.05;      // they may reach up this much above it
constexpr double kNeckBelow = 0.045;      // m below the chin where the neck's shadows end
constexpr double kPivotBelow = 0.065;     // m
constexpr double kLowest = 0.36;          // m below the chin: further down are hands and desks
constexpr double kEdge = 4;               // grey levels a pixel
constexpr double kNapeRise = 0.35;        // of the plane from the chin back under the skull
constexpr int kEdgeReach = 3;             // px
constexpr int kSurroundings = 10;         // px to each side, of any level

GreyLevel reduced(const GreyLevel& from) {
  GreyLevel to{from.width / 2, from.height / 2, from.scale / 2, {}};
  to.data.resize(static_cast<std::size_t>(to.width) * to.height);
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x)
      to.data[static_cast<std::size_t>(y) * to.width + x] =
          0.25f * (from.at(2 * x, 2 * y) + from.at(2 * x + 1, 2 * y) + from.at(2 * x, 2 * y + 1) +
                   from.at(2 * x + 1, 2 * y + 1));
  return to;
}

// The level minus the mean of the surroundings.
GreyLevel relief(GreyLevel level) {
  cv::Mat values(level.height, level.width, CV_32F, level.data.data()), mean;
  cv::blur(values, mean, {2 * kSurroundings + 1, 2 * kSurroundings + 1}, {-1, -1}, cv::BORDER_REPLICATE);
  cv::subtract(values, mean, values);
  return level;
}

// One flag per pixel: an edge is near.
std::vector<std::uint8_t> near_edges(const GreyLevel& level) {
  std::vector<std::uint8_t> near(level.data.size(), 0);
  const int w = level.width, h = level.height;
  for (int y = 1; y + 1 < h; ++y)
    for (int x = 1; x + 1 < w; ++x) {
      const double dx = 0.5 * (level.at(x + 1, y) - level.at(x - 1, y)),
                   dy = 0.5 * (level.at(x, y + 1) - level.at(x, y - 1));
      if (std::hypot(dx, dy) < kEdge) continue;
      for (int v = std::max(0, y - kEdgeReach); v <= std::min(h - 1, y + kEdgeReach); ++v)
        for (int u = std::max(0, x - kEdgeReach); u <= std::min(w - 1, x + kEdgeReach); ++u)
          near[static_cast<std::size_t>(v) * w + u] = 1;
    }
  return near;
}

// Where a torso may be: below the chin and, if asked for, beside the face.
TorsoTemplate torso_pixels(const TorsoFrame& f, const Vec3d& chin, bool beside_face) {
  TorsoTemplate made;
  const Pose cam_from_head = f.cam_from_world * f.world_from_head, head_from_cam = inverse(cam_from_head);
  const Vec3d chin_cam = cam_from_head * chin;
  const double z0 = cam_from_head.translation().z() - kChestForward;
  const double x0 = cam_from_head.translation().x() / cam_from_head.translation().z() * z0;
  const double chin_y = chin_cam.y() / chin_cam.z() * z0;
  made.pivot = (head_from_cam * Vec3d(x0, chin_y + kPivotBelow, z0)).head<2>();
  const auto first = [&](double side) {  // m below the chin
    if (side < kNeckHalf) return kNeckBelow;
    return beside_face && side > kBeside ? -kBesideRise : kShouldersBelow;
  };
  for (const GreyLevel& level : relief_pyramid(*f.grey)) {
    const bool finest = made.levels.empty();
    const std::vector<std::uint8_t> edges =
        finest ? near_edges(level) : std::vector<std::uint8_t>(level.data.size(), 1);
    std::vector<TorsoPixel> pixels;
    std::size_t covered = 0;
    for (int y = 2; y < level.height - 2; ++y)
      for (int x = 2; x < level.width - 2; ++x) {
        const Vec2d px((x + 0.5) / level.scale, (y + 0.5) / level.scale);
        const Vec3d ray = ray_direction(f.intrinsics, px);
        const double side = ray.x() * z0 - x0, down = ray.y() * z0 - chin_y;
        if (std::abs(side) > kHalfWidth || down > kLowest || down < first(std::abs(side))) continue;
        ++covered;
        if (!edges[static_cast<std::size_t>(y) * level.width + x] || holds(f.head_outline, px, 0)) continue;
        pixels.push_back({head_from_cam * (ray * (z0 + kBend * side * side)), level.at(x, y), 1});
      }
    if (finest)
      made.picture_share = static_cast<double>(covered) / (static_cast<double>(level.width) * level.height);
    made.levels.push_back(std::move(pixels));
  }
  return made;
}

}  // namespace

bool GreyLevel::sample(double px, double py, float* value, Vec2d* slope) const {
  const double x = px - 0.5, y = py - 0.5;
  if (!(x >= 1 && y >= 1 && x < width - 2 && y < height - 2)) return false;
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const double u = x - ix, v = y - iy;
  const double a = at(ix, iy), b = at(ix + 1, iy), c = at(ix, iy + 1), d = at(ix + 1, iy + 1);
  *value = static_cast<float>((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d));
  if (slope) *slope = {(1 - v) * (b - a) + v * (d - c), (1 - u) * (c - a) + u * (d - b)};
  return true;
}

std::vector<GreyLevel> relief_pyramid(const Image8& grey) {
  GreyLevel full{grey.width, grey.height, 1, std::vector<float>(grey.data.begin(), grey.data.end())};
  std::vector<GreyLevel> levels;
  for (int k = 0; k < 3; ++k) {
    full = reduced(full);
    levels.push_back(relief(full));
  }
  return levels;
}

TorsoTemplate make_torso_template(const TorsoFrame& f, const Vec3d& chin) {
  TorsoTemplate made = torso_pixels(f, chin, false);
  return made.picture_share > kLeastTorsoShare ? made : torso_pixels(f, chin, true);
}

ConvexOutline head_outline(const std::vector<Vec3f>& vertices, const Vec3d& chin, const Pose& cam_from_head,
                           const Intrinsics& intrinsics) {
  std::vector<Vec2d> points;
  for (const Vec3f& v : vertices) {
    if (v.y() < chin.y() - 0.005 + kNapeRise * std::max(0.0, chin.z() - v.z())) continue;
    const Vec3d p = cam_from_head * v.cast<double>();
    if (p.z() > 0.05) points.push_back(project<double>(intrinsics, p));
  }
  return convex_outline(std::move(points));
}

}  // namespace likeness
