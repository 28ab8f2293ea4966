// Rotations after their mean, ratios of focal lengths after their median: see view_truth.h.
#include "core/lab/truth/view_truth.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/base/mean_rotation.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr double kInDegrees = 180 / std::numbers::pi;
constexpr int kGrid = 5;  // pixels along each side whose mapping is compared

// One frame in both, at the true picture's size.
struct ViewPair {
  Camera found, truth;
  int place = 0;
};

int place_of(const std::vector<TrueShot>& shots, int frame) {
  for (const TrueShot& shot : shots)
    if (frame >= shot.first && frame <= shot.last) return shot.place;
  return 0;
}

std::vector<int> frames_of(const CameraSet& found, const CameraSet& truth) {
  std::vector<int> frames;
  for (const Camera& camera : truth.rests() ? found.cameras : truth.cameras) frames.push_back(camera.frame);
  return frames;
}

std::vector<ViewPair> pairs_of(const CameraSet& found, const CameraSet& truth,
                               const std::vector<TrueShot>& shots, const std::vector<int>& frames) {
  std::vector<ViewPair> pairs;
  for (const int frame : frames) {
    const Camera *ours = find_camera(found, frame), *known = find_camera(truth, frame);
    if (ours && known)
      pairs.push_back({resized(*ours, known->intrinsics.width), *known, place_of(shots, frame)});
  }
  return pairs;
}

// Where the pixel of one frame's distant background lies in another frame.
std::optional<Vec2d> mapped(const Camera& from, const Camera& to, const Vec2d& pixel) {
  const Vec3d direction = to.cam_from_world.linear() * from.cam_from_world.linear().transpose() *
                          ray_direction(from.intrinsics, pixel);
  if (direction.z() < 0.1 * direction.norm()) return std::nullopt;
  return project<double>(to.intrinsics, direction);
}

// Of pixels that lie within the picture of the reference.
void add_mapping(const ViewPair& pair, const ViewPair& reference, std::vector<double>& errors) {
  const Intrinsics& k = pair.truth.intrinsics;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const Vec2d pixel((i + 0.5) * k.width / kGrid, (j + 0.5) * k.height / kGrid);
      const auto at = mapped(pair.truth, reference.truth, pixel);
      if (!at || at->x() < 0 || at->y() < 0 || at->x() > k.width || at->y() > k.height) continue;
      const auto ours = mapped(pair.found, reference.found, pixel);
      errors.push_back(ours ? (*ours - *at).norm() : double(k.width));
    }
}

// Of one place: turns after the mean of what lies between the two worlds.
void add_turns(const std::vector<ViewPair>& pairs, std::vector<double>& turns) {
  std::vector<Mat3d> between;  // found world from true world
  for (const ViewPair& p : pairs)
    between.push_back(p.found.cam_from_world.linear().transpose() * p.truth.cam_from_world.linear());
  const Mat3d shared = mean_rotation(between);
  for (const Mat3d& own : between)
    turns.push_back(rotation_angle(Mat3d(shared.transpose() * own)) * kInDegrees);
}

}  // namespace

std::optional<ViewErrors> compare_views(const CameraSet& found, const CameraSet& truth,
                                        const std::vector<TrueShot>& shots) {
  if (found.cameras.empty() || truth.cameras.empty()) return std::nullopt;
  ViewErrors errors;
  const std::vector<int> frames = frames_of(found, truth);
  const std::vector<ViewPair> pairs = pairs_of(found, truth, shots, frames);
  errors.wanted = int(frames.size());
  errors.found = int(pairs.size());
  if (pairs.empty() || (pairs.size() < 2 && !(found.rests() && truth.rests()))) return std::nullopt;
  std::map<int, std::vector<ViewPair>> places;
  std::vector<double> ratios, zooms, turns, mapping;
  for (const ViewPair& p : pairs) {
    places[p.place].push_back(p);
    ratios.push_back(p.found.intrinsics.fx / p.truth.intrinsics.fx);
  }
  const double usual = median(ratios);
  for (const double ratio : ratios) zooms.push_back(100 * std::abs(ratio / usual - 1));
  for (const auto& [place, of_place] : places) {
    add_turns(of_place, turns);
    for (const ViewPair& p : of_place) add_mapping(p, of_place.front(), mapping);
  }
  errors.turn_max_deg = *std::ranges::max_element(turns);
  errors.turn_median_deg = median(std::move(turns));
  errors.zoom_max_percent = *std::ranges::max_element(zooms);
  errors.zoom_median_percent = median(std::move(zooms));
  errors.focal_percent = 100 * (usual - 1);
  errors.mapping_median_px = quantile(mapping, 0.5);
  errors.mapping_p95_px = quantile(mapping, 0.95);
  return errors;
}

}  // namespace likeness
