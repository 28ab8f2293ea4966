// The gains: see drive_options.h.
#include "core/drive/drive_options.h"

#include <algorithm>

#include "core/head/action_amounts.h"

namespace likeness {
namespace {

constexpr float kWorthCalibrating = 0.15f, kGainDeadZone = 1.1f, kMinGain = 0.75f, kLargestGain = 1.33f;

}  // namespace

std::vector<float> drive_gains(const DriveSubject& driver, const DriveSubject& avatar,
                               const DriveOptions& options) {
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
        if (ratio < 1 / kGainDeadZone) gain = std::max(ratio * kGainDeadZone, kMinGain);
      }
    }
    const auto user = options.gains.find(action.name);
    gains.push_back(user == options.gains.end() ? gain : gain * user->second);
  }
  return gains;
}

}  // namespace likeness
