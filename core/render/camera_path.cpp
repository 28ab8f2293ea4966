// Orbit cameras, head turns and articulations.
#include "core/render/camera_path.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/base/check.h"
#include "core/base/rigid.h"

namespace likeness {

Vec3d head_centre(const Avatar& avatar) {
  const OccupancyGrid& grid = avatar.head.occupancy;
  const FieldCube& cube = avatar.head.cube;
  Vec3d low = Vec3d::Constant(1e9), high = Vec3d::Constant(-1e9);
  for (int z = 0; z < grid.resolution; ++z)
    for (int y = 0; y < grid.resolution; ++y)
      for (int x = 0; x < grid.resolution; ++x)
        if (grid.occupied(x, y, z)) {
          const Vec3d p(x + 0.5, y + 0.5, z + 0.5);
          low = low.cwiseMin(p), high = high.cwiseMax(p);
        }
  Vec3d unit = Vec3d::Constant(0.5);
  if (grid.resolution > 0 && low.x() <= high.x()) unit = 0.5 * (low + high) / grid.resolution;
  return cube.origin.cast<double>() + unit * double(cube.side);
}

Camera orbit_camera(const Avatar& avatar, const Pose& world_from_head, double yaw, double pitch) {
  // Rotating the camera by R about the centre is the same as rotating the world by R^-1 about it.
  const Vec3d centre = world_from_head * head_centre(avatar);
  const Vec3d up = world_from_head.linear() * Vec3d::UnitY();
  const Vec3d side = world_from_head.linear() * Vec3d::UnitX();
  Pose turn = Pose::Identity();
  turn.linear() = (Eigen::AngleAxisd(yaw, up) * Eigen::AngleAxisd(-pitch, side)).toRotationMatrix();
  turn.translation() = centre - turn.linear() * centre;
  return {-1, avatar.intrinsics, avatar.cam_from_world * inverse(turn)};
}

Pose turned_head(const Pose& world_from_head, const Vec3d& pivot_in_head, double yaw, double pitch,
                 double roll) {
  Pose turn = Pose::Identity();
  turn.linear() = (Eigen::AngleAxisd(yaw, Vec3d::UnitY()) * Eigen::AngleAxisd(pitch, Vec3d::UnitX()) *
                   Eigen::AngleAxisd(roll, Vec3d::UnitZ()))
                      .toRotationMatrix();
  turn.translation() = pivot_in_head - turn.linear() * pivot_in_head;
  return world_from_head * turn;
}

std::vector<double> steady_times(int frames, double frames_per_second) {
  LIKENESS_CHECK(frames > 0, "%d frames", frames);
  constexpr double kUsual = 25;
  std::vector<double> times_s;
  for (int i = 0; i < frames; ++i)
    times_s.push_back(i / (frames_per_second > 0 ? frames_per_second : kUsual));
  return times_s;
}

std::vector<double> orbit_yaws(std::span<const double> times_s, double low, double high) {
  LIKENESS_CHECK(!times_s.empty(), "an orbit without frames");
  const double length_s = times_s.back() - times_s.front();
  std::vector<double> yaws;
  for (const double time_s : times_s) {
    const double share = length_s > 0 ? (time_s - times_s.front()) / length_s : 0;
    const double wave = std::sin(2 * std::numbers::pi * share);
    yaws.push_back(wave * (wave < 0 ? -low : high));
  }
  return yaws;
}

Result<Articulation> articulate(const HeadModel& model, const Articulation& neutral,
                                const std::vector<std::pair<std::string, float>>& actions) {
  Articulation out = neutral;
  for (const auto& [name, value] : actions) {
    const NamedAction* found = find_action(model, name);
    if (!found) {
      std::string known;
      for (const NamedAction& action : model.actions) known += (known.empty() ? "" : ", ") + action.name;
      return Error{ErrorCode::bad_input, fmt::format("The head model has no action named '{}'.", name),
                   known.empty() ? "Use a head model with named actions." : "Choose one of: " + known + ".",
                   model.name};
    }
    add_action(out, *found, value);
  }
  return out;
}

}  // namespace likeness
