// Carving by voting: a mean per direction of view, then the least mean over the directions, so that many
// similar views do not outvote the few that see past the part.
#include "core/matte/hull.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr double kGroupAngle = 0.2;  // rad between directions of view that vote together
constexpr float kDoubt = 1.0f;   // votes for the person that each group starts with: one view carves nothing
constexpr float kShown = 0.25f;  // shares below this are not drawn

// Linear map from the part's frame to homogeneous pixels; the crop's distortion is below a voxel's size.
struct Map {
  Eigen::Matrix3f linear;
  Vec3f offset;
};

Map pixel_map(const Pose& cam_from_part, const Intrinsics& k) {
  Eigen::Matrix3d projection = Eigen::Matrix3d::Identity();
  projection(0, 0) = k.fx, projection(1, 1) = k.fy, projection(0, 2) = k.cx, projection(1, 2) = k.cy;
  return {(projection * cam_from_part.linear()).cast<float>(),
          (projection * cam_from_part.translation()).cast<float>()};
}

Vec3f voxel_centre(const Hull& hull, int x, int y, int z) {
  return (hull.low + hull.step * Vec3d(x + 0.5, y + 0.5, z + 0.5)).cast<float>();
}

// Greedy groups of views with nearly the same direction towards the part's camera.
std::vector<std::vector<std::size_t>> group_views(const std::vector<HullView>& views) {
  std::vector<std::vector<std::size_t>> groups;
  std::vector<Vec3d> leaders;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Vec3d direction = inverse(views[i].cam_from_part).translation().normalized();
    std::size_t group = 0;
    while (group < groups.size() && leaders[group].dot(direction) < std::cos(kGroupAngle)) ++group;
    if (group == groups.size()) groups.emplace_back(), leaders.push_back(direction);
    groups[group].push_back(i);
  }
  return groups;
}

}  // namespace

Hull carve_hull(const Vec3d& low, const Vec3d& high, double step, const std::vector<HullView>& views) {
  Hull hull;
  if (views.empty()) return hull;
  hull.low = low;
  hull.step = step;
  for (int axis = 0; axis < 3; ++axis)
    hull.count[std::size_t(axis)] = std::max(1, int(std::ceil((high[axis] - low[axis]) / step)));
  const int nx = hull.count[0], ny = hull.count[1], nz = hull.count[2];
  hull.share.assign(std::size_t(nx) * std::size_t(ny) * std::size_t(nz), 1.0f);
  const auto groups = group_views(views);
  std::vector<Map> maps;
  for (const auto& view : views) maps.push_back(pixel_map(view.cam_from_part, view.picture));
  parallel_for(std::size_t(nz), [&](std::size_t z) {
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const Vec3f centre = voxel_centre(hull, x, y, int(z));
        float least = 1;
        for (const auto& group : groups) {
          float votes = kDoubt, person = kDoubt;
          for (std::size_t i : group) {
            const Vec3f p = maps[i].linear * centre + maps[i].offset;
            if (p.z() < 0.05f) continue;
            const int u = int(std::floor(p.x() / p.z())), v = int(std::floor(p.y() / p.z()));
            const cv::Mat& mask = views[i].person;
            if (u < 0 || v < 0 || u >= mask.cols || v >= mask.rows) continue;
            votes += 1;
            person += mask.at<unsigned char>(v, u) ? 1.0f : 0.0f;
          }
          least = std::min(least, person / votes);
        }
        hull.share[(z * std::size_t(ny) + std::size_t(y)) * std::size_t(nx) + std::size_t(x)] = least;
      }
  });
  return hull;
}

cv::Mat hull_share(const Hull& hull, const Pose& cam_from_part, const Intrinsics& picture) {
  cv::Mat share(picture.height, picture.width, CV_32F, cv::Scalar(0));
  const Map map = pixel_map(cam_from_part, picture);
  const int nx = hull.count[0], ny = hull.count[1], nz = hull.count[2];
  std::size_t index = 0;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x, ++index) {
        const float value = hull.share[index];
        if (value < kShown) continue;
        const Vec3f p = map.linear * voxel_centre(hull, x, y, z) + map.offset;
        if (p.z() < 0.05f) continue;
        const float u = p.x() / p.z(), v = p.y() / p.z();
        const float half = 0.5f * float(hull.step * picture.fx) / p.z();
        const int u0 = std::max(0, int(std::floor(u - half))),
                  u1 = std::min(share.cols - 1, int(std::floor(u + half)));
        const int v0 = std::max(0, int(std::floor(v - half))),
                  v1 = std::min(share.rows - 1, int(std::floor(v + half)));
        for (int row = v0; row <= v1; ++row)
          for (int column = u0; column <= u1; ++column)
            share.at<float>(row, column) = std::max(share.at<float>(row, column), value);
      }
  return share;
}

}  // namespace likeness
