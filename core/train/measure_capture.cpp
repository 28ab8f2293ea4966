// Measures of a capture from a training set's views: see choose_parts.h.
#include <algorithm>
#include <cmath>

#include "core/base/mean_rotation.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/train/choose_parts.h"
#include "core/train/condition_map.h"
#include "core/train/exposure.h"
#include "core/train/volumes.h"

namespace likeness {
namespace {

constexpr std::size_t kLookedAt = 64;  // views whose pixels are read, spread evenly
constexpr int kEvery = 2;              // pixels along an axis
constexpr std::uint8_t kPerson = 128;
constexpr double kBesideNeck = 0.1;  // m from the neck's middle: past any jaw

// The torso frame's height y as it lies in a picture: a point of it, and the way down by kStep.
struct Level {
  Vec2d at = Vec2d::Zero(), down = Vec2d::Zero();  // px
  bool ahead = false;
};
constexpr double kStep = 0.05;  // m

Level level_in(const TrainingView& view, double y) {
  const Pose cam_from_torso = view.camera.cam_from_world * view.pose.world_from_torso;
  const Vec3d here = cam_from_torso * Vec3d(0, y, 0), below = cam_from_torso * Vec3d(0, y - kStep, 0);
  if (here.z() < 0.05 || below.z() < 0.05) return {};
  Level level;
  level.at = project<double>(view.camera.intrinsics, here);
  level.down = project<double>(view.camera.intrinsics, below) - level.at;
  level.ahead = true;
  return level;
}

// Of the picture: the person's pixels beyond the base of the neck, in the direction in which the torso lies,
// and those beside the neck from the chin on, the shoulders of a picture that ends there.
double torso_share(const TrainingView& view, double base, double chin) {
  if (view.alpha.empty()) return 0;
  const Level neck = level_in(view, base), face = level_in(view, chin);
  if (!neck.ahead || !face.ahead) return 0;
  const double beside = kBesideNeck / kStep * neck.down.squaredNorm();
  std::size_t read = 0, torso = 0;
  for (int y = 0; y < view.alpha.height; y += kEvery)
    for (int x = 0; x < view.alpha.width; x += kEvery, ++read) {
      if (view.alpha.at(x, y) < kPerson) continue;
      const Vec2d px(x + 0.5, y + 0.5), off = px - neck.at;
      torso +=
          neck.down.dot(off) > 0 || (face.down.dot(px - face.at) > 0 &&
                                     std::abs(neck.down.x() * off.y() - neck.down.y() * off.x()) > beside);
    }
  return double(torso) / double(std::max<std::size_t>(read, 1));
}

double span_of(const std::vector<double>& angles) { return quantile(angles, 0.98) - quantile(angles, 0.02); }

}  // namespace

CaptureMeasures measure_capture(const TrainingSet& set, const HeadShape& shape) {
  CaptureMeasures m;
  const std::span<const TrainingView> own = own_views(set);
  m.size = set.size;
  m.frames = int(own.size()), m.further_frames = int(set.views.size() - own.size());
  m.torso_followed = set.has_torso;
  m.has_plate = !set.plate.empty(), m.has_mosaic = set.plate_camera.has_value();

  // -- Where the camera stands as seen from the head.
  std::vector<double> yaw, pitch;
  for (const TrainingView& view : own) {
    const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
    const Vec3d to_camera = inverse(cam_from_head).translation().normalized();
    yaw.push_back(std::atan2(to_camera.x(), to_camera.z()));
    pitch.push_back(std::asin(std::clamp(to_camera.y(), -1.0, 1.0)));
    m.plate_share += view.has_plate && m.has_plate ? 1.0 / double(own.size()) : 0;
  }
  m.yaw = span_of(yaw), m.pitch = span_of(pitch);
  std::vector<Mat3d> turns;
  for (const TrainingView& view : set.views)
    turns.push_back((view.camera.cam_from_world * view.pose.world_from_head).linear());
  m.turn = turn_about_mean(turns);

  // -- What the face does.
  std::vector<Articulation> articulations;
  for (const TrainingView& view : set.views) articulations.push_back(view.pose.articulation);
  const ArticulationSpread spread = articulation_spread(set.model, shape, articulations);
  m.face_motion = spread.face, m.gaze_pitch = spread.gaze_pitch, m.gaze_yaw = spread.gaze_yaw;

  // -- Pixels.
  const double base = neck_base(set.model, shape);
  const double chin =
      landmark_positions(set.model, pose_head(set.model, shape, neutral_articulation(set.model)))[8].y();
  const std::size_t looked_at = std::min(own.size(), kLookedAt);
  for (std::size_t i = 0; i < looked_at; ++i) {
    const TrainingView& view = own[i * own.size() / looked_at];
    m.torso_share += torso_share(view, base, chin) / double(looked_at);
  }
  m.exposures = view_exposures(set);
  if (m.has_plate) m.light_drift = exposure_drift(m.exposures);
  return m;
}

}  // namespace likeness
