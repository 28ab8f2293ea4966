// See register_clips.h.
#include "core/train/register_clips.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/render/render.h"
#include "core/train/field_fit.h"
#include "core/train/refine_track.h"

namespace likeness {
namespace {

constexpr std::size_t kMatchPixels = 1500;
constexpr float kSolid = 0.95f;      // opacity of pixels whose colour is the head's alone
constexpr double kPullToOne = 0.01;  // of a gain, times the pixels
constexpr double kLeastGain = 0.25, kMostGain = 4;

std::vector<std::uint32_t> spread_pixels(const Image8& region, std::size_t count) {
  std::vector<std::uint32_t> inside;
  for (std::size_t i = 0; i < region.data.size(); ++i)
    if (region.data[i] > 127) inside.push_back(std::uint32_t(i));
  const std::size_t n = std::min(inside.size(), count);
  std::vector<std::uint32_t> chosen(n);
  for (std::size_t k = 0; k < n; ++k) chosen[k] = inside[k * inside.size() / n];
  return chosen;
}

// value = gain * picture + offset, of one channel.
struct ChannelMatch {
  double gain = 1, offset = 0;
};

ChannelMatch match_channel(std::span<const std::pair<double, double>> picture_and_value) {
  if (picture_and_value.empty()) return {};
  const double n = double(picture_and_value.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [from, to] : picture_and_value) x += from, y += to, xx += from * from, xy += from * to;
  const double variance = xx / n - x * x / (n * n), covariance = xy / n - x * y / (n * n);
  const double gain = std::clamp((covariance + kPullToOne) / (variance + kPullToOne), kLeastGain, kMostGain);
  return {gain, y / n - gain * x / n};
}

// The view's picture in the avatar's colours, before white as what is fitted to it is: so the outline counts.
Image8 in_avatars_light(const TrainingView& view, const Avatar& avatar, const RenderState& state,
                        const Image8& region) {
  const std::vector<std::uint32_t> pixels = spread_pixels(region, kMatchPixels);
  const std::vector<float> rgba = render_pixels(avatar, view.camera, state, pixels);
  const Image8 alpha = to_image(view.alpha);
  Image8 matched = view.rgb;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<std::pair<double, double>> pairs;
    for (std::size_t i = 0; i < pixels.size(); ++i)
      if (rgba[4 * i + 3] > kSolid && alpha.data[pixels[i]] == 255)
        pairs.emplace_back(double(view.rgb.data[3 * pixels[i] + c]) / 255, double(rgba[4 * i + c]));
    const ChannelMatch match = match_channel(pairs);
    std::array<std::uint8_t, 256> table;
    for (int value = 0; value < 256; ++value)
      table[std::size_t(value)] =
          std::uint8_t(std::lround(std::clamp(match.gain * value + 255 * match.offset, 0.0, 255.0)));
    for (std::size_t i = 0; i < alpha.data.size(); ++i) {
      std::uint8_t& value = matched.data[3 * i + c];
      value = std::uint8_t((alpha.data[i] * table[value] + (255 - alpha.data[i]) * 255 + 127) / 255);
    }
  }
  return matched;
}

// Where this view alone sees the head frame, in the tracked one: turn (rotation vector) and shift.
using Motion = std::array<double, kPoseChange>;

Motion view_motion(const TrainingView& view, const Avatar& avatar, const AvatarRig& rig,
                   const RegisterOptions& options, std::uint64_t seed) {
  const AvatarPose tracked = tracked_pose(view);
  Image8 region = head_box(view, rig);
  for (int y = 0; y < region.height; ++y)
    for (int x = 0; x < region.width; ++x)
      if (!view.teaches.empty() && view.teaches.at(x, y) == 0) *region.at(x, y) = 0;
  const Image8 matched = in_avatars_light(view, avatar, pose_avatar(rig, tracked), region), none;
  const FieldFitOptions fit{options.pixels, options.iterations, 0, seed};
  const Eigen::VectorXd change =
      fit_to_field(avatar, rig, view.camera, {&matched, &none, &region}, tracked, {}, fit).change;
  const Pose moved = changed_pose(tracked, avatar.condition, change).world_from_head;
  const Pose motion = tracked.world_from_head.inverse() * moved;
  const Eigen::AngleAxisd turn(motion.linear());
  const Vec3d axis = turn.angle() * turn.axis(), shift = motion.translation();
  return {axis.x(), axis.y(), axis.z(), shift.x(), shift.y(), shift.z()};
}

// The views' median, or none where it is beyond belief.
Pose common_motion(const std::vector<Motion>& motions, const RegisterOptions& options) {
  Motion median{};
  for (std::size_t k = 0; k < median.size(); ++k) {
    std::vector<double> values;
    for (const Motion& motion : motions) values.push_back(motion[k]);
    median[k] = quantile(values, 0.5);
  }
  const Vec3d turn(median[0], median[1], median[2]), shift(median[3], median[4], median[5]);
  Pose motion = Pose::Identity();
  if (!(turn.norm() <= options.largest_turn) || !(shift.norm() <= options.largest_shift)) return motion;
  if (turn.norm() > 1e-12) motion.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).matrix();
  motion.translation() = shift;
  return motion;
}

// The change (core/train/field_fit.h) that moves a view's head frame so.
Eigen::VectorXd change_of(const TrainingView& view, const Pose& motion) {
  const Pose moved = view.world_from_head * motion;
  const Eigen::AngleAxisd turn(moved.linear() * view.world_from_head.linear().transpose());
  Eigen::VectorXd change(kPoseChange);
  change << turn.angle() * turn.axis(), moved.translation() - view.world_from_head.translation();
  return change;
}

}  // namespace

std::vector<Eigen::VectorXd> register_clips(const TrainingSet& set, const Avatar& avatar,
                                            const AvatarRig& rig, const RegisterOptions& options,
                                            std::stop_token stop) {
  std::map<int, std::vector<std::size_t>> clips;
  for (std::size_t v = own_views(set).size(); v < set.views.size(); ++v)
    clips[set.views[v].further_clip].push_back(v);
  std::vector<Eigen::VectorXd> corrections(set.views.size(), Eigen::VectorXd::Zero(kPoseChange));
  for (const auto& clip : clips) {
    const std::vector<std::size_t>& views = clip.second;
    const std::size_t count = std::min(views.size(), std::size_t(std::max(1, options.views)));
    std::vector<Motion> motions(count);
    parallel_for(count, [&](std::size_t i) {
      if (stop.stop_requested()) return;
      const std::size_t v = views[i * views.size() / count];
      motions[i] = view_motion(set.views[v], avatar, rig, options, options.seed + v);
    });
    if (stop.stop_requested()) return {};
    const Pose motion = common_motion(motions, options);
    for (const std::size_t v : views) corrections[v] = change_of(set.views[v], motion);
  }
  return corrections;
}

}  // namespace likeness
