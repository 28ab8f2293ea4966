// Lanes are nodes along x: see splat.h.
#include "core/scene/splat.h"

#include <algorithm>
#include <cmath>

// As in core/field/field_simd.cpp.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/scene/splat_simd.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.h:
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Df = hn::CappedTag<float, kSplatGroup>;
using Vf = hn::Vec<Df>;

// A pull over a row of nodes from x0 on; rest: what y and z add to the squared distance.
HWY_INLINE void add_to_row(const SplatGrid& grid, const Pull& pull, int x0, int x1, float rest, float reach2,
                           float soft2, std::size_t row) {
  const Df d;
  const Vf one = hn::Set(d, 1.0f), per_reach2 = hn::Set(d, 1 / reach2), soft = hn::Set(d, soft2),
           rests = hn::Set(d, rest);
  const int lanes = int(hn::Lanes(d));
  for (int x = x0; x <= x1; x += lanes) {
    const Vf dx = hn::Add(hn::Iota(d, 0), hn::Set(d, float(x) - pull.place.x()));
    const Vf d2 = hn::MulAdd(dx, dx, rests);
    const Vf end = hn::Max(hn::Zero(d), hn::NegMulAdd(d2, per_reach2, one));
    const Vf near = hn::Div(end, hn::Add(d2, soft)), w = hn::Mul(near, near);
    const std::size_t i = row + std::size_t(x);
    float* const to[3] = {grid.x + i, grid.y + i, grid.z + i};
    for (int a = 0; a < 3; ++a)
      hn::StoreU(hn::MulAdd(w, hn::Set(d, pull.way[a]), hn::LoadU(d, to[a])), d, to[a]);
    hn::StoreU(hn::Add(w, hn::LoadU(d, grid.weight + i)), d, grid.weight + i);
  }
}

void SplatPulls(const SplatGrid& grid, std::span<const Pull> pulls, int z0, int z1) {
  const float reach = grid.reach, reach2 = reach * reach, soft2 = grid.softness * grid.softness;
  for (const Pull& pull : pulls) {
    const Vec3f& c = pull.place;
    // Far outside, where whole numbers end, or no place at all: a face that no head model makes.
    const auto near = [&](int axis) {
      return c[axis] > -reach - 1 && c[axis] < float(grid.nodes[std::size_t(axis)]) + reach;
    };
    if (!near(0) || !near(1) || !near(2)) continue;
    const auto first = [&](int axis, int low) { return std::max(low, int(std::ceil(c[axis] - reach))); };
    const auto last = [&](int axis, int end) { return std::min(end - 1, int(std::floor(c[axis] + reach))); };
    const int x0 = first(0, 0), x1 = last(0, grid.nodes[0]);
    for (int z = first(2, z0); z <= last(2, z1); ++z)
      for (int y = first(1, 0); y <= last(1, grid.nodes[1]); ++y) {
        const float dy = float(y) - c.y(), dz = float(z) - c.z(), rest = dy * dy + dz * dz;
        if (rest < reach2)
          add_to_row(grid, pull, x0, x1, rest, reach2, soft2,
                     std::size_t(z) * grid.plane + std::size_t(y) * grid.row);
      }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace likeness {

HWY_EXPORT(SplatPulls);

void splat_pulls(const SplatGrid& grid, std::span<const Pull> pulls, int z0, int z1) {
  HWY_DYNAMIC_DISPATCH(SplatPulls)(grid, pulls, z0, z1);
}

}  // namespace likeness
#endif  // HWY_ONCE
