// See register_clips.h.
#include "core/train/register_clips.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/render/render.h"
#include "core/train/field_fit.h"
#include "core/train/refine_track.h"

namespace likeness {
namespace {

constexpr float kSolid = 0.95f;  // opacity of pixels whose colour is purely the head's
constexpr int kLightShare = 8;   // fraction of a picture's side that is the radius within which light is even
constexpr float kDark = 0.03f;   // below this counts as unlit, so that black is not amplified

// (side, side) mean over squares of 2 radius + 1, twice, one axis at a time; what lies outside counts as
// zero.
void smooth(std::vector<float>& values, int width, int height, int radius) {
  std::vector<float> line;
  const auto pass = [&](std::size_t first, std::size_t step, int count) {
    line.assign(std::size_t(count), 0);
    for (int i = 0; i < count; ++i) line[std::size_t(i)] = values[first + std::size_t(i) * step];
    double sum = 0;
    for (int i = -radius; i < count; ++i) {
      if (i + radius < count) sum += line[std::size_t(i + radius)];
      if (i - radius - 1 >= 0) sum -= line[std::size_t(i - radius - 1)];
      if (i >= 0) values[first + std::size_t(i) * step] = float(sum / (2 * radius + 1));
    }
  };
  for (int twice = 0; twice < 2; ++twice) {
    for (int y = 0; y < height; ++y) pass(std::size_t(y) * std::size_t(width), 1, width);
    for (int x = 0; x < width; ++x) pass(std::size_t(x), std::size_t(width), height);
  }
}

// The view's picture in the avatar's light, over white like the rendering fitted to it, so that the outline
// counts. A light is a factor per colour channel that varies slowly over the picture; faster changes are
// left, since features and edges say where the head is.
Image8 in_avatars_light(const TrainingView& view, const Avatar& avatar, const RenderState& state) {
  if (view.alpha.empty()) return view.rgb;  // the head cannot be separated
  const int width = view.rgb.width, height = view.rgb.height;
  const int radius = std::max(1, width / kLightShare);
  const RenderedFrame seen = render_frame(avatar, view.camera, state);
  const Image8 alpha = to_image(view.alpha);
  Image8 matched = view.rgb;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float> here(alpha.data.size(), 0), there = here, counted = here;
    for (std::size_t i = 0; i < alpha.data.size(); ++i) {
      if (seen.rgba.data[4 * i + 3] < kSolid || alpha.data[i] < 255) continue;
      here[i] = float(view.rgb.data[3 * i + c]) / 255, there[i] = seen.rgba.data[4 * i + c], counted[i] = 1;
    }
    for (std::vector<float>* values : {&here, &there, &counted}) smooth(*values, width, height, radius);
    for (std::size_t i = 0; i < alpha.data.size(); ++i) {
      const float gain = (there[i] + kDark * counted[i] + 1e-6f) / (here[i] + kDark * counted[i] + 1e-6f);
      const float value = std::min(255.f, gain * float(matched.data[3 * i + c])),
                  share = float(alpha.data[i]) / 255;
      matched.data[3 * i + c] = std::uint8_t(std::lround(share * value + (1 - share) * 255));
    }
  }
  return matched;
}

// Pose of the head frame as this view alone sees it, in the tracked one: turn (rotation vector) and shift.
using Motion = std::array<double, kPoseChange>;

Motion view_motion(const TrainingView& view, const Avatar& avatar, const AvatarRig& rig,
                   const RegisterOptions& options, std::uint64_t seed) {
  const AvatarPose tracked = view.pose;
  Image8 region = head_box(view, rig);
  for (int y = 0; y < region.height; ++y)
    for (int x = 0; x < region.width; ++x)
      if (!view.teaches.empty() && view.teaches.at(x, y) == 0) *region.at(x, y) = 0;
  const Image8 matched = in_avatars_light(view, avatar, pose_avatar(rig, tracked)), none;
  const FieldFitOptions fit{options.pixels, options.iterations, 0, seed};
  const Eigen::VectorXd change =
      fit_to_field(avatar, rig, view.camera, {&matched, &none, &region}, tracked, {}, fit).change;
  const Pose moved = changed_pose(tracked, avatar.condition, change).world_from_head;
  const Pose motion = inverse(tracked.world_from_head) * moved;
  const Vec3d turn = vector_from_turn(motion.linear()), shift = motion.translation();
  return {turn.x(), turn.y(), turn.z(), shift.x(), shift.y(), shift.z()};
}

// The views' median, or the identity if it is implausible.
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
  if (turn.norm() > 1e-12) motion.linear() = rotation_about(turn.normalized(), turn.norm());
  motion.translation() = shift;
  return motion;
}

// The change (core/train/field_fit.h) that moves a view's head frame accordingly.
Eigen::VectorXd change_of(const TrainingView& view, const Pose& motion) {
  const Pose moved = view.pose.world_from_head * motion;
  const Vec3d turn = vector_from_turn(moved.linear() * view.pose.world_from_head.linear().transpose());
  Eigen::VectorXd change(kPoseChange);
  change << turn, moved.translation() - view.pose.world_from_head.translation();
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
