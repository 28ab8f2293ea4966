// See drive_map.h.
#include "core/drive/drive_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "core/base/rigid.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

constexpr float kMargin = 0.15f;  // of an action's seen range, beyond which the soft clamp holds
constexpr float kMinMargin = 0.05f;

Eigen::VectorXf face_of(const Articulation& a) {
  Eigen::VectorXf v(a.expression.size() + 3);
  v << a.expression, a.jaw;
  return v;
}

// A motion as an articulation of the driver's model, relative to the driver's rest.
Articulation change_of(const DriverMotion& motion) {
  Articulation change;
  change.expression = motion.face.head(motion.face.size() - 3);
  change.jaw = motion.face.tail<3>();
  return change;
}

// (A avatar, A driver): by name, or a two-sided action for both sides, or the mean of both sides for a
// two-sided one.
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

ActionLimits limits_of(const DriveSubject& avatar, const std::string& name, float at_rest) {
  const SeenAction* seen = find_seen(avatar.seen, name);
  if (!seen) return {};
  constexpr float kRounding = 1e-5f;  // rest itself must come out unchanged
  const float low = std::min(seen->low, at_rest - kRounding),
              high = std::max(seen->high, at_rest + kRounding);
  return {low, high, std::max(kMinMargin, kMargin * (high - low))};
}

double eye_distance(const DriveSubject& subject) {
  const HeadShape shape = shape_head(*subject.model, subject.person);
  return double((shape.joints[kLeftEye] - shape.joints[kRightEye]).norm());
}

// Heads differ in size; an implausible length is ignored.
double size_ratio(const DriveSubject& driver, const DriveSubject& avatar) {
  const double d = eye_distance(driver), a = eye_distance(avatar);
  return d > 0.02 && a > 0.02 ? std::clamp(a / d, 0.8, 1.25) : 1;
}

// Unchanged up to `free`; beyond, bending towards half as much again.
double bent(double x, double free) {
  return x > free ? free + 0.5 * free * std::tanh((x - free) / (0.5 * free)) : x;
}

// What the avatar follows of a shift of the head.
Vec3d within_span(const Vec3d& shift, double span) {
  const double length = shift.norm();
  return length > span ? Vec3d(shift * (bent(length, span) / length)) : shift;
}

// The part of a shift that the neck alone takes.
Vec3d within_reach(const Vec3d& shift, double reach) {
  const double length = shift.norm();
  return length > 1e-9 ? Vec3d(shift * (reach * std::tanh(length / reach) / length)) : shift;
}

}  // namespace

float soft_clamp(float x, float low, float high, float margin) {
  if (x > high) return high + margin * std::tanh((x - high) / margin);
  if (x < low) return low - margin * std::tanh((low - x) / margin);
  return x;
}

DriverMotion motion_of(const TrackedFrame& frame, const DriveSubject& driver, const Vec3d& neck) {
  const Pose motion = inverse(driver.world_from_head) * frame.pose.world_from_head;
  return {face_of(frame.pose.articulation) - face_of(driver.neutral),
          frame.pose.articulation.left_eye - driver.neutral.left_eye,
          frame.pose.articulation.right_eye - driver.neutral.right_eye,
          vector_from_turn(motion.linear()),
          motion * neck - neck,
          frame.status == FrameStatus::lost};
}

DriverMotion between(const DriverMotion& a, const DriverMotion& b, double t) {
  const float s = float(t);
  const Eigen::Quaterniond p(turn_from_vector(a.turn)), q(turn_from_vector(b.turn));
  return {(1 - s) * a.face + s * b.face,
          (1 - s) * a.left_eye + s * b.left_eye,
          (1 - s) * a.right_eye + s * b.right_eye,
          vector_from_turn(p.slerp(t, q).normalized().toRotationMatrix()),
          (1 - t) * a.shift + t * b.shift,
          true};
}

DriverMotion MotionFilter::next(DriverMotion motion, double dt) {
  std::size_t used = 0;
  const auto filter = [&](auto& value, double beta) {
    if (used == filters_.size()) filters_.emplace_back(1.5, beta);
    value = std::remove_cvref_t<decltype(value)>(filters_[used++].next(double(value), dt));
  };
  for (float& value : motion.face) filter(value, 2);
  for (int k = 0; k < 3; ++k) {
    filter(motion.left_eye[k], 4);
    filter(motion.right_eye[k], 4);
    filter(motion.turn[k], 6);
    filter(motion.shift[k], 30);
  }
  return motion;
}

FaceMap::FaceMap(const DriveSubject& driver, const DriveSubject& avatar, const DriveOptions& options)
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
    // The lids of a gaze are not limited: its range says how far the eyeball went.
    limits_.push_back(eye ? ActionLimits{} : limits_of(avatar, action.name, rest_[Eigen::Index(a)]));
    eye_limits_.push_back(eye ? limits_of(avatar, action.name, rest_eyes[Eigen::Index(a)]) : ActionLimits{});
  }
}

Eigen::VectorXf FaceMap::amounts(const DriverMotion& motion) const {
  const Eigen::VectorXf performed = face_amounts(driver_basis_, change_of(motion));
  return same_ ? performed : Eigen::VectorXf(match_ * performed);
}

Articulation FaceMap::articulation(const DriverMotion& motion, const Eigen::VectorXf& amounts,
                                   const Eigen::VectorXf& steady) const {
  Articulation out = avatar_.neutral;
  if (same_) {
    const Articulation change = change_of(motion);
    out.expression += change.expression, out.jaw += change.jaw;
  }
  for (Eigen::Index a = 0; a < amounts.size(); ++a) {
    const std::size_t i = std::size_t(a);
    // A gain above 1 amplifies the smoothed motion only, not the track's jitter.
    float wanted = gains_[i] > 1 ? amounts[a] + (gains_[i] - 1) * steady[a] : gains_[i] * amounts[a];
    if (clamp_)
      wanted = soft_clamp(rest_[a] + wanted, limits_[i].low, limits_[i].high, limits_[i].margin) - rest_[a];
    const float added = same_ ? wanted - amounts[a] : wanted;
    if (added == 0) continue;
    const NamedAction& action = avatar_basis_.actions[i];
    if (action.expression.size() == out.expression.size()) out.expression += added * action.expression;
    out.jaw += added * action.jaw;
  }
  out.left_eye = gaze(avatar_.neutral.left_eye, motion.left_eye, &NamedAction::left_eye);
  out.right_eye = gaze(avatar_.neutral.right_eye, motion.right_eye, &NamedAction::right_eye);
  return out;
}

// The eyeball's turn split into the actions that point its way, which lie along two axes.
Vec3f FaceMap::gaze(const Vec3f& rest, const Vec3f& change, Vec3f NamedAction::*eye) const {
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

Vec3d neck_of(const DriveSubject& subject) {
  return shape_head(*subject.model, subject.person).joints[kNeck].cast<double>();
}

HeadMap::HeadMap(const DriveSubject& driver, const DriveSubject& avatar, const DriveOptions& options)
    : avatar_(avatar),
      options_(options),
      neck_(neck_of(avatar)),
      ratio_(size_ratio(driver, avatar)),
      torso_(options.torso_s) {}

void HeadMap::place(const DriverMotion& motion, double dt, DrivenFrame& frame) {
  frame.pose.world_from_head = avatar_.world_from_head;
  frame.pose.world_from_torso = avatar_.world_from_torso;
  if (!options_.move_head) return;
  const Vec3d shift = within_span(ratio_ * motion.shift, options_.span_m),
              near = within_reach(shift, options_.reach_m);
  Vec3d far = shift - near;  // the body's part; y is up in the head's frame
  far.y() = bent(far.y(), options_.rise_m);
  Pose moved = Pose::Identity();
  moved.linear() = turn_from_vector(motion.turn);
  moved.translation() = neck_ + near + far - moved.linear() * neck_;
  frame.pose.world_from_head = avatar_.world_from_head * moved;
  const Vec3d body = torso_.next(options_.torso_share * near + far, dt);
  frame.pose.world_from_torso.pretranslate(avatar_.world_from_head.linear() * body);
}

Result<void> check_drive(const DriveSubject& driver, const DriveSubject& avatar,
                         const DriveOptions& options) {
  if (driver.neutral.expression.size() != driver.model->expression_count() ||
      avatar.neutral.expression.size() != avatar.model->expression_count()) {
    return Error{ErrorCode::bad_input, "Track, avatar and head models differ in their number of expressions.",
                 "Track the clip again, and train the avatar again if that does not help.", "drive"};
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

}  // namespace likeness
