// Runs of frames of a moving camera, and how far heads move in them.
#include "core/track/torso/torso_rest.h"

#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr std::size_t kMinFrames = 8;
constexpr double kMinWay = 0.1;                // m that the camera travels
constexpr double kSway = 0.015, kTurn = 0.07;  // m, rad: of a head that is held still
constexpr double kMost = 0.9;                  // of the frames; the others may be poorly tracked
constexpr double kPlainly = 2;                 // times as far: the person moves in that frame

Vec3d centre_of(const Pose& cam_from_world) { return inverse(cam_from_world).translation(); }

bool same_camera(const TorsoFrame& a, const TorsoFrame& b) {
  return a.cam_from_world.matrix() == b.cam_from_world.matrix();
}

double turn_between(const Pose& a, const Pose& b) {
  return rotation_angle(a.linear().transpose() * b.linear());
}

// The frames of a run in which the head holds still; none if it moves most of the time. indices: of
// consecutive usable frames.
std::vector<std::size_t> still_frames(const std::vector<TorsoFrame>& frames,
                                      const std::vector<std::size_t>& indices) {
  Eigen::AlignedBox3d way;
  std::vector<double> along[3];
  std::vector<std::size_t> training;
  for (const std::size_t i : indices) {
    if (frames[i].held_out) continue;
    training.push_back(i);
    way.extend(centre_of(frames[i].cam_from_world));
    for (int k = 0; k < 3; ++k) along[k].push_back(frames[i].world_from_head.translation()[k]);
  }
  if (training.size() < kMinFrames || way.diagonal().norm() < kMinWay) return {};
  Vec3d usual;
  for (int k = 0; k < 3; ++k) usual[k] = median(std::move(along[k]));
  const auto away = [&](std::size_t i) { return (frames[i].world_from_head.translation() - usual).norm(); };
  const Pose& middle = frames[*std::ranges::min_element(training, {}, away)].world_from_head;
  // 1: as far as the sway of a head held still.
  const auto strays = [&](std::size_t i) {
    return std::max(away(i) / kSway, turn_between(middle, frames[i].world_from_head) / kTurn);
  };
  std::vector<double> far;
  for (const std::size_t i : training) far.push_back(strays(i));
  if (quantile(far, kMost) > 1) return {};
  std::vector<std::size_t> still;
  for (const std::size_t i : indices)
    if (strays(i) <= kPlainly) still.push_back(i);
  return still;
}

}  // namespace

std::vector<int> resting_torso(const std::vector<TorsoFrame>& frames) {
  std::vector<int> stretch(frames.size(), -1);
  std::vector<std::size_t> usable, run;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].usable) usable.push_back(i);
  int found = 0;
  const auto finish = [&] {
    const auto still = still_frames(frames, run);
    for (const std::size_t i : still) stretch[i] = found;
    if (!still.empty()) ++found;
    run.clear();
  };
  for (std::size_t k = 0; k < usable.size(); ++k) {
    const bool stood = k > 0 && same_camera(frames[usable[k - 1]], frames[usable[k]]);
    const bool stands = k + 1 < usable.size() && same_camera(frames[usable[k]], frames[usable[k + 1]]);
    if (stood || stands)
      finish();
    else
      run.push_back(usable[k]);
  }
  finish();
  return stretch;
}

}  // namespace likeness
