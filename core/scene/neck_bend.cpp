// The inverse of the bend by a walk up its table from the head's end: the step meets the share required by
// the height it leads to at least once, however the head is turned. Where a bowed chin folds the throat they
// meet more often; the first meeting is nearest to the head, which is what is seen.
#include "core/scene/neck_bend.h"

#include <algorithm>

#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr double kNoTurn = 1e-4;   // rad
constexpr double kNoShift = 5e-5;  // m

// The torso's share in the motion at a height.
float torso_share(const NeckBend& bend, float y) {
  const float u = std::clamp((bend.top - y) / (bend.top - bend.base), 0.0f, 1.0f);
  return u * u * (3 - 2 * u);
}

}  // namespace

NeckBend make_neck_bend(const NeckZone& zone, const Pose& head_from_torso, const Vec3f& origin, float side) {
  NeckBend bend;
  if (zone.empty()) return bend;
  const Vec3d middle = zone.middle.cast<double>();
  const Eigen::AngleAxisd whole = axis_and_angle(head_from_torso.linear());
  const Vec3d moved = head_from_torso * middle - middle;
  bend.straight = std::abs(whole.angle()) < kNoTurn && moved.norm() < kNoShift;
  bend.base = (zone.base - origin.y()) / side;
  bend.top = (zone.top - origin.y()) / side;
  const Vec3d from = origin.cast<double>();
  for (int k = 0; k <= kNeckSteps; ++k) {
    const double s = double(k) / kNeckSteps;
    const Eigen::Matrix3d back = rotation_about(whole.axis(), -s * whole.angle());
    // straight = back (posed - middle - s moved) + middle, with posed = from + side * x.
    const Vec3d shift = (back * (from - middle - s * moved) + middle - from) / double(side);
    bend.turn[std::size_t(k)] = back.cast<float>();
    bend.shift[std::size_t(k)] = shift.cast<float>();
    for (int a = 0; a < 3; ++a) bend.height[std::size_t(a)][std::size_t(k)] = float(back(1, a));
    bend.height[3][std::size_t(k)] = float(shift.y());
  }
  return bend;
}

Vec3f straightened(const NeckBend& bend, const Vec3f& posed) {
  if (bend.straight || posed.y() >= bend.top) return posed;
  // How much each step exceeds the share required by the height it leads to: never above 0 at the first,
  // never below 0 at the last. All at once: plain arrays make it a few instructions.
  std::array<float, kNeckSteps + 1> excess;
  const auto& [by_x, by_y, by_z, rest] = bend.height;
  const float per_height = 1 / (bend.top - bend.base);
  for (std::size_t k = 0; k < excess.size(); ++k) {
    const float y = by_x[k] * posed.x() + by_y[k] * posed.y() + by_z[k] * posed.z() + rest[k];
    const float u = std::min(std::max((bend.top - y) * per_height, 0.0f), 1.0f);
    excess[k] = float(int(k)) / kNeckSteps - u * u * (3 - 2 * u);
  }
  int high = 1;
  while (excess[std::size_t(high)] < 0 && high < kNeckSteps) ++high;
  const float at_low = excess[std::size_t(high - 1)], at_high = excess[std::size_t(high)];
  const int low = high - 1;
  const auto place = [&](int k) -> Vec3f {
    return bend.turn[std::size_t(k)] * posed + bend.shift[std::size_t(k)];
  };
  const float width = at_high - at_low;
  const float share = width > 0 ? std::clamp(-at_low / width, 0.0f, 1.0f) : 0.0f;
  return (1 - share) * place(low) + share * place(high);
}

Vec3f bent(const NeckBend& bend, const Vec3f& straight) {
  if (bend.straight || straight.y() >= bend.top) return straight;
  const float s = torso_share(bend, straight.y()) * kNeckSteps;
  const int low = std::clamp(int(s), 0, kNeckSteps - 1);
  const auto place = [&](int k) -> Vec3f {
    return bend.turn[std::size_t(k)].transpose() * (straight - bend.shift[std::size_t(k)]);
  };
  const float share = s - float(low);
  return (1 - share) * place(low) + share * place(low + 1);
}

}  // namespace likeness
