// Rest, medoid and percentiles over the views of a training set.
#include "core/train/capture_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/camera/mosaic.h"
#include "core/head/action_amounts.h"

namespace likeness {
namespace {

constexpr double kMetresPerRadian = 0.17;

}  // namespace

std::span<const TrainingView> own_views(const TrainingSet& set) {
  const auto further =
      std::ranges::find_if(set.views, [](const TrainingView& view) { return view.further_clip != 0; });
  return {set.views.data(), std::size_t(further - set.views.begin())};
}

PlateOfView plate_of(const TrainingSet& set, const TrainingView& view) {
  static const Image8 none;
  if (!view.has_plate) return {&none, &none};
  const auto camera_of = [](const std::optional<Camera>& camera) { return camera ? &*camera : nullptr; };
  if (view.further_clip == 0) return {&set.plate, &set.plate_known, camera_of(set.plate_camera)};
  const auto own = set.further_plates.find(view.further_clip);
  if (own == set.further_plates.end()) return {&none, &none};
  return {&own->second.rgb, &own->second.known, camera_of(own->second.camera)};
}

PlatePicture plate_picture(const TrainingSet& set, const TrainingView& view) {
  const PlateOfView plate = plate_of(set, view);
  if (plate.rgb->empty() || plate.camera == nullptr) return {*plate.rgb, *plate.known};
  PlatePicture seen;
  seen.rgb = mosaic_seen_by({*plate.rgb, *plate.known, *plate.camera}, view.camera, &seen.known);
  return seen;
}

Articulation typical_articulation(const TrainingSet& set) {
  if (set.neutral.expression.size() == set.model.expression_count()) return set.neutral;
  Articulation typical = neutral_articulation(set.model);
  const Eigen::Index e = typical.expression.size();
  std::vector<float> values(set.views.size());
  for (Eigen::Index i = 0; i < e + 9; ++i) {
    for (std::size_t v = 0; v < values.size(); ++v)
      values[v] = articulation_vector(set.views[v].pose.articulation)[i];
    const float median = quantile(values, 0.5);
    if (i < e)
      typical.expression[i] = median;
    else if (i < e + 3)
      typical.jaw[i - e] = median;
    else if (i < e + 6)
      typical.left_eye[i - e - 3] = median;
    else
      typical.right_eye[i - e - 6] = median;
  }
  return typical;
}

std::size_t typical_view(const TrainingSet& set) {
  const std::span<const TrainingView> views = own_views(set);
  const std::size_t count = views.size(), stride = std::max<std::size_t>(1, count / 200);
  std::vector<Pose> poses(count);
  for (std::size_t v = 0; v < count; ++v)
    poses[v] = views[v].camera.cam_from_world * views[v].pose.world_from_head;
  double best = std::numeric_limits<double>::infinity();
  std::size_t chosen = 0;
  for (std::size_t v = 0; v < count; v += stride) {
    double sum = 0;
    for (std::size_t w = 0; w < count; w += stride) {
      const Pose difference = inverse(poses[v]) * poses[w];
      sum += difference.translation().norm() + kMetresPerRadian * rotation_angle(difference.linear());
    }
    if (sum < best) best = sum, chosen = v;
  }
  return chosen;
}

std::vector<ActionRange> action_ranges(const TrainingSet& set) {
  constexpr float kShown = 0.2f;
  const ActionBasis basis = action_basis(set.model);
  std::vector<std::vector<float>> values(basis.actions.size());
  for (const TrainingView& view : set.views) {
    const Eigen::VectorXf amounts = action_amounts(basis, view.pose.articulation);
    for (std::size_t a = 0; a < values.size(); ++a) values[a].push_back(amounts[Eigen::Index(a)]);
  }
  std::vector<ActionRange> ranges;
  for (std::size_t a = 0; a < values.size(); ++a) {
    ActionRange range{basis.actions[a].name, quantile(values[a], 0.02), quantile(values[a], 0.98)};
    const int bins = int(range.histogram.size());
    const float share = 1 / float(std::max<std::size_t>(1, values[a].size()));
    for (const float value : values[a]) {
      range.coverage += value > kShown ? share : 0;
      range.histogram[std::size_t(std::clamp(int(std::floor(value * float(bins))), 0, bins - 1))] += share;
    }
    ranges.push_back(std::move(range));
  }
  return ranges;
}

Avatar capture_avatar(const TrainingSet& set, const ConditionMap& map, float warp_cell,
                      const NeckZone& neck) {
  Avatar avatar;
  avatar.condition = map;
  avatar.person = set.person;
  avatar.detail = set.detail;
  avatar.torso_modes = set.torso_modes;
  avatar.head_model_name = set.model.name;
  avatar.head_model_hash = set.model.hash;
  avatar.neutral = typical_articulation(set);
  avatar.seen = action_ranges(set);
  avatar.attributes = set.attributes;
  avatar.warp_cell = warp_cell;
  avatar.neck = neck;
  const TrainingView& view = set.views[typical_view(set)];
  avatar.world_from_head = view.pose.world_from_head;
  avatar.world_from_torso = view.pose.world_from_torso;
  avatar.intrinsics = view_of_part(view.camera, view.inside).intrinsics;
  avatar.cam_from_world = view.camera.cam_from_world;
  const Image8 plate = plate_picture(set, view).rgb;
  avatar.plate = plate.empty() ? plate : crop(plate, view.inside);
  if (set.plate_camera) avatar.mosaic = Mosaic{set.plate, set.plate_known, *set.plate_camera};
  avatar.size = set.size;
  return avatar;
}

}  // namespace likeness
