// Performance, mapping, head and torso: see drive.h.
#include "core/track/drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/quantile.h"
#include "core/head/action_amounts.h"
#include "core/head/pose_head.h"
#include "core/track/fit_frame.h"
#include "core/track/neutral.h"

namespace likeness {
namespace {

constexpr double kMetresPerRadian = 0.17;  // a turn of ten degrees counts as 3 cm
constexpr float kWorthCalibrating = 0.15f, kGainDeadZone = 1.1f, kLeastGain = 0.75f, kLargestGain = 1.33f;
constexpr float kMargin = 0.15f;  // of an action's seen range, beyond which the soft clamp holds
constexpr float kLeastMargin = 0.05f;

const SeenAction* find_seen(const std::vector<SeenAction>& seen, const std::string& name) {
  const auto found = std::ranges::find_if(seen, [&](const SeenAction& s) { return s.name == name; });
  return found == seen.end() ? nullptr : &*found;
}

// -- The performance: what the driver does, relative to the driver's rest

struct Beat {
  Eigen::VectorXf face;  // (E + 3) expression and jaw
  Vec3f left_eye, right_eye;
  Vec3d turn;   // rotation vector in the typical head frame
  Vec3d shift;  // of the neck's top in the typical head frame, m
  bool bridged = false;
};

Eigen::VectorXf face_of(const Articulation& a) {
  Eigen::VectorXf v(a.expression.size() + 3);
  v << a.expression, a.jaw;
  return v;
}

Beat beat_of(const TrackedFrame& frame, const Puppet& driver, const Vec3d& neck) {
  const Pose motion = driver.world_from_head.inverse() * frame.world_from_head;
  return {face_of(frame.articulation) - face_of(driver.neutral),
          frame.articulation.left_eye - driver.neutral.left_eye,
          frame.articulation.right_eye - driver.neutral.right_eye,
          vector_from_turn(motion.linear()),
          motion * neck - neck,
          frame.status == FrameStatus::lost};
}

Beat between(const Beat& a, const Beat& b, double t) {
  const float s = float(t);
  const Eigen::Quaterniond p(turn_from_vector(a.turn)), q(turn_from_vector(b.turn));
  return {(1 - s) * a.face + s * b.face,
          (1 - s) * a.left_eye + s * b.left_eye,
          (1 - s) * a.right_eye + s * b.right_eye,
          vector_from_turn(p.slerp(t, q).normalized().toRotationMatrix()),
          (1 - t) * a.shift + t * b.shift,
          true};
}

void bridge_gaps(std::vector<Beat>& beats, const Track& track) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < beats.size(); ++i)
    if (!beats[i].bridged) known.push_back(i);
  for (std::size_t i = 0; i < beats.size(); ++i) {
    if (!beats[i].bridged) continue;
    const auto after = std::ranges::lower_bound(known, i);
    const std::size_t b = after == known.end() ? known.back() : *after;
    const std::size_t a = after == known.begin() ? known.front() : *(after - 1);
    const double span = track.frames[b].time_s - track.frames[a].time_s;
    const double t = b > a && span > 0 ? (track.frames[i].time_s - track.frames[a].time_s) / span : 0;
    beats[i] = between(beats[a], beats[b], std::clamp(t, 0.0, 1.0));
  }
}

// One-euro filter (Casiez 2012): a low-pass whose cut-off rises with the speed.
class OneEuro {
 public:
  OneEuro(double cutoff_hz, double beta) : cutoff_(cutoff_hz), beta_(beta) {}
  double next(double x, double dt) {
    if (!started_) {
      started_ = true, value_ = x;
      return x;
    }
    const double speed = (x - value_) / dt;
    speed_ += share(1.0, dt) * (speed - speed_);
    value_ += share(cutoff_ + beta_ * std::abs(speed_), dt) * (x - value_);
    return value_;
  }

 private:
  static double share(double cutoff_hz, double dt) {
    const double r = 2 * std::numbers::pi * cutoff_hz * dt;
    return r / (r + 1);
  }
  double cutoff_, beta_, value_ = 0, speed_ = 0;
  bool started_ = false;
};

void smooth_beats(std::vector<Beat>& beats, const std::vector<double>& steps_s) {
  const auto filter = [&](auto&& channel, double beta) {
    OneEuro euro(1.5, beta);
    for (std::size_t i = 0; i < beats.size(); ++i) {
      auto& value = channel(beats[i]);
      value = std::remove_cvref_t<decltype(value)>(euro.next(double(value), steps_s[i]));
    }
  };
  if (beats.empty()) return;
  for (Eigen::Index k = 0; k < beats.front().face.size(); ++k)
    filter([k](Beat& b) -> float& { return b.face[k]; }, 2);
  for (int k = 0; k < 3; ++k) {
    filter([k](Beat& b) -> float& { return b.left_eye[k]; }, 4);
    filter([k](Beat& b) -> float& { return b.right_eye[k]; }, 4);
    filter([k](Beat& b) -> double& { return b.turn[k]; }, 6);
    filter([k](Beat& b) -> double& { return b.shift[k]; }, 30);
  }
}

// -- From the driver's actions to the avatar's

// (A avatar, A driver): one name for one, a two-sided action for both sides, or the mean of both for it.
Eigen::MatrixXf matched_actions(const ActionBasis& driver, const ActionBasis& avatar) {
  Eigen::MatrixXf match =
      Eigen::MatrixXf::Zero(Eigen::Index(avatar.actions.size()), Eigen::Index(driver.actions.size()));
  for (std::size_t a = 0; a < avatar.actions.size(); ++a) {
    const std::string& name = avatar.actions[a].name;
    const bool sided = name.ends_with("_L") || name.ends_with("_R");
    const int same = action_index(driver, name);
    const int whole = sided ? action_index(driver, std::string_view(name).substr(0, name.size() - 2)) : -1;
    const int left = action_index(driver, name + "_L"), right = action_index(driver, name + "_R");
    if (same >= 0)
      match(Eigen::Index(a), same) = 1;
    else if (whole >= 0)
      match(Eigen::Index(a), whole) = 1;
    else if (left >= 0 && right >= 0)
      match(Eigen::Index(a), left) = match(Eigen::Index(a), right) = 0.5f;
  }
  return match;
}

// What the seen range of an avatar's action allows, widened so that its own rest is inside.
struct Limits {
  float low = -std::numeric_limits<float>::infinity(), high = std::numeric_limits<float>::infinity();
  float margin = 1;
};

Limits limits_of(const Puppet& avatar, const std::string& name, float at_rest) {
  const SeenAction* seen = find_seen(avatar.seen, name);
  if (!seen) return {};
  constexpr float kRounding = 1e-5f;  // rest itself must come out untouched
  const float low = std::min(seen->low, at_rest - kRounding),
              high = std::max(seen->high, at_rest + kRounding);
  return {low, high, std::max(kLeastMargin, kMargin * (high - low))};
}

class FaceMap {
 public:
  FaceMap(const Puppet& driver, const Puppet& avatar, const DriveOptions& options)
      : avatar_(avatar),
        clamp_(options.clamp),
        same_(driver.model->hash == avatar.model->hash),
        driver_basis_(action_basis(*driver.model)),
        avatar_basis_(same_ ? driver_basis_ : action_basis(*avatar.model)),
        gains_(drive_gains(driver, avatar, options)) {
    if (!same_) match_ = matched_actions(driver_basis_, avatar_basis_);
    rest_ = face_amounts(avatar_basis_, avatar.neutral);
    const Eigen::VectorXf rest_eyes = action_amounts(avatar_basis_, avatar.neutral);
    for (std::size_t a = 0; a < avatar_basis_.actions.size(); ++a) {
      const NamedAction& action = avatar_basis_.actions[a];
      const bool eye = !action.left_eye.isZero() || !action.right_eye.isZero();
      // The lids of a gaze are free: its range says how far the eyeball went.
      limits_.push_back(eye ? Limits{} : limits_of(avatar, action.name, rest_[Eigen::Index(a)]));
      eye_limits_.push_back(eye ? limits_of(avatar, action.name, rest_eyes[Eigen::Index(a)]) : Limits{});
    }
  }

  // How much of each of the avatar's actions a beat performs.
  Eigen::VectorXf amounts(const Beat& beat) const {
    const Eigen::VectorXf performed = face_amounts(driver_basis_, change_of(beat));
    return same_ ? performed : Eigen::VectorXf(match_ * performed);
  }

  // steady: the beat's amounts without tremor.
  Articulation articulation(const Beat& beat, const Eigen::VectorXf& amounts,
                            const Eigen::VectorXf& steady) const {
    Articulation out = avatar_.neutral;
    if (same_) {
      const Articulation change = change_of(beat);
      out.expression += change.expression, out.jaw += change.jaw;
    }
    for (Eigen::Index a = 0; a < amounts.size(); ++a) {
      const std::size_t i = std::size_t(a);
      // More of an action is more of its course: a gain above 1 must not magnify what the track trembles.
      float wanted = gains_[i] > 1 ? amounts[a] + (gains_[i] - 1) * steady[a] : gains_[i] * amounts[a];
      if (clamp_)
        wanted = soft_clamp(rest_[a] + wanted, limits_[i].low, limits_[i].high, limits_[i].margin) - rest_[a];
      const float added = same_ ? wanted - amounts[a] : wanted;
      if (added == 0) continue;
      const NamedAction& action = avatar_basis_.actions[i];
      if (action.expression.size() == out.expression.size()) out.expression += added * action.expression;
      out.jaw += added * action.jaw;
    }
    out.left_eye = gaze(avatar_.neutral.left_eye, beat.left_eye, &NamedAction::left_eye);
    out.right_eye = gaze(avatar_.neutral.right_eye, beat.right_eye, &NamedAction::right_eye);
    return out;
  }

 private:
  // A beat as an articulation of the driver's model, relative to the driver's rest.
  static Articulation change_of(const Beat& beat) {
    Articulation change;
    change.expression = beat.face.head(beat.face.size() - 3);
    change.jaw = beat.face.tail<3>();
    return change;
  }

  // The eyeball's turn split into the actions that point its way, which lie along two axes.
  Vec3f gaze(const Vec3f& rest, const Vec3f& change, Vec3f NamedAction::*eye) const {
    Vec3f moved = change;
    for (std::size_t a = 0; a < avatar_basis_.actions.size(); ++a) {
      const Vec3f& full = avatar_basis_.actions[a].*eye;
      if (full.isZero()) continue;
      moved += (gains_[a] - 1) * std::max(0.0f, change.dot(full) / full.squaredNorm()) * full;
    }
    Vec3f out = rest + moved;
    for (std::size_t a = 0; clamp_ && a < avatar_basis_.actions.size(); ++a) {
      const Vec3f& full = avatar_basis_.actions[a].*eye;
      if (full.isZero()) continue;
      const float amount = out.dot(full) / full.squaredNorm();
      if (amount > 0)
        out += (soft_clamp(amount, 0, eye_limits_[a].high, eye_limits_[a].margin) - amount) * full;
    }
    return out;
  }

  const Puppet& avatar_;
  bool clamp_, same_;
  ActionBasis driver_basis_, avatar_basis_;
  Eigen::MatrixXf match_;
  std::vector<float> gains_;
  Eigen::VectorXf rest_;  // the avatar's amounts at rest
  std::vector<Limits> limits_, eye_limits_;
};

// Each course through a binomial window of five frames (weights 1 4 6 4 1), which has no lag; the ends are
// held.
std::vector<Eigen::VectorXf> without_tremor(const std::vector<Eigen::VectorXf>& courses) {
  constexpr std::array kWeights{1.0f, 4.0f, 6.0f, 4.0f, 1.0f};
  const int n = int(courses.size());
  std::vector<Eigen::VectorXf> steady(courses.size());
  for (int i = 0; i < n; ++i) {
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(courses[std::size_t(i)].size());
    for (int k = 0; k < 5; ++k)
      sum += kWeights[std::size_t(k)] * courses[std::size_t(std::clamp(i + k - 2, 0, n - 1))];
    steady[std::size_t(i)] = sum / 16;
  }
  return steady;
}

// -- Head and torso

// Critically damped: follows without overshoot; exact for a target that rests between two frames.
class Follower {
 public:
  explicit Follower(double time_s) : rate_(1 / time_s) {}
  Vec3d next(const Vec3d& target, double dt) {
    if (!started_) {
      started_ = true, place_ = target;
      return place_;
    }
    const Vec3d off = place_ - target, pull = speed_ + rate_ * off;
    const double decay = std::exp(-rate_ * dt);
    place_ = target + (off + pull * dt) * decay;
    speed_ = (speed_ - rate_ * pull * dt) * decay;
    return place_;
  }

 private:
  double rate_;
  Vec3d place_ = Vec3d::Zero(), speed_ = Vec3d::Zero();
  bool started_ = false;
};

Vec3d neck_of(const Puppet& puppet) {
  return shape_head(*puppet.model, puppet.person).joints[kNeck].cast<double>();
}

double eye_distance(const Puppet& puppet) {
  const HeadShape shape = shape_head(*puppet.model, puppet.person);
  return double((shape.joints[kLeftEye] - shape.joints[kRightEye]).norm());
}

// Heads differ in size; a length that is no head's is not believed.
double size_ratio(const Puppet& driver, const Puppet& avatar) {
  const double d = eye_distance(driver), a = eye_distance(avatar);
  return d > 0.02 && a > 0.02 ? std::clamp(a / d, 0.8, 1.25) : 1;
}

// The part of a shift that the neck alone takes.
Vec3d within_reach(const Vec3d& shift, double reach) {
  const double length = shift.norm();
  return length > 1e-9 ? Vec3d(shift * (reach * std::tanh(length / reach) / length)) : shift;
}

Result<void> check(const Track& track, const Puppet& driver, const Puppet& avatar,
                   const DriveOptions& options) {
  if (track.head_model_hash != driver.model->hash) {
    return Error{ErrorCode::bad_input,
                 fmt::format("The driving track was made with the {} head model, not with the {} one.",
                             track.head_model_name, driver.model->name),
                 "Name the track's own head model, or track the clip again.", "drive"};
  }
  const Eigen::Index e = driver.model->expression_count();
  const bool fits = driver.neutral.expression.size() == e &&
                    std::ranges::all_of(track.frames, [&](const TrackedFrame& frame) {
                      return frame.articulation.expression.size() == e;
                    });
  if (!fits || avatar.neutral.expression.size() != avatar.model->expression_count()) {
    return Error{ErrorCode::bad_input, "The numbers of expressions of track, avatar and head models differ.",
                 "Track the clip again, and train the avatar again if that does not help.", "drive"};
  }
  if (std::ranges::all_of(track.frames,
                          [](const TrackedFrame& f) { return f.status == FrameStatus::lost; })) {
    return Error{ErrorCode::no_face, "The face is lost in every frame of the driving track.",
                 "Use a driving clip in which the face is near and well lit.", "drive"};
  }
  for (const auto& [name, gain] : options.gains) {
    if (find_action(*avatar.model, name)) continue;
    std::string known;
    for (const NamedAction& action : avatar.model->actions)
      known += (known.empty() ? "" : ", ") + action.name;
    return Error{ErrorCode::bad_input, fmt::format("The avatar's head model has no action named '{}'.", name),
                 known.empty() ? "Use a head model with named actions." : "Choose one of: " + known + ".",
                 "drive"};
  }
  return {};
}

}  // namespace

float soft_clamp(float x, float low, float high, float margin) {
  if (x > high) return high + margin * std::tanh((x - high) / margin);
  if (x < low) return low - margin * std::tanh((low - x) / margin);
  return x;
}

Result<Puppet> puppet_from_track(const Track& track, const HeadModel& model) {
  Puppet puppet;
  puppet.model = &model;
  puppet.person = track.person;
  std::vector<const TrackedFrame*> frames;
  for (const TrackedFrame& frame : track.frames)
    if (frame.status != FrameStatus::lost && frame.articulation.expression.size() == model.expression_count())
      frames.push_back(&frame);
  if (frames.empty()) {
    return Error{ErrorCode::no_face, "The face is lost in every frame of the driving track.",
                 "Use a driving clip in which the face is near and well lit.", "drive"};
  }
  puppet.neutral = track.neutral.expression.size() == model.expression_count()
                       ? track.neutral
                       : calibrate_neutral(model, track.frames, {});
  const ActionBasis basis = action_basis(model);
  std::vector<std::vector<float>> amounts(basis.actions.size());
  for (const TrackedFrame* frame : frames) {
    const Eigen::VectorXf own = action_amounts(basis, frame->articulation);
    for (std::size_t a = 0; a < amounts.size(); ++a) amounts[a].push_back(own[Eigen::Index(a)]);
  }
  for (std::size_t a = 0; a < amounts.size(); ++a)
    puppet.seen.push_back({basis.actions[a].name, quantile(amounts[a], 0.02), quantile(amounts[a], 0.98)});
  // Medoid of the poses, among up to 200 frames.
  const std::size_t stride = std::max<std::size_t>(1, frames.size() / 200);
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < frames.size(); i += stride) {
    double sum = 0;
    for (std::size_t j = 0; j < frames.size(); j += stride) {
      const Pose difference = frames[i]->world_from_head.inverse() * frames[j]->world_from_head;
      sum +=
          difference.translation().norm() + kMetresPerRadian * vector_from_turn(difference.linear()).norm();
    }
    if (sum < best) best = sum, puppet.world_from_head = frames[i]->world_from_head;
  }
  return puppet;
}

std::vector<float> drive_gains(const Puppet& driver, const Puppet& avatar, const DriveOptions& options) {
  const ActionBasis basis = action_basis(*avatar.model), other = action_basis(*driver.model);
  const Eigen::VectorXf rest = action_amounts(basis, avatar.neutral);
  const Eigen::VectorXf driver_rest = action_amounts(other, driver.neutral);
  std::vector<float> gains;
  for (std::size_t a = 0; a < basis.actions.size(); ++a) {
    const NamedAction& action = basis.actions[a];
    float gain = 1;
    const SeenAction *mine = find_seen(avatar.seen, action.name),
                     *theirs = find_seen(driver.seen, action.name);
    const int d = action_index(other, action.name);
    const bool gaze = !action.left_eye.isZero() || !action.right_eye.isZero();  // an angle is an angle
    if (options.calibrate_gains && !gaze && mine && theirs && d >= 0) {
      const float to = mine->high - rest[Eigen::Index(a)], from = theirs->high - driver_rest[d];
      if (to > kWorthCalibrating && from > kWorthCalibrating) {
        const float ratio = to / from;
        if (ratio > kGainDeadZone) gain = std::min(ratio / kGainDeadZone, kLargestGain);
        if (ratio < 1 / kGainDeadZone) gain = std::max(ratio * kGainDeadZone, kLeastGain);
      }
    }
    const auto user = options.gains.find(action.name);
    gains.push_back(user == options.gains.end() ? gain : gain * user->second);
  }
  return gains;
}

Result<std::vector<DrivenFrame>> drive(const Track& track, const Puppet& driver, const Puppet& avatar,
                                       const DriveOptions& options) {
  if (const auto checked = check(track, driver, avatar, options); !checked) return checked.error();
  const Vec3d driver_neck = neck_of(driver), neck = neck_of(avatar);
  std::vector<Beat> beats;
  std::vector<double> steps_s;
  for (std::size_t i = 0; i < track.frames.size(); ++i) {
    beats.push_back(beat_of(track.frames[i], driver, driver_neck));
    const double step = i > 0 ? track.frames[i].time_s - track.frames[i - 1].time_s : 0.04;
    steps_s.push_back(step > 1e-4 && step < 1 ? step : 0.04);
  }
  bridge_gaps(beats, track);
  if (options.smooth) smooth_beats(beats, steps_s);

  const FaceMap face(driver, avatar, options);
  const double ratio = size_ratio(driver, avatar);
  std::vector<Eigen::VectorXf> amounts;
  for (const Beat& beat : beats) amounts.push_back(face.amounts(beat));
  const std::vector<Eigen::VectorXf> steady = without_tremor(amounts);
  Follower torso(options.torso_s);
  std::vector<DrivenFrame> driven;
  for (std::size_t i = 0; i < beats.size(); ++i) {
    const Beat& beat = beats[i];
    DrivenFrame frame{
        track.frames[i].frame,  track.frames[i].time_s,  beat.bridged,
        avatar.world_from_head, avatar.world_from_torso, face.articulation(beat, amounts[i], steady[i])};
    if (options.move_head) {
      const Vec3d shift = ratio * beat.shift, near = within_reach(shift, options.reach_m);
      Pose motion = Pose::Identity();
      motion.linear() = turn_from_vector(beat.turn);
      motion.translation() = neck + shift - motion.linear() * neck;
      frame.world_from_head = avatar.world_from_head * motion;
      const Vec3d body = torso.next(options.torso_share * near + (shift - near), steps_s[i]);
      frame.world_from_torso.pretranslate(avatar.world_from_head.linear() * body);
    }
    driven.push_back(std::move(frame));
  }
  return driven;
}

}  // namespace likeness
