// The cameras of a clip while they are being solved: as far as the solve has come, turned to be looked at.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/linalg.h"
#include "core/camera/camera.h"
#include "core/camera/colmap_model.h"

namespace likeness::ui {

// A solve knows neither metres nor up: the cameras' middle is the origin, they stand 0.5 from it in the
// median, and y is the mean of what is up in their pictures.
struct SolvingCameras {
  struct Placed {
    Pose world_from_cam = Pose::Identity();
    Intrinsics intrinsics;
  };
  std::vector<Placed> cameras;  // in the order of the clip
  std::vector<Vec3d> points;    // at most kSolvingPoints of them, none far beyond the cameras
  double reach = 0;             // from the origin: what is worth being looked at, cameras and most points
};
inline constexpr std::size_t kSolvingPoints = 4000;

// None without two cameras at different places.
std::shared_ptr<const SolvingCameras> solving_cameras(const ColmapModel& model);
// Of a camera solve at work in that folder. Reads files.
std::shared_ptr<const SolvingCameras> read_solving_cameras(const std::filesystem::path& work);

}  // namespace likeness::ui
