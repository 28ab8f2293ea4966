// See solved_points.h.
#include "core/project/solved_points.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/base/files.h"
#include "core/camera/colmap.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr int kMinViews = 3;
constexpr double kMaxError_px = 2;

}  // namespace

Result<std::vector<Vec3f>> solved_points(const Project& project, const Track& track) {
  const fs::path folder = solved_model_path(project.folder / "colmap");
  if (!path_exists(folder / "points3D.bin")) return std::vector<Vec3f>{};
  const auto model = read_colmap_model(folder);
  if (!model) return model.error();
  std::vector<std::pair<std::int64_t, Vec3f>> good;
  for (const auto& [id, point] : model->points)
    if (point.views >= kMinViews && point.error_px <= kMaxError_px)
      good.emplace_back(id, (track.metres_per_unit * point.position).cast<float>());
  std::ranges::sort(good, {}, [](const auto& entry) { return entry.first; });
  const std::size_t count = std::min(good.size(), kMostSolvedPoints);
  std::vector<Vec3f> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(good[i * good.size() / count].second);
  return points;
}

}  // namespace likeness
