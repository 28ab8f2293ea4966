// See camera_option.h.
#include "app/camera_option.h"

#include <algorithm>
#include <numbers>

#include "core/direct/camera_keys.h"
#include "core/direct/seen_limits.h"
#include "core/export/head_mesh.h"
#include "core/render/camera_path.h"
#include "core/scene/track.h"

namespace likeness::app {

void add_camera_options(CLI::App& verb, CameraOptions& options) {
  verb.add_option("--camera", options.camera, "still, orbit, or a cameras.json to follow");
  verb.add_option("--orbit", options.orbit_deg,
                  "Half angle of the orbit, degrees; default: as far as the avatar holds, to each side")
      ->check(CLI::Range(1.0, 180.0));
}

namespace {

constexpr double kUnknownOrbit_deg = 30;  // of an avatar whose range is not known

// To both sides of the typical view, degrees.
ValueRange orbit_of(const CameraOptions& options, const OpenedAvatar& opened) {
  if (options.rests()) return {};
  const float own = float(options.orbit_deg > 0 ? options.orbit_deg : kUnknownOrbit_deg);
  if (options.orbit_deg > 0 || !opened.avatar.holds) return {-own, own};
  return orbit_range(seen_limits(opened.avatar, opened.model, {}), true);
}

}  // namespace

Result<std::vector<Camera>> film_cameras(const CameraOptions& options, const OpenedAvatar& opened,
                                         std::span<const double> times_s) {
  const Avatar& avatar = opened.avatar;
  if (!options.follows_a_file()) {
    constexpr double kRadians = std::numbers::pi / 180;
    const ValueRange orbit = orbit_of(options, opened);
    std::vector<Camera> cameras;
    for (const double yaw : orbit_yaws(times_s, kRadians * orbit.low, kRadians * orbit.high))
      cameras.push_back(orbit_camera(avatar, avatar.world_from_head, yaw));
    return cameras;
  }
  auto set = read_cameras(options.camera);
  if (!set) return set.error();
  const Intrinsics& first = set->cameras.front().intrinsics;
  const bool one_size = std::ranges::all_of(set->cameras, [&](const Camera& camera) {
    return camera.intrinsics.width == first.width && camera.intrinsics.height == first.height;
  });
  if (!one_size) {
    return Error{ErrorCode::bad_input, "The cameras to follow differ in picture size.",
                 "Give every camera of the file the same width and height.", options.camera};
  }
  if (set->scale == CameraScale::arbitrary) {  // the project's own solve, whose scale is in the track
    const auto track = read_track(track_path(opened.project));
    if (!track) return track.error();
    for (Camera& camera : set->cameras) camera.cam_from_world.translation() *= track->metres_per_unit;
  }
  return std::move(set->cameras);
}

Result<void> check_camera(const CameraOptions& options, const std::filesystem::path& out) {
  if (options.rests() || !is_mesh_name(out)) return {};
  return Error{ErrorCode::bad_input, "A mesh has no camera.",
               "Leave out --camera, or name pictures as --out.", out.string()};
}

void add_pose_option(CLI::App& verb, std::vector<double>& pose_deg, const std::string& about) {
  verb.add_option("--pose", pose_deg, about)->delimiter(',')->expected(3);
}

std::array<double, 3> turn_of(const std::vector<double>& pose_deg) {
  std::array<double, 3> turn{};
  for (std::size_t i = 0; i < std::min(turn.size(), pose_deg.size()); ++i)
    turn[i] = pose_deg[i] * std::numbers::pi / 180;
  return turn;
}

}  // namespace likeness::app
