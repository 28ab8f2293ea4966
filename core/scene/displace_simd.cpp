// Points moved by a warp lattice, many at a time: see displace_points in warp_lattice.h. Lanes are points; a
// pair of nodes that are neighbours in z is three words of the table.
#include "core/scene/warp_lattice.h"

#include <algorithm>
#include <cstring>

// As in core/field/field_simd.cpp.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/scene/displace_simd.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.h:
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Df = hn::CappedTag<float, 16>;
using Di = hn::RebindToSigned<Df>;
using Vf = hn::Vec<Df>;
using Vi = hn::Vec<Di>;
inline constexpr std::size_t kLanes = hn::MaxLanes(Df());

static_assert(sizeof(WarpLattice::Column) == 8, "base, then first and stored in one word");

HWY_INLINE Vf low_count(Vi word) { return hn::ConvertTo(Df(), hn::ShiftRight<16>(hn::ShiftLeft<16>(word))); }
HWY_INLINE Vf high_count(Vi word) { return hn::ConvertTo(Df(), hn::ShiftRight<16>(word)); }

// way (3 rows of kLanes): the displacement at the points `p` (3 rows), m.
HWY_INLINE void lattice_way(const WarpLattice& lattice, const float (&p)[3][kLanes],
                            float (&way)[3][kLanes]) {
  const Df d;
  const Di di;
  const Vf per_cell = hn::Set(d, 1 / lattice.cell);
  Vf share[3];
  Vi node[3];
  auto inside = hn::Eq(per_cell, per_cell);
  for (std::size_t a = 0; a < 3; ++a) {
    const Vf at = hn::Mul(hn::Sub(hn::Load(d, p[a]), hn::Set(d, lattice.origin[Eigen::Index(a)])), per_cell);
    const auto here = hn::And(hn::Ge(at, hn::Zero(d)), hn::Lt(at, hn::Set(d, float(lattice.nodes[a] - 1))));
    const Vf safe = hn::IfThenElseZero(here, at);
    inside = hn::And(inside, here);
    node[a] = hn::ConvertTo(di, safe);
    share[a] = hn::Sub(safe, hn::ConvertTo(d, node[a]));
  }
  const auto* columns = reinterpret_cast<const std::int32_t*>(lattice.columns.data());
  const auto* rows = reinterpret_cast<const std::int32_t*>(lattice.displacement.data());
  const Vi across = hn::Set(di, lattice.nodes[0]),
           column_bytes = hn::Set(di, int(sizeof(WarpLattice::Column))),
           row_bytes = hn::Set(di, 3 * int(sizeof(std::int16_t)));
  const Vf one = hn::Set(d, 1.0f);
  Vf sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (int c = 0; c < 4; ++c) {
    const Vi x = hn::Add(node[0], hn::Set(di, c & 1)), y = hn::Add(node[1], hn::Set(di, c >> 1));
    const Vi column = hn::Mul(hn::Add(hn::Mul(y, across), x), column_bytes);
    const Vi base = hn::GatherOffset(di, columns, column);
    const Vi stretch = hn::GatherOffset(di, columns, hn::Add(column, hn::Set(di, 4)));
    const Vi first = hn::ShiftRight<16>(hn::ShiftLeft<16>(stretch)), stored = hn::ShiftRight<16>(stretch);
    const Vi along = hn::Sub(hn::Add(node[2], hn::Set(di, 1)), first);
    const auto beyond = hn::Or(hn::Lt(along, hn::Zero(di)), hn::Gt(along, stored));
    const Vi offset = hn::Mul(hn::IfThenZeroElse(beyond, hn::Add(base, node[2])), row_bytes);
    const Vi xy = hn::GatherOffset(di, rows, offset);
    const Vi zx = hn::GatherOffset(di, rows, hn::Add(offset, hn::Set(di, 4)));
    const Vi yz = hn::GatherOffset(di, rows, hn::Add(offset, hn::Set(di, 8)));
    const Vf weight =
        hn::Mul(c & 1 ? share[0] : hn::Sub(one, share[0]), c >> 1 ? share[1] : hn::Sub(one, share[1]));
    const Vf far = hn::Mul(weight, share[2]), near = hn::Sub(weight, far);
    sum[0] = hn::MulAdd(near, low_count(xy), hn::MulAdd(far, high_count(zx), sum[0]));
    sum[1] = hn::MulAdd(near, high_count(xy), hn::MulAdd(far, low_count(yz), sum[1]));
    sum[2] = hn::MulAdd(near, low_count(zx), hn::MulAdd(far, high_count(yz), sum[2]));
  }
  const Vf unit = hn::IfThenElseZero(inside, hn::Set(d, lattice.unit));
  for (int a = 0; a < 3; ++a) hn::Store(hn::Mul(unit, sum[a]), d, way[a]);
}

void DisplacePoints(const WarpLattice& lattice, const Vec3f& origin, float side, std::size_t count, float* x,
                    float* y, float* z) {
  const Df d;
  const MouthGap& gap = lattice.mouth;
  float* axes[3] = {x, y, z};
  alignas(64) float unit[3][kLanes] = {}, p[3][kLanes], way[3][kLanes];
  for (std::size_t begin = 0; begin < count; begin += kLanes) {
    const std::size_t own = std::min(kLanes, count - begin);
    for (int a = 0; a < 3; ++a) {
      std::memcpy(unit[a], axes[a] + begin, own * sizeof(float));
      hn::Store(hn::MulAdd(hn::Load(d, unit[a]), hn::Set(d, side), hn::Set(d, origin[a])), d, p[a]);
    }
    lattice_way(lattice, p, way);
    for (std::size_t k = 0; gap.open > 0 && k < own; ++k) {
      if (p[1][k] < gap.low.y() || p[1][k] > gap.high.y()) continue;
      const Vec3f point(p[0][k], p[1][k], p[2][k]);
      if (!in_gap(gap, point)) continue;
      const Vec3f there = way_to_pocket(gap, point);
      for (int a = 0; a < 3; ++a) way[a][k] = there[a];
    }
    const Vf per_side = hn::Set(d, 1 / side), zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    for (int a = 0; a < 3; ++a) {
      const Vf moved = hn::MulAdd(hn::Load(d, way[a]), per_side, hn::Load(d, unit[a]));
      hn::Store(hn::Min(hn::Max(moved, zero), one), d, way[a]);
      std::memcpy(axes[a] + begin, way[a], own * sizeof(float));
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace likeness {

HWY_EXPORT(DisplacePoints);

void displace_points(const WarpLattice& lattice, const Vec3f& origin, float side, std::size_t count, float* x,
                     float* y, float* z) {
  if (!lattice.empty()) HWY_DYNAMIC_DISPATCH(DisplacePoints)(lattice, origin, side, count, x, y, z);
}

}  // namespace likeness
#endif  // HWY_ONCE
