// Curves of the demo's performance. Each part of the clip is a cycle, played faster in short clips and
// repeated in long ones, so that every clip shows every expression; blinks keep their natural speed. The last
// tenth is a cycle of its own that repeats everything, so that held-out frames there show it all.
#include "core/synth/performance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/rigid.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

constexpr double kDegree = std::numbers::pi / 180, kTurn = 2 * std::numbers::pi;
constexpr double kFirstCycleSeconds = 3.6, kSecondCycleSeconds = 6.4, kFinaleSeconds = 3.2;
constexpr double kFinaleShare = 0.10;  // of the clip

struct Moment {
  bool walking = true;  // the first part of the clip, in which the camera moves
  double share = 0;     // of the part, [0, 1]
  double phase = 0;     // within the cycle, [0, 1)
  int cycle = 0;
  double time_s = 0;
  double finale = -1;  // how far into the closing cycle, [0, 1); < 0 before
};

Moment moment_of(const DemoOptions& options, int frame) {
  const int moving = moving_frames(options);
  Moment moment;
  moment.walking = frame < moving;
  const int first = moment.walking ? 0 : moving;
  const int count = std::max(1, moment.walking ? moving : options.frames - moving);
  moment.share = double(frame - first) / std::max(1, count - 1);
  const double seconds = count / options.frames_per_second;
  const int cycles =
      std::max(1, int(std::lround(seconds / (moment.walking ? kFirstCycleSeconds : kSecondCycleSeconds))));
  const double position = double(frame - first) / count * cycles;
  moment.cycle = int(position);
  moment.phase = position - moment.cycle;
  moment.time_s = frame / options.frames_per_second;
  const int closing = std::max(1, int(std::lround(kFinaleShare * options.frames)));
  if (!moment.walking && frame >= options.frames - closing) {
    const int repeats = std::max(1, int(std::lround(closing / options.frames_per_second / kFinaleSeconds)));
    const double at = double(frame - (options.frames - closing)) / closing * repeats;
    moment.finale = at - std::floor(at);
  }
  return moment;
}

double ease(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (t * (t * 6 - 15) + 10);
}

// Rises over the first 35 % of [from, to], holds, falls over the last 35 %.
double swell(double phase, double from, double to) {
  const double t = (phase - from) / (to - from);
  return ease(t / 0.35) * ease((1 - t) / 0.35);
}

Pose look_at(const Vec3d& eye, const Vec3d& target, double roll) {
  const Vec3d forward = (target - eye).normalized();
  const Vec3d right = forward.cross(Vec3d::UnitY()).normalized();
  Mat3d cam_from_world;
  cam_from_world.row(0) = right;
  cam_from_world.row(1) = forward.cross(right);
  cam_from_world.row(2) = forward;
  cam_from_world = rotation_about(Vec3d::UnitZ(), roll) * cam_from_world;
  Pose pose = Pose::Identity();
  pose.linear() = cam_from_world;
  pose.translation() = -cam_from_world * eye;
  return pose;
}

Camera film(const DemoOptions& options, const Moment& moment, const Vec3d& face, int frame) {
  Camera camera;
  camera.frame = frame;
  Intrinsics& k = camera.intrinsics;
  k.width = options.width;
  k.height = options.height;
  k.fx = k.fy = 1.35 * std::min(options.width, options.height);
  k.cx = 0.5 * options.width;
  k.cy = 0.5 * options.height;
  double yaw = 0, pitch = 0, distance = 0.62, roll = 0;
  Vec3d aim = face + Vec3d(0, -0.035, -0.03);
  if (moment.walking) {
    // From the subject's right round to the left and back to the front, rising and sinking, nearer and
    // farther; the last tenth settles onto the position of the second part.
    const double u = moment.share, settle = 1 - ease((u - 0.86) / 0.14);
    const double sweep =
        u < 0.62 ? -std::cos(std::numbers::pi * u / 0.62) : std::cos(std::numbers::pi * (u - 0.62) / 0.76);
    yaw = 31 * kDegree * sweep * settle;
    pitch = 11 * kDegree * std::sin(kTurn * (1.6 * u + 0.08)) * settle;
    distance += (0.06 * std::sin(kTurn * 1.15 * u + 0.5)) * settle;
    roll = 2.0 * kDegree * std::sin(kTurn * 1.3 * u) * settle;
    aim += Vec3d(0.012 * std::sin(kTurn * 1.7 * u), 0.01 * std::sin(kTurn * 2.1 * u + 1), 0) * settle;
  }
  const Vec3d offset(std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch));
  camera.cam_from_world = look_at(aim + distance * offset + Vec3d(0, 0.02, 0), aim, roll);
  return camera;
}

Pose about(const Vec3d& pivot, const Mat3d& rotation, const Vec3d& shift) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation;
  pose.translation() = pivot - rotation * pivot + shift;
  return pose;
}

Mat3d turn(double yaw, double pitch, double roll) {
  return (Eigen::AngleAxisd(yaw, Vec3d::UnitY()) * Eigen::AngleAxisd(pitch, Vec3d::UnitX()) *
          Eigen::AngleAxisd(roll, Vec3d::UnitZ()))
      .toRotationMatrix();
}

struct Cast {
  const HeadModel& model;
  Articulation& articulation;
  void act(const std::string& name, double amount) const {
    for (const NamedAction& action : model.actions) {
      if (action.name != name) continue;
      articulation.expression += float(amount) * action.expression;
      articulation.jaw += float(amount) * action.jaw;
    }
  }
  void both(const std::string& name, double amount, double lopsided = 0) const {
    act(name + "_L", amount * (1 + lopsided));
    act(name + "_R", amount * (1 - lopsided));
  }
};

// Speech-like movement of the mouth: syllables of changing vowel, at about four a second of clip time.
void talk(const Cast& cast, double amount, double syllables, std::uint32_t seed) {
  if (amount <= 0) return;
  const int index = int(std::floor(syllables));
  const double within = syllables - index;
  const double open =
      amount * std::pow(std::sin(std::numbers::pi * within), 2) * (0.5 + 0.5 * hash_unit(index, 0, 0, seed));
  const auto vowel = [&](int i) { return double(hash_unit(i, 1, 0, seed)); };
  const double shape = vowel(index) + (vowel(index + 1) - vowel(index)) * ease(within);
  cast.act("jawOpen", 0.42 * open);
  cast.act("mouthFunnel", 0.5 * amount * std::max(0.0, 0.45 - shape) / 0.45);
  cast.act("mouthPucker", 0.3 * amount * std::max(0.0, 0.3 - shape) / 0.3);
  cast.both("mouthStretch", 0.3 * amount * std::max(0.0, shape - 0.5) * 2);
  cast.both("mouthSmile", 0.25 * amount * std::max(0.0, shape - 0.65) * 2);
  cast.both("mouthLowerDown", 0.45 * open);
  cast.both("mouthUpperUp", 0.3 * open);
}

void blink(const Cast& cast, double time_s, std::uint32_t seed) {
  constexpr double period = 1.9, closing = 0.09, shut = 0.05, opening = 0.17;
  const int index = int(std::floor(time_s / period));
  const double t = time_s - period * index - 0.35 - 0.9 * hash_unit(index, 7, 0, seed);
  if (t < 0 || t > closing + shut + opening) return;
  const double lids = t < closing ? ease(t / closing) : 1 - ease((t - closing - shut) / opening);
  cast.both("eyeBlink", lids);
}

void first_part(const Cast& cast, const Moment& m, std::uint32_t seed) {
  const double p = m.phase;
  const double smile = swell(p, 0.05, 0.30), wide = swell(p, 0.72, 0.84);
  cast.both("mouthSmile", 0.85 * smile, 0.06);
  cast.both("cheekSquint", 0.6 * smile);
  cast.both("eyeSquint", 0.35 * smile);
  cast.both("mouthUpperUp", 0.3 * smile);
  cast.act("jawOpen", 0.10 * smile + 0.46 * wide);
  talk(cast, swell(p, 0.28, 0.56), p * 13, seed + std::uint32_t(m.cycle));
  const double brows = swell(p, 0.52, 0.72);
  cast.both("browInnerUp", 0.8 * brows);
  cast.both("browOuterUp", 0.8 * brows);
  cast.both("eyeWide", 0.5 * brows + 0.3 * wide);
  const double pout = swell(p, 0.84, 0.97);
  cast.act("mouthPucker", 0.7 * pout);
  cast.both("browDown", 0.6 * pout);
}

void second_part(const Cast& cast, const Moment& m, std::uint32_t seed) {
  const double p = m.phase;
  const double speech = std::max({swell(p, 0.02, 0.22), swell(p, 0.33, 0.56), swell(p, 0.70, 0.90)});
  talk(cast, speech, p * 23, seed + 31 + std::uint32_t(m.cycle));
  const double smile = swell(p, 0.18, 0.36), grin = swell(p, 0.55, 0.70), frown = swell(p, 0.86, 0.99);
  cast.both("mouthSmile", 0.7 * smile + 0.95 * grin, -0.05);
  cast.both("mouthUpperUp", 0.45 * grin);
  cast.both("mouthLowerDown", 0.3 * grin);
  cast.both("cheekSquint", 0.7 * grin + 0.3 * smile);
  cast.both("eyeSquint", 0.45 * grin);
  cast.act("jawOpen", 0.12 * grin + 0.62 * swell(p, 0.22, 0.34));
  cast.act("mouthPucker", 0.75 * swell(p, 0.42, 0.55));
  cast.both("mouthFrown", 0.6 * frown);
  cast.both("browDown", 0.8 * frown + 0.4 * swell(p, 0.40, 0.5));
  const double brows = std::max(swell(p, 0.08, 0.2), swell(p, 0.72, 0.84));
  cast.both("browInnerUp", 0.7 * brows);
  cast.both("browOuterUp", 0.6 * brows, 0.3);
  cast.act("jawLeft", 0.25 * swell(p, 0.44, 0.54));
  cast.both("noseSneer", 0.4 * swell(p, 0.9, 1.0));
}

// Smile with raised brows, blink, the jaw wide open, pursed lips: what a held-out tenth must show.
void finale(const Cast& cast, double p, std::uint32_t seed) {
  const double smile = swell(p, 0.0, 0.40), brows = swell(p, 0.06, 0.46), pout = swell(p, 0.62, 0.98);
  talk(cast, 0.7 * swell(p, 0.40, 0.72), p * 11, seed + 63);
  cast.both("mouthSmile", 0.9 * smile);
  cast.both("cheekSquint", 0.5 * smile);
  cast.both("browInnerUp", 0.8 * brows);
  cast.both("browOuterUp", 0.6 * brows);
  cast.act("jawOpen", 0.12 * smile + 0.6 * swell(p, 0.34, 0.66));
  cast.act("mouthPucker", 0.8 * pout);
  cast.both("eyeBlink", swell(p, 0.44, 0.68));
}

// Eyeballs towards a target in the head frame; lids follow up and down.
void gaze(const Cast& cast, const HeadShape& shape, const Vec3d& target, double glance_yaw,
          double glance_pitch) {
  double mean_pitch = 0;
  for (const Joint joint : {kLeftEye, kRightEye}) {
    const Vec3d d = target - shape.joints[joint].cast<double>();
    const double yaw = std::clamp(std::atan2(d.x(), d.z()) + glance_yaw, -30 * kDegree, 30 * kDegree);
    const double pitch =
        std::clamp(std::atan2(d.y(), std::hypot(d.x(), d.z())) + glance_pitch, -20 * kDegree, 18 * kDegree);
    const Vec3f vector = vector_from_turn(turn(yaw, -pitch, 0)).cast<float>();
    (joint == kLeftEye ? cast.articulation.left_eye : cast.articulation.right_eye) = vector;
    cast.act(std::string((yaw > 0) == (joint == kLeftEye) ? "eyeLookOut" : "eyeLookIn") +
                 (joint == kLeftEye ? "_L" : "_R"),
             0.8 * std::abs(yaw) / (35 * kDegree));
    mean_pitch += 0.5 * pitch;
  }
  cast.both(mean_pitch > 0 ? "eyeLookUp" : "eyeLookDown", 0.9 * std::abs(mean_pitch) / (25 * kDegree));
}

// Falls from 1 to 0 over the last 0.2 s before the closing cycle.
double before_finale(const DemoOptions& options, int frame) {
  const int closing = std::max(1, int(std::lround(kFinaleShare * options.frames)));
  const double left = (options.frames - closing - frame) / options.frames_per_second;
  return ease(left / 0.24);
}

}  // namespace

int moving_frames(const DemoOptions& options) {
  return std::clamp(int(std::lround(options.moving_share * options.frames)), 0, options.frames);
}

float habit_strength(const DemoOptions& options, int frame) {
  if (!options.habit) return 0;
  // Like the rest of the performance, faster in short clips: five swells in the clip, one of them in its last
  // tenth.
  const double at = double(frame) / std::max(1, options.frames - 1);
  const double swells[][3] = {
      {0.04, 0.17, 1.0}, {0.27, 0.42, 0.6}, {0.50, 0.62, 1.0}, {0.70, 0.84, 0.8}, {0.905, 0.985, 1.0}};
  double strength = 0;
  for (const auto& [from, to, most] : swells) strength += most * swell(at, from, to);
  return float(std::clamp(strength, 0.0, 1.0));
}

Shot perform(const HeadModel& model, const HeadShape& shape, const DemoOptions& options, int frame) {
  const Moment m = moment_of(options, frame);
  const std::uint32_t seed =
      hash_u32(std::uint32_t(options.seed) + 77 + 1000 * std::uint32_t(options.person));
  Shot shot;
  shot.articulation = neutral_articulation(model);
  const Vec3d eyes = (0.5f * (shape.joints[kLeftEye] + shape.joints[kRightEye])).cast<double>();
  const Vec3d neck = shape.joints[kNeck].cast<double>();
  shot.camera = film(options, m, eyes, frame);

  // -- Head and torso
  if (!m.walking || options.restless_head) {
    // In the first part it returns to rest before the second begins.
    const double end = m.walking ? ease((1 - m.share) / 0.08) : 1;
    const double start = ease((m.cycle + m.phase) / 0.08) * end, p = kTurn * m.phase, c = m.cycle;
    const double yaw = 30 * kDegree * std::sin(p) * start;
    const double pitch = 12 * kDegree * std::sin(2 * p + 0.9 + 0.8 * c) * start;
    const double roll = 7 * kDegree * std::sin(3 * p + 0.4 + c) * start;
    const Vec3d shift =
        Vec3d(0.006 * std::sin(p + 0.3), 0.002 * std::sin(2 * p), 0.006 * std::sin(2 * p + 1)) * start;
    const Vec3d waist = neck - Vec3d(0, 0.35, 0.02);
    shot.world_from_torso =
        about(waist,
              turn(1.2 * kDegree * std::sin(p + 0.2) * start, 0.5 * kDegree * std::sin(2 * p) * start,
                   0.8 * kDegree * std::sin(p + 1.1) * start),
              Vec3d::Zero());
    shot.world_from_head = shot.world_from_torso * about(neck, turn(yaw, pitch, roll), shift);
  }

  // -- Face
  const Cast cast{model, shot.articulation};
  if (m.walking) {
    first_part(cast, m, seed);
  } else if (m.finale >= 0) {
    finale(cast, m.finale, seed);
  } else {
    const double rest = before_finale(options, frame);  // the face comes to rest before the closing cycle
    second_part(cast, m, seed);
    shot.articulation.expression *= float(rest);
    shot.articulation.jaw *= float(rest);
  }
  if (m.finale < 0) blink(cast, m.time_s, seed);

  // -- Gaze: at the camera, with glances aside in the second part
  const Vec3d lens = inverse(shot.camera.cam_from_world).translation();
  const double aside = m.walking ? 0 : swell(m.phase, 0.58, 0.68) - swell(m.phase, 0.26, 0.33);
  gaze(cast, shape, inverse(shot.world_from_head) * lens, 16 * kDegree * aside, 5 * kDegree * aside);

  if (model.expression_min.size() == shot.articulation.expression.size()) {
    shot.articulation.expression =
        shot.articulation.expression.cwiseMax(model.expression_min).cwiseMin(model.expression_max);
  }
  shot.habit = habit_strength(options, frame);
  return shot;
}

}  // namespace likeness
