// The inverse of the bend by a walk up its table from the head's end: the step and the share that the height
// it leads to asks for meet at least once, however the head is turned. Where a bowed chin folds the throat
// they meet more often; the first meeting is what lies nearest to the head, which is what is seen.
#include "core/scene/neck_bend.h"

#include <algorithm>

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
  const Eigen::AngleAxisd whole(head_from_torso.linear());
  const Vec3d moved = head_from_torso * middle - middle;
  bend.straight = std::abs(whole.angle()) < kNoTurn && moved.norm() < kNoShift;
  bend.base = (zone.base - origin.y()) / side;
  bend.top = (zone.top - origin.y()) / side;
  const Vec3d from = origin.cast<double>();
  for (int k = 0; k <= kNeckSteps; ++k) {
    const double s = double(k) / kNeckSteps;
    const Eigen::Matrix3d back = Eigen::AngleAxisd(-s * whole.angle(), whole.axis()).toRotationMatrix();
    // straight = back (posed - middle - s moved) + middle, with posed = from + side * x.
    const Vec3d shift = (back * (from - middle - s * moved) + middle - from) / double(side);
    bend.turn[std::size_t(k)] = back.cast<float>();
    bend.shift[std::size_t(k)] = shift.cast<float>();
  }
  return bend;
}

Vec3f straightened(const NeckBend& bend, const Vec3f& posed) {
  if (bend.straight || posed.y() >= bend.top) return posed;
  // How much more the step takes than the height it leads to asks for: never above 0 at the first step, never
  // below 0 at the last.
  const auto excess = [&](int k) {
    const float y = bend.turn[std::size_t(k)].row(1).dot(posed) + bend.shift[std::size_t(k)].y();
    return float(k) / kNeckSteps - torso_share(bend, y);
  };
  int high = 1;
  float at_low = excess(0), at_high = excess(1);
  while (at_high < 0 && high < kNeckSteps) at_low = at_high, at_high = excess(++high);
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
