// See solving_cameras.h.
#include "ui/studio/solving_cameras.h"

#include <algorithm>

#include "core/base/align_points.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/camera/colmap.h"

namespace likeness::ui {

namespace {

constexpr double kRadius = 0.5, kFarthestDrawn = 6;
constexpr double kReachQuantile = 0.7, kFarthestReach = 3;  // of the points

// The rotation that turns `up` to y.
Eigen::Matrix3d upright(const Vec3d& up) { return rotation_between(up, Vec3d::UnitY()); }

}  // namespace

std::shared_ptr<const SolvingCameras> solving_cameras(const ColmapModel& model) {
  if (model.images.size() < 2) return nullptr;
  auto solving = std::make_shared<SolvingCameras>();
  Vec3d middle = Vec3d::Zero(), up = Vec3d::Zero();
  for (const ColmapImage& image : model.images) {
    const auto intrinsics = model.cameras.find(image.camera);
    if (intrinsics == model.cameras.end()) return nullptr;
    solving->cameras.push_back({inverse(image.cam_from_world), intrinsics->second});
    middle += solving->cameras.back().world_from_cam.translation();
    up -= solving->cameras.back().world_from_cam.linear().col(1);  // pictures have y down
  }
  middle /= double(model.images.size());
  std::vector<double> distances;
  for (const SolvingCameras::Placed& camera : solving->cameras)
    distances.push_back((camera.world_from_cam.translation() - middle).norm());
  const double radius = median(distances);
  if (!(radius > 0) || !(up.norm() > 0)) return nullptr;
  const Eigen::Matrix3d turn = upright(up);
  const auto placed = [&](const Vec3d& at) -> Vec3d { return turn * (at - middle) * (kRadius / radius); };
  for (SolvingCameras::Placed& camera : solving->cameras) {
    camera.world_from_cam.translation() = placed(camera.world_from_cam.translation());
    camera.world_from_cam.linear() = turn * camera.world_from_cam.linear();
  }
  std::vector<std::int64_t> keys;  // sorted, so that the same points stay from one look to the next
  for (const auto& [key, point] : model.points) keys.push_back(key);
  std::ranges::sort(keys);
  const std::size_t stride = (keys.size() + kSolvingPoints - 1) / kSolvingPoints;
  for (std::size_t i = 0; i < keys.size(); i += stride) {
    const Vec3d at = placed(model.points.at(keys[i]).position);
    if (at.norm() < kFarthestDrawn) solving->points.push_back(at);
  }
  distances.clear();
  for (const Vec3d& point : solving->points) distances.push_back(point.norm());
  solving->reach = std::clamp(quantile(distances, kReachQuantile), kRadius, kFarthestReach);
  return solving;
}

std::shared_ptr<const SolvingCameras> read_solving_cameras(const std::filesystem::path& work) {
  const auto model = solve_so_far(work);
  return model ? solving_cameras(*model) : nullptr;
}

}  // namespace likeness::ui
