// Straightening with the steps of the bend's table in lanes: see straightened_in_lanes in neck_bend.h.
#include "core/scene/neck_bend.h"

#include <algorithm>

// As in core/field/field_simd.cpp.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/scene/straighten_simd.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.h:
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Df = hn::CappedTag<float, 16>;
using Vf = hn::Vec<Df>;
static_assert(kNeckSteps % hn::MaxLanes(Df()) == 0);

Vec3f StraightenedInLanes(const NeckBend& bend, const Vec3f& posed) {
  if (bend.straight || posed.y() >= bend.top) return posed;
  const Df d;
  const auto& [by_x, by_y, by_z, rest] = bend.height;
  const float per_height = 1 / (bend.top - bend.base);
  const Vf x = hn::Set(d, posed.x()), y = hn::Set(d, posed.y()), z = hn::Set(d, posed.z()),
           top = hn::Set(d, bend.top), per = hn::Set(d, per_height), zero = hn::Zero(d),
           one = hn::Set(d, 1.f);
  // The last step is never below what its height requires: it is used only if no other is met.
  alignas(64) float excess[kNeckSteps + 1];
  int high = kNeckSteps;
  for (std::size_t k = 0; k < std::size_t(kNeckSteps); k += hn::Lanes(d)) {
    const Vf height =
        hn::MulAdd(hn::LoadU(d, by_x.data() + k), x,
                   hn::MulAdd(hn::LoadU(d, by_y.data() + k), y,
                              hn::MulAdd(hn::LoadU(d, by_z.data() + k), z, hn::LoadU(d, rest.data() + k))));
    const Vf u = hn::Min(hn::Max(hn::Mul(hn::Sub(top, height), per), zero), one);
    const Vf asked = hn::Mul(hn::Mul(u, u), hn::NegMulAdd(hn::Set(d, 2.f), u, hn::Set(d, 3.f)));
    const Vf step = hn::Mul(hn::Iota(d, float(k)), hn::Set(d, 1.f / kNeckSteps));
    const Vf over = hn::Sub(step, asked);
    hn::Store(over, d, excess + k);
    const auto first = hn::Eq(step, zero);  // no meeting ends at it
    const auto met = hn::FindFirstTrue(d, hn::Not(hn::Or(hn::Lt(over, zero), first)));
    if (met < 0) continue;
    high = int(k) + int(met);
    break;
  }
  if (high == kNeckSteps) {
    const float height =
        by_x.back() * posed.x() + by_y.back() * posed.y() + by_z.back() * posed.z() + rest.back();
    const float u = std::min(std::max((bend.top - height) * per_height, 0.0f), 1.0f);
    excess[kNeckSteps] = 1 - u * u * (3 - 2 * u);
  }
  const float at_low = excess[high - 1], width = excess[high] - at_low;
  const float share = width > 0 ? std::clamp(-at_low / width, 0.0f, 1.0f) : 0.0f;
  const auto low = std::size_t(high - 1), up = std::size_t(high);
  const Eigen::Matrix3f turn = (1 - share) * bend.turn[low] + share * bend.turn[up];
  return turn * posed + ((1 - share) * bend.shift[low] + share * bend.shift[up]);
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace likeness {

HWY_EXPORT(StraightenedInLanes);

Vec3f straightened_in_lanes(const NeckBend& bend, const Vec3f& posed) {
  return HWY_DYNAMIC_DISPATCH(StraightenedInLanes)(bend, posed);
}

}  // namespace likeness
#endif  // HWY_ONCE
