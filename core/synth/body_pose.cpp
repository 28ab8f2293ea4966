// Each part of the performance is a cycle, played faster in short clips and repeated in long ones, so that
// every clip shows every expression. The last tenth is a cycle of its own that repeats everything, so that
// held-out frames there show it all.
#include "core/synth/body_pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/synth/easing.h"

namespace likeness {
namespace {

constexpr double kOneDegree = std::numbers::pi / 180, kCycle = 2 * std::numbers::pi;
constexpr double kFirstCycleSeconds = 3.6, kSecondCycleSeconds = 6.4, kFinaleSeconds = 3.2;
constexpr double kFinaleShare = 0.10;  // of the clip

Pose about(const Vec3d& pivot, const Mat3d& rotation, const Vec3d& shift) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation;
  pose.translation() = pivot - rotation * pivot + shift;
  return pose;
}

}  // namespace

Mat3d head_turn(double yaw, double pitch, double roll) {
  return (Eigen::AngleAxisd(yaw, Vec3d::UnitY()) * Eigen::AngleAxisd(pitch, Vec3d::UnitX()) *
          Eigen::AngleAxisd(roll, Vec3d::UnitZ()))
      .toRotationMatrix();
}

int moving_frames(const DemoOptions& options) {
  if (options.camera == DemoCamera::walking) return options.frames;
  if (options.camera != DemoCamera::guided) return 0;
  return std::clamp(int(std::lround(options.moving_share * options.frames)), 0, options.frames);
}

int closing_frames(const DemoOptions& options) {
  return std::max(1, int(std::lround(kFinaleShare * options.frames)));
}

Moment moment_of(const DemoOptions& options, double frame) {
  const int moving = moving_frames(options);
  Moment moment;
  moment.walking = frame < moving;
  const int first = moment.walking ? 0 : moving;
  const int count = std::max(1, moment.walking ? moving : options.frames - moving);
  moment.share = (frame - first) / std::max(1, count - 1);
  const double seconds = count / options.frames_per_second;
  const int cycles =
      std::max(1, int(std::lround(seconds / (moment.walking ? kFirstCycleSeconds : kSecondCycleSeconds))));
  const double position = (frame - first) / count * cycles;
  moment.cycle = int(position);
  moment.phase = position - moment.cycle;
  moment.time_s = frame / options.frames_per_second;
  const int closing = closing_frames(options);
  if (!moment.walking && frame >= options.frames - closing) {
    const int repeats = std::max(1, int(std::lround(closing / options.frames_per_second / kFinaleSeconds)));
    const double at = (frame - (options.frames - closing)) / closing * repeats;
    moment.finale = at - std::floor(at);
  }
  return moment;
}

BodyPose body_pose(const DemoOptions& options, const HeadShape& shape, double frame) {
  BodyPose body;
  const Moment m = moment_of(options, frame);
  if (m.walking && !options.restless_head) return body;
  // In the first part it returns to rest before the second begins; where there is no second, it need not.
  const bool returns = m.walking && options.camera == DemoCamera::guided;
  const double end = returns ? ease((1 - m.share) / 0.08) : 1;
  const double within = std::min(1.0, options.head_within_deg / kWidestTurn_deg);
  const double start = within * ease((m.cycle + m.phase) / 0.08) * end, p = kCycle * m.phase;
  // From cycle to cycle the turns come together differently. The guided film keeps its steps there.
  const double c = options.camera == DemoCamera::guided ? m.cycle : m.cycle + m.phase;
  const Vec3d neck = shape.joints[kNeck].cast<double>();
  const double yaw = 30 * kOneDegree * std::sin(p) * start;
  const double pitch = 12 * kOneDegree * std::sin(2 * p + 0.9 + 0.8 * c) * start;
  const double roll = 7 * kOneDegree * std::sin(3 * p + 0.4 + c) * start;
  const Vec3d shift =
      Vec3d(0.006 * std::sin(p + 0.3), 0.002 * std::sin(2 * p), 0.006 * std::sin(2 * p + 1)) * start;
  if (!options.still_torso) {
    const Vec3d waist = neck - Vec3d(0, 0.35, 0.02);
    body.world_from_torso = about(
        waist,
        head_turn(1.2 * kOneDegree * std::sin(p + 0.2) * start, 0.5 * kOneDegree * std::sin(2 * p) * start,
                  0.8 * kOneDegree * std::sin(p + 1.1) * start),
        Vec3d::Zero());
  }
  body.world_from_head = body.world_from_torso * about(neck, head_turn(yaw, pitch, roll), shift);
  return body;
}

}  // namespace likeness
