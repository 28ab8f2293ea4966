// Curves of the demo's expressions, over the cycles of core/synth/body_pose.h; blinks keep their natural
// speed.
#include "core/synth/performance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/rigid.h"
#include "core/synth/body_pose.h"
#include "core/synth/demo_camera.h"
#include "core/synth/easing.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Cast {
  const HeadModel& model;
  Articulation& articulation;
  double share = 1;
  void act(const std::string& name, double amount) const {
    for (const NamedAction& action : model.actions) {
      if (action.name != name) continue;
      articulation.expression += float(share * amount) * action.expression;
      articulation.jaw += float(share * amount) * action.jaw;
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
    const Vec3f vector = vector_from_turn(head_turn(yaw, -pitch, 0)).cast<float>();
    (joint == kLeftEye ? cast.articulation.left_eye : cast.articulation.right_eye) = vector;
    cast.act(std::string((yaw > 0) == (joint == kLeftEye) ? "eyeLookOut" : "eyeLookIn") +
                 (joint == kLeftEye ? "_L" : "_R"),
             0.8 * std::abs(yaw) / (35 * kDegree));
    mean_pitch += 0.5 * pitch;
  }
  cast.both(mean_pitch > 0 ? "eyeLookUp" : "eyeLookDown", 0.9 * std::abs(mean_pitch) / (25 * kDegree));
}

// Falls from 1 to 0 over the last 0.2 s before the closing cycle.
double before_finale(const DemoOptions& options, double frame) {
  const double left = (options.frames - closing_frames(options) - frame) / options.frames_per_second;
  return ease(left / 0.24);
}

// Loose hair is that much later than the head.
constexpr double kHairLate_s = 0.10;

}  // namespace

float habit_strength(const DemoOptions& options, double frame) {
  if (!options.habit) return 0;
  // Like the rest of the performance, faster in short clips: five swells in the clip, one of them in its last
  // tenth.
  const double at = frame / std::max(1, options.frames - 1);
  const double swells[][3] = {
      {0.04, 0.17, 1.0}, {0.27, 0.42, 0.6}, {0.50, 0.62, 1.0}, {0.70, 0.84, 0.8}, {0.905, 0.985, 1.0}};
  double strength = 0;
  for (const auto& [from, to, most] : swells) strength += most * swell(at, from, to);
  return float(std::clamp(strength, 0.0, 1.0));
}

Shot perform(const HeadModel& model, const HeadShape& shape, const DemoOptions& film, int frame,
             double later_s) {
  const std::vector<DemoShot> shots = demo_shots(film);
  const DemoShot& cut = shot_of(shots, frame);
  const DemoOptions options = uncut(film, shots);
  const double at = frame + cut.dropped + later_s * options.frames_per_second;
  const Moment m = moment_of(options, at);
  const std::uint32_t seed =
      hash_u32(std::uint32_t(options.seed) + 77 + 1000 * std::uint32_t(options.person));
  Shot shot;
  shot.articulation = neutral_articulation(model);
  shot.camera = demo_camera(options, shape, cut, at);
  shot.camera.frame = frame;
  const BodyPose body = body_pose(options, shape, at);
  shot.world_from_head = body.world_from_head;
  shot.world_from_torso = body.world_from_torso;
  if (options.hair == DemoHair::loose) {
    const double late = at - kHairLate_s * options.frames_per_second;
    shot.world_from_late_head = body_pose(options, shape, late).world_from_head;
  }
  if (cut.place != 0) {
    const Pose placed = placed_person(cut.place);
    for (Pose* pose : {&shot.world_from_head, &shot.world_from_torso, &shot.world_from_late_head})
      *pose = placed * *pose;
  }

  // -- Face
  const Cast cast{model, shot.articulation, options.action_share};
  if (m.walking) {
    first_part(cast, m, seed);
  } else if (m.finale >= 0) {
    finale(cast, m.finale, seed);
  } else {
    const double rest = before_finale(options, at);  // the face comes to rest before the closing cycle
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
  shot.habit = habit_strength(options, at);
  return shot;
}

}  // namespace likeness
