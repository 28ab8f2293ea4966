// The parts of driving that a clip and a stream of frames share. Internal to drive and drive_stream.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/drive/drive_options.h"
#include "core/drive/drive_subject.h"
#include "core/drive/driven_frame.h"
#include "core/head/action_amounts.h"
#include "core/scene/track.h"

namespace likeness {

// What the driver does in one frame, relative to the driver's rest.
struct DriverMotion {
  Eigen::VectorXf face;  // (E + 3) expression and jaw
  Vec3f left_eye, right_eye;
  Vec3d turn;   // rotation vector in the typical head frame
  Vec3d shift;  // of the neck's top in the typical head frame, m
  bool bridged = false;
};

DriverMotion motion_of(const TrackedFrame& frame, const DriveSubject& driver, const Vec3d& neck);
DriverMotion between(const DriverMotion& a, const DriverMotion& b, double t);

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

// Filters every component of a motion separately.
class MotionFilter {
 public:
  DriverMotion next(DriverMotion motion, double dt);

 private:
  std::vector<OneEuro> filters_;
};

// The seen range of an avatar's action, widened to include its own rest.
struct ActionLimits {
  float low = -std::numeric_limits<float>::infinity(), high = std::numeric_limits<float>::infinity();
  float margin = 1;
};

// x within [low, high]; beyond, it bends smoothly towards a limit `margin` further out.
float soft_clamp(float x, float low, float high, float margin);

// From the driver's actions to the avatar's. Refers to the avatar, which must outlive it.
class FaceMap {
 public:
  FaceMap(const DriveSubject& driver, const DriveSubject& avatar, const DriveOptions& options);

  // How much of each of the avatar's actions a motion performs.
  Eigen::VectorXf amounts(const DriverMotion& motion) const;
  // steady: the motion's amounts without jitter.
  Articulation articulation(const DriverMotion& motion, const Eigen::VectorXf& amounts,
                            const Eigen::VectorXf& steady) const;
  // One for each of the avatar's actions, as drive_gains returns them.
  void set_gains(std::vector<float> gains) { gains_ = std::move(gains); }

 private:
  Vec3f gaze(const Vec3f& rest, const Vec3f& change, Vec3f NamedAction::*eye) const;

  const DriveSubject& avatar_;
  bool clamp_, same_;
  ActionBasis driver_basis_, avatar_basis_;
  Eigen::MatrixXf match_;
  std::vector<float> gains_;
  Eigen::VectorXf rest_;  // the avatar's amounts at rest
  std::vector<ActionLimits> limits_, eye_limits_;
};

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

// Head and torso of one motion.
class HeadMap {
 public:
  HeadMap(const DriveSubject& driver, const DriveSubject& avatar, const DriveOptions& options);
  void place(const DriverMotion& motion, double dt, DrivenFrame& frame);

 private:
  const DriveSubject& avatar_;
  DriveOptions options_;
  Vec3d neck_;
  double ratio_;
  Follower torso_;
};

Vec3d neck_of(const DriveSubject& subject);
// Checks that a driver's frames match the avatar's model, and that every gain names an action.
Result<void> check_drive(const DriveSubject& driver, const DriveSubject& avatar, const DriveOptions& options);

}  // namespace likeness
