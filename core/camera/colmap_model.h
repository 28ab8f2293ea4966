// A sparse reconstruction as colmap stores it (cameras.bin, images.bin, points3D.bin), read defensively.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/camera/camera.h"

namespace likeness {

struct ColmapObservation {
  Vec2d pixel;              // px, picture covering [0, width]
  std::int64_t point = -1;  // key into ColmapModel::points, -1 where the feature has no 3-D point
};

struct ColmapImage {
  std::string name;
  int camera = 0;  // key into ColmapModel::cameras
  Pose cam_from_world = Pose::Identity();
  std::vector<ColmapObservation> observations;
};

struct ColmapPoint {
  Vec3d position;
  double error_px = 0;
  int views = 0;
};

struct ColmapModel {
  std::map<int, Intrinsics> cameras;
  std::vector<ColmapImage> images;  // ascending name
  std::unordered_map<std::int64_t, ColmapPoint> points;
};

// Every count is checked against the file's size before memory is taken.
Result<ColmapModel> read_colmap_model(const std::filesystem::path& folder);

// Replaces the cameras of a stored model: each gets colmap's OPENCV model, with the eight numbers of its
// intrinsics, whatever model it had.
Result<void> write_colmap_cameras(const std::filesystem::path& folder,
                                  const std::map<int, Intrinsics>& cameras);

// Mean distance of observations to their projected points, px; each observation counts once.
double mean_reprojection_px(const ColmapModel& model);

// Median over the points of the largest angle, rad, between the first picture that shows a point and another:
// on which its depth depends. 0 if there are no points.
double median_parallax(const ColmapModel& model);

}  // namespace likeness
