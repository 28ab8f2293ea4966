// --camera and --pose of the verbs that make pictures.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/project/open_avatar.h"

namespace likeness::app {

struct CameraOptions {
  std::string camera = "still";  // still, orbit, or a file of cameras to follow
  double orbit_deg = 0;          // half the angle; 0: as far as the avatar holds

  bool rests() const { return camera == "still"; }
  bool follows_a_file() const { return camera != "still" && camera != "orbit"; }
};
void add_camera_options(CLI::App& verb, CameraOptions& options);

// One camera for each of these times; a file has as many as it has. Those of the project's own solve are
// brought to metres.
Result<std::vector<Camera>> film_cameras(const CameraOptions& options, const OpenedAvatar& opened,
                                         std::span<const double> times_s);

// A mesh has none.
Result<void> check_camera(const CameraOptions& options, const std::filesystem::path& out);

// --pose yaw,pitch,roll in degrees; empty where it was not given.
void add_pose_option(CLI::App& verb, std::vector<double>& pose_deg, const std::string& about);
std::array<double, 3> turn_of(const std::vector<double>& pose_deg);  // rad

}  // namespace likeness::app
