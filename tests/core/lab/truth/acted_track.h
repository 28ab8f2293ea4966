// A track of the built-in head made up in code: turning head, acting face, a camera that rests.
#pragma once

#include <cmath>
#include <numbers>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/lab/truth/track_truth.h"

namespace likeness {

inline const HeadModel& acting_head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

inline TrackTruth acted_truth(int frames) {
  TrackTruth truth;
  truth.model = acting_head();
  truth.cameras.cameras = {Camera{-1, {512, 512, 700, 700, 256, 256}}};
  truth.track.head_model_name = truth.model.name;
  truth.track.head_model_hash = truth.model.hash;
  truth.track.person.identity = Eigen::VectorXf::Zero(truth.model.identity_count());
  for (int i = 0; i < frames; ++i) {
    const double t = 2 * std::numbers::pi * i / 40;
    TrackedFrame frame;
    frame.frame = i;
    frame.time_s = i / 25.0;
    frame.pose.world_from_head.linear() = Mat3d(Vec3d(1, -1, -1).asDiagonal()) *
                                          rotation_about(Vec3d::UnitY(), 0.5 * std::sin(t)) *
                                          rotation_about(Vec3d::UnitX(), 0.2 * std::cos(2 * t));
    frame.pose.world_from_head.translation() =
        Vec3d(0.02 * std::sin(t), 0.01 * std::cos(t), 0.6 + 0.03 * std::sin(3 * t));
    frame.pose.articulation = neutral_articulation(truth.model);
    double phase = 0;
    for (const std::string& name : compared_actions())
      if (const NamedAction* action = find_action(truth.model, name))
        add_action(frame.pose.articulation, *action, float(0.3 + 0.3 * std::sin(t + phase++)));
    frame.pose.articulation.left_eye = frame.pose.articulation.right_eye =
        Vec3f(0.1f * float(std::sin(5 * t)), 0.2f * float(std::cos(3 * t)), 0);
    truth.track.frames.push_back(frame);
  }
  return truth;
}

}  // namespace likeness
