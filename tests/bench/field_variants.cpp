// Arrangements of the field's kernels side by side: see field_variants.h.
#include "tests/bench/field_variants.h"

#include <algorithm>

#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/field_variants.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.h, which includes this file again once per target:
#include "core/field/grid_simd-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {

void read_scalar(const float* table, const CellTile& cells, float* rows) {
  for (std::size_t f = 0; f < 2; ++f) {
    for (std::size_t s = 0; s < kTile; ++s) {
      float sum = 0;
      for (int c = 0; c < 8; ++c) sum += cells.weight[c][s] * table[cells.entry[c][s] + f];
      rows[f * kTile + s] = sum;
    }
  }
}

void ReadLevel(const TableCase& c, int index, Read how, float* rows) {
  const GridLevel& level = c.layout.position[std::size_t(index)];
  const float* table = c.parameters + level.offset;
  alignas(64) CellTile cells;
  for (std::size_t n = 0; n < c.count; n += kTile, rows += 2 * kTile) {
    const float* point[3] = {c.point[0] + n, c.point[1] + n, c.point[2] + n};
    cells_of<3>(level, 2, point, cells);
    if (how == Read::scalar) read_scalar(table, cells, rows);
    if (how == Read::pairs) gather_pairs<8>(table, cells, rows);
    if (how == Read::neighbours) gather_neighbours<8>(table, cells, rows);
  }
}

void ReadLevels(const TableCase& c, std::size_t chunk, float* rows) {
  const std::size_t stride = c.layout.position.size() * 2 * kTile;
  alignas(64) CellTile cells;
  for (std::size_t begin = 0; begin < c.count; begin += chunk) {
    for (std::size_t l = 0; l < c.layout.position.size(); ++l) {
      for (std::size_t n = begin; n < std::min(c.count, begin + chunk); n += kTile) {
        const float* point[3] = {c.point[0] + n, c.point[1] + n, c.point[2] + n};
        encode_tile(c.layout.position[l], c.config.position, c.parameters, point, cells,
                    rows + n / kTile * stride + l * 2 * kTile);
      }
    }
  }
}

template <bool kMark>
void update_in_order(float* table, std::uint8_t* touched, const CellTile& cells, const float* rows) {
  const hn::FixedTag<float, 2> half;
  for (std::size_t s = 0; s < kTile; ++s) {
    alignas(8) const float pair[2] = {rows[s], rows[kTile + s]};
    const auto gradient = hn::Load(half, pair);
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) {
      const std::uint32_t at = cells.entry[c][s];
      if (kMark) touched[at / kTableLine] = 1;
      hn::StoreU(hn::MulAdd(hn::Set(half, cells.weight[c][s]), gradient, hn::LoadU(half, table + at)), half,
                 table + at);
    }
  }
}

void UpdateLevel(const TableCase& c, int index, Update how, const float* rows, float* gradients,
                 std::uint8_t* touched) {
  const GridLevel& level = c.layout.position[std::size_t(index)];
  const std::size_t stride = c.layout.position.size() * 2 * kTile;
  float* table = gradients + level.offset;
  touched += level.offset / kTableLine;
  alignas(64) CellTile cells;
  rows += std::size_t(index) * 2 * kTile;
  for (std::size_t n = 0; n < c.count; n += kTile, rows += stride) {
    const float* point[3] = {c.point[0] + n, c.point[1] + n, c.point[2] + n};
    cells_of<3>(level, 2, point, cells);
    if (how == Update::marking) update_in_order<true>(table, touched, cells, rows);
    if (how == Update::in_order) update_in_order<false>(table, touched, cells, rows);
    if (how == Update::ahead)
      for (std::size_t i = 0; i < 2 * kTile; i += kTableLine) __builtin_prefetch(rows + 4 * stride + i);
    if (how == Update::apart || how == Update::ahead)
      scatter_tile<8>(table, level.hashed, cells, 2, rows, kTile);
  }
  if (how != Update::marking) mark_lines(table, level.entries * 2, touched);
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace likeness {

HWY_EXPORT(ReadLevel);
HWY_EXPORT(ReadLevels);
HWY_EXPORT(UpdateLevel);

void read_level(const TableCase& c, int level, Read how, float* rows) {
  HWY_DYNAMIC_DISPATCH(ReadLevel)(c, level, how, rows);
}
void read_levels(const TableCase& c, std::size_t chunk, float* rows) {
  HWY_DYNAMIC_DISPATCH(ReadLevels)(c, chunk, rows);
}
void update_level(const TableCase& c, int level, Update how, const float* rows, float* gradients,
                  std::uint8_t* touched) {
  HWY_DYNAMIC_DISPATCH(UpdateLevel)(c, level, how, rows, gradients, touched);
}

}  // namespace likeness
#endif  // HWY_ONCE
