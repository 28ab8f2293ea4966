// Multi-linear grid look-ups and their transposes over one tile of samples, for every SIMD target. Included
// by field_simd.cpp once per target.
//
// Cells and weights are computed with samples in lanes. The look-ups then go sample by sample, since an entry
// of two or four features is one load, faster than a gather.
#if defined(LIKENESS_GRID_SIMD_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef LIKENESS_GRID_SIMD_INL
#undef LIKENESS_GRID_SIMD_INL
#else
#define LIKENESS_GRID_SIMD_INL
#endif

#include <cstddef>
#include <cstdint>

#include "core/field/field_kernels.h"
#include "core/field/field_layout.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Corners of the cells of a tile: first parameter of the entry within the level, and weight.
struct CellTile {
  alignas(64) std::uint32_t entry[8][kTile];
  alignas(64) float weight[8][kTile];
};

using Dg = hn::CappedTag<float, 16>;
using Vg = hn::Vec<Dg>;
using Vcell = hn::Vec<hn::RebindToSigned<Dg>>;

// Cells along one axis of the points `x` in [0, 1], clamped, and the points' positions within them.
HWY_INLINE Vg cell_part(Vg x, int resolution, Vcell& cell) {
  const Dg d;
  const hn::RebindToSigned<Dg> di;
  const Vg p = hn::Mul(hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, 1.0f)), hn::Set(d, float(resolution)));
  cell = hn::Min(hn::ConvertTo(di, p), hn::Set(di, resolution - 1));
  return hn::Sub(p, hn::ConvertTo(d, cell));
}

// point: kDims rows.
template <int kDims>
HWY_NOINLINE void cells_of(const GridLevel& level, int features, const float* const* point, CellTile& cells) {
  const Dg d;
  const hn::RebindToUnsigned<Dg> du;
  using U = hn::Vec<decltype(du)>;
  // Keys count parameters, not entries: the features of an entry are a power of two, which hashes and masks
  // preserve.
  const std::uint32_t width = std::uint32_t(features);
  const U mask = hn::Set(du, level.mask * width);
  for (std::size_t s = 0; s < kTile; s += hn::Lanes(d)) {
    Vg weight[3][2];
    U key[3][2];
    for (int a = 0; a < kDims; ++a) {
      Vcell cell;
      const Vg part = cell_part(hn::LoadU(d, point[a] + s), level.resolution, cell);
      weight[a][0] = hn::Sub(hn::Set(d, 1.0f), part), weight[a][1] = part;
      const U factor = hn::Set(du, (level.hashed ? kHashPrime[a] : level.stride[a]) * width);
      key[a][0] = hn::Mul(hn::BitCast(du, cell), factor);
      key[a][1] = hn::Add(key[a][0], factor);
    }
#pragma GCC unroll 8
    for (int c = 0; c < (1 << kDims); ++c) {
      Vg w = weight[0][c & 1];
      U e = key[0][c & 1];
#pragma GCC unroll 2
      for (int a = 1; a < kDims; ++a) {
        w = hn::Mul(w, weight[a][(c >> a) & 1]);
        e = level.hashed ? hn::Xor(e, key[a][(c >> a) & 1]) : hn::Add(e, key[a][(c >> a) & 1]);
      }
      if (level.hashed) e = hn::And(e, mask);
      hn::Store(e, du, &cells.entry[c][s]);
      hn::Store(w, d, &cells.weight[c][s]);
    }
  }
}

// The same four features of four neighbouring samples: rows to samples and back.
template <class V4>
HWY_INLINE void transpose_quad(V4 (&v)[4]) {
  const hn::FixedTag<float, 4> d;
  const V4 low01 = hn::InterleaveLower(d, v[0], v[1]), low23 = hn::InterleaveLower(d, v[2], v[3]);
  const V4 high01 = hn::InterleaveUpper(d, v[0], v[1]), high23 = hn::InterleaveUpper(d, v[2], v[3]);
  v[0] = hn::ConcatLowerLower(d, low23, low01);
  v[1] = hn::ConcatUpperUpper(d, low23, low01);
  v[2] = hn::ConcatLowerLower(d, high23, high01);
  v[3] = hn::ConcatUpperUpper(d, high23, high01);
}

// rows (features, kTile) = sum over corners of weight times entry.
template <int kCorners>
HWY_INLINE void gather_quads(const float* table, const CellTile& cells, int features, float* rows) {
  const hn::FixedTag<float, 4> d;
  for (int f = 0; f < features; f += 4, rows += 4 * kTile) {
    for (std::size_t s = 0; s < kTile; s += 4) {
      hn::Vec<decltype(d)> sum[4];
#pragma GCC unroll 4
      for (int k = 0; k < 4; ++k) {
        sum[k] = hn::Mul(hn::Set(d, cells.weight[0][s + k]), hn::LoadU(d, table + cells.entry[0][s + k] + f));
#pragma GCC unroll 7
        for (int c = 1; c < kCorners; ++c) {
          sum[k] = hn::MulAdd(hn::Set(d, cells.weight[c][s + k]),
                              hn::LoadU(d, table + cells.entry[c][s + k] + f), sum[k]);
        }
      }
      transpose_quad(sum);
      for (int k = 0; k < 4; ++k) hn::Store(sum[k], d, rows + k * kTile + s);
    }
  }
}

// Two neighbouring entries of two features each, from anywhere: half a vector per sample.
HWY_INLINE hn::Vec<hn::FixedTag<float, 4>> two_pairs(const float* table, const std::uint32_t* entry) {
  const hn::FixedTag<float, 2> half;
  return hn::Combine(hn::FixedTag<float, 4>(), hn::LoadU(half, table + entry[1]),
                     hn::LoadU(half, table + entry[0]));
}

// As gather_quads, for two features: a vector holds two samples.
template <int kCorners>
HWY_INLINE void gather_pairs(const float* table, const CellTile& cells, float* rows) {
  const hn::FixedTag<float, 4> d;
  for (std::size_t s = 0; s < kTile; s += 4) {
    auto low = hn::Zero(d), high = hn::Zero(d);
#pragma GCC unroll 8
    for (int c = 0; c < kCorners; ++c) {
      const auto w = hn::Load(d, &cells.weight[c][s]);
      low = hn::MulAdd(hn::InterleaveLower(d, w, w), two_pairs(table, &cells.entry[c][s]), low);
      high = hn::MulAdd(hn::InterleaveUpper(d, w, w), two_pairs(table, &cells.entry[c][s + 2]), high);
    }
    hn::Store(hn::ConcatEven(d, high, low), d, rows + s);
    hn::Store(hn::ConcatOdd(d, high, low), d, rows + kTile + s);
  }
}

// Weights of a corner and its neighbour in x for four samples, as vectors (w, w, w', w').
HWY_INLINE void pair_weights(const float* weight, const float* next,
                             hn::Vec<hn::FixedTag<float, 4>> (&out)[4]) {
  const hn::FixedTag<float, 4> d;
  const auto w = hn::Load(d, weight), v = hn::Load(d, next);
  const auto low = hn::InterleaveLower(d, w, v), high = hn::InterleaveUpper(d, w, v);
  out[0] = hn::InterleaveLower(d, low, low), out[1] = hn::InterleaveUpper(d, low, low);
  out[2] = hn::InterleaveLower(d, high, high), out[3] = hn::InterleaveUpper(d, high, high);
}

// As gather_pairs, for a dense level: a corner's neighbour in x follows it, so one load reads both.
template <int kCorners>
HWY_INLINE void gather_neighbours(const float* table, const CellTile& cells, float* rows) {
  const hn::FixedTag<float, 4> d;
  for (std::size_t s = 0; s < kTile; s += 4) {
    hn::Vec<decltype(d)> sum[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
#pragma GCC unroll 4
    for (int c = 0; c < kCorners; c += 2) {
      hn::Vec<decltype(d)> w[4];
      pair_weights(&cells.weight[c][s], &cells.weight[c + 1][s], w);
#pragma GCC unroll 4
      for (int k = 0; k < 4; ++k)
        sum[k] = hn::MulAdd(w[k], hn::LoadU(d, table + cells.entry[c][s + k]), sum[k]);
    }
    const auto low =
        hn::Add(hn::ConcatLowerLower(d, sum[1], sum[0]), hn::ConcatUpperUpper(d, sum[1], sum[0]));
    const auto high =
        hn::Add(hn::ConcatLowerLower(d, sum[3], sum[2]), hn::ConcatUpperUpper(d, sum[3], sum[2]));
    hn::Store(hn::ConcatEven(d, high, low), d, rows + s);
    hn::Store(hn::ConcatOdd(d, high, low), d, rows + kTile + s);
  }
}

template <int kCorners>
HWY_NOINLINE void gather_tile(const float* table, bool hashed, const CellTile& cells, int features,
                              float* rows) {
  if (features % 4 == 0) return gather_quads<kCorners>(table, cells, features, rows);
  if (features == 2 && !hashed) return gather_neighbours<kCorners>(table, cells, rows);
  if (features == 2) return gather_pairs<kCorners>(table, cells, rows);
  for (int f = 0; f < features; ++f) {
    for (std::size_t s = 0; s < kTile; ++s) {
      float sum = 0;
      for (int c = 0; c < kCorners; ++c) sum += cells.weight[c][s] * table[cells.entry[c][s] + f];
      rows[f * kTile + s] = sum;
    }
  }
}

// size (kTile): largest absolute gradient of each sample.
HWY_INLINE void gradient_sizes(const float* rows, int features, float* size) {
  const hn::CappedTag<float, 16> d;
  for (std::size_t s = 0; s < kTile; s += hn::Lanes(d)) {
    auto most = hn::Abs(hn::Load(d, rows + s));
    for (int f = 1; f < features; ++f) most = hn::Max(most, hn::Abs(hn::Load(d, rows + f * kTile + s)));
    hn::Store(most, d, size + s);
  }
}

// Samples of a tile in an order that keeps neighbours apart: those of a ray often share a cell, and an update
// of an entry must wait for the previous one.
constexpr std::size_t kApart = 16;
template <class Update>
HWY_INLINE void each_apart(const float* size, std::size_t count, const Update& update) {
  for (std::size_t k = 0; k < kApart; ++k) {
#pragma GCC unroll 4
    for (std::size_t s = k; s < kTile; s += kApart) {
      if (s < count && size[s] != 0) update(s);
    }
  }
}

// Four features of a sample at a time.
template <int kCorners>
HWY_INLINE void scatter_quads(float* table, const CellTile& cells, const float* rows, const float* size,
                              std::size_t count) {
  const hn::FixedTag<float, 4> d;
  alignas(64) float gradients[4 * kTile];
  for (std::size_t s = 0; s < kTile; s += 4) {
    hn::Vec<decltype(d)> v[4];
    for (int k = 0; k < 4; ++k) v[k] = hn::Load(d, rows + k * kTile + s);
    transpose_quad(v);
    for (std::size_t k = 0; k < 4; ++k) hn::Store(v[k], d, gradients + 4 * (s + k));
  }
  each_apart(size, count, [&](std::size_t s) HWY_ATTR {
    const auto gradient = hn::Load(d, gradients + 4 * s);
#pragma GCC unroll 8
    for (int c = 0; c < kCorners; ++c) {
      float* entry = table + cells.entry[c][s];
      hn::StoreU(hn::MulAdd(hn::Set(d, cells.weight[c][s]), gradient, hn::LoadU(d, entry)), d, entry);
    }
  });
}

// (first, second) of every sample one after the other.
HWY_INLINE void interleave_pairs(const float* rows, float* pairs) {
  const hn::FixedTag<float, 4> d;
  for (std::size_t s = 0; s < kTile; s += 4) {
    const auto first = hn::Load(d, rows + s), second = hn::Load(d, rows + kTile + s);
    hn::Store(hn::InterleaveLower(d, first, second), d, pairs + 2 * s);
    hn::Store(hn::InterleaveUpper(d, first, second), d, pairs + 2 * s + 4);
  }
}

// As scatter_quads, for two features.
template <int kCorners>
HWY_INLINE void scatter_pairs(float* table, const CellTile& cells, const float* rows, const float* size,
                              std::size_t count) {
  const hn::FixedTag<float, 2> half;
  alignas(64) float gradients[2 * kTile];
  interleave_pairs(rows, gradients);
  each_apart(size, count, [&](std::size_t s) HWY_ATTR {
    const auto gradient = hn::Load(half, gradients + 2 * s);
#pragma GCC unroll 8
    for (int c = 0; c < kCorners; ++c) {
      float* entry = table + cells.entry[c][s];
      hn::StoreU(hn::MulAdd(hn::Set(half, cells.weight[c][s]), gradient, hn::LoadU(half, entry)), half,
                 entry);
    }
  });
}

// As scatter_pairs, for a dense level: a corner's neighbour in x follows it, so both are one update.
template <int kCorners>
HWY_INLINE void scatter_neighbours(float* table, const CellTile& cells, const float* rows, const float* size,
                                   std::size_t count) {
  const hn::FixedTag<float, 4> d;
  const hn::FixedTag<float, 2> half;
  alignas(64) float gradients[2 * kTile], weights[kCorners / 2][4 * kTile];
  interleave_pairs(rows, gradients);
#pragma GCC unroll 4
  for (int c = 0; c < kCorners; c += 2) {
    for (std::size_t s = 0; s < kTile; s += 4) {
      hn::Vec<decltype(d)> w[4];
      pair_weights(&cells.weight[c][s], &cells.weight[c + 1][s], w);
      for (std::size_t k = 0; k < 4; ++k) hn::Store(w[k], d, weights[c / 2] + 4 * (s + k));
    }
  }
  each_apart(size, count, [&](std::size_t s) HWY_ATTR {
    const auto pair = hn::Load(half, gradients + 2 * s);
    const auto gradient = hn::Combine(d, pair, pair);
#pragma GCC unroll 4
    for (int c = 0; c < kCorners; c += 2) {
      float* entry = table + cells.entry[c][s];
      hn::StoreU(hn::MulAdd(hn::Load(d, weights[c / 2] + 4 * s), gradient, hn::LoadU(d, entry)), d, entry);
    }
  });
}

// Adds weight times rows to the entries of the first `count` samples. Samples whose gradient is zero touch
// nothing.
template <int kCorners>
HWY_INLINE void scatter_tile(float* table, bool hashed, const CellTile& cells, int features,
                             const float* rows, std::size_t count) {
  alignas(64) float size[kTile];
  gradient_sizes(rows, features, size);
  if (features % 4 == 0) {
    for (int f = 0; f < features; f += 4) {
      scatter_quads<kCorners>(table + f, cells, rows + f * kTile, size, count);
    }
    return;
  }
  if (features == 2 && !hashed) return scatter_neighbours<kCorners>(table, cells, rows, size, count);
  if (features == 2) return scatter_pairs<kCorners>(table, cells, rows, size, count);
  for (std::size_t s = 0; s < count; ++s) {
    if (size[s] == 0) continue;
    for (int c = 0; c < kCorners; ++c) {
      const std::uint32_t at = cells.entry[c][s];
      for (int f = 0; f < features; ++f) table[at + f] += cells.weight[c][s] * rows[f * kTile + s];
    }
  }
}

// Marks the lines of a level's table that have a gradient. Done once, while the table is still in the cache:
// marking with every update takes a third longer.
HWY_NOINLINE inline void mark_lines(const float* gradients, std::size_t count, std::uint8_t* touched) {
  const Dg d;
  for (std::size_t i = 0; i < count; i += kTableLine, ++touched) {
    Vg most = hn::Zero(d);  // whole lines: zeros fill the gap after a table
    for (std::size_t k = 0; k < kTableLine; k += hn::Lanes(d))
      most = hn::Or(most, hn::LoadU(d, gradients + i + k));
    if (!hn::AllFalse(d, hn::Ne(most, hn::Zero(d)))) *touched = 1;
  }
}

// -- The same with the number of dimensions known at run time.

HWY_NOINLINE inline void encode_tile(const GridLevel& level, const GridConfig& grid, const float* parameters,
                                     const float* const* point, CellTile& cells, float* rows) {
  const float* table = parameters + level.offset;
  if (grid.dimensions == 3) {
    cells_of<3>(level, grid.features, point, cells);
    gather_tile<8>(table, level.hashed, cells, grid.features, rows);
  } else if (grid.dimensions == 2) {
    cells_of<2>(level, grid.features, point, cells);
    gather_tile<4>(table, level.hashed, cells, grid.features, rows);
  } else {
    cells_of<1>(level, grid.features, point, cells);
    gather_tile<2>(table, level.hashed, cells, grid.features, rows);
  }
}

HWY_NOINLINE inline void encode_tile_backward(const GridLevel& level, const GridConfig& grid,
                                              const float* const* point, CellTile& cells, const float* rows,
                                              std::size_t count, float* gradients) {
  float* table = gradients + level.offset;
  if (grid.dimensions == 3) {
    cells_of<3>(level, grid.features, point, cells);
    scatter_tile<8>(table, level.hashed, cells, grid.features, rows, count);
  } else if (grid.dimensions == 2) {
    cells_of<2>(level, grid.features, point, cells);
    scatter_tile<4>(table, level.hashed, cells, grid.features, rows, count);
  } else {
    cells_of<1>(level, grid.features, point, cells);
    scatter_tile<2>(table, level.hashed, cells, grid.features, rows, count);
  }
}

// dots (kCorners, kTile) = entry of the corner times the features' gradients, summed over the features.
template <int kCorners>
HWY_INLINE void corner_dots(const float* table, const CellTile& cells, int features, const float* gradients,
                            float (*dots)[kTile]) {
  const hn::FixedTag<float, 4> d;
  if (features == 2) {
    for (std::size_t s = 0; s < kTile; s += 4) {
      const auto first = hn::Load(d, gradients + s), second = hn::Load(d, gradients + kTile + s);
      const auto low = hn::InterleaveLower(d, first, second), high = hn::InterleaveUpper(d, first, second);
#pragma GCC unroll 8
      for (int c = 0; c < kCorners; ++c) {
        const auto a = hn::Mul(low, two_pairs(table, &cells.entry[c][s]));
        const auto b = hn::Mul(high, two_pairs(table, &cells.entry[c][s + 2]));
        hn::Store(hn::Add(hn::ConcatEven(d, b, a), hn::ConcatOdd(d, b, a)), d, &dots[c][s]);
      }
    }
    return;
  }
  if (features % 4 == 0) {
    for (std::size_t s = 0; s < kTile; s += 4) {
      for (int f = 0; f < features; f += 4) {
        hn::Vec<decltype(d)> gradient[4];
        for (int k = 0; k < 4; ++k) gradient[k] = hn::Load(d, gradients + (f + k) * kTile + s);
        transpose_quad(gradient);
#pragma GCC unroll 8
        for (int c = 0; c < kCorners; ++c) {
          hn::Vec<decltype(d)> part[4];
#pragma GCC unroll 4
          for (int k = 0; k < 4; ++k)
            part[k] = hn::Mul(gradient[k], hn::LoadU(d, table + cells.entry[c][s + k] + f));
          transpose_quad(part);
          const auto sum = hn::Add(hn::Add(part[0], part[1]), hn::Add(part[2], part[3]));
          hn::Store(f == 0 ? sum : hn::Add(sum, hn::Load(d, &dots[c][s])), d, &dots[c][s]);
        }
      }
    }
    return;
  }
  for (int c = 0; c < kCorners; ++c) {
    for (std::size_t s = 0; s < kTile; ++s) {
      const float* entry = table + cells.entry[c][s];
      float sum = 0;
      for (int f = 0; f < features; ++f) sum += entry[f] * gradients[f * kTile + s];
      dots[c][s] = sum;
    }
  }
}

// sum (kDims, kTile) += derivative of the corners' weights with respect to the point, times `dots`.
template <int kDims>
HWY_INLINE void add_point_slopes(const GridLevel& level, const float* const* point,
                                 const float (*dots)[kTile], float* sum) {
  const Dg d;
  const Vg zero = hn::Zero(d), one = hn::Set(d, 1.0f), scale = hn::Set(d, float(level.resolution));
  for (std::size_t s = 0; s < kTile; s += hn::Lanes(d)) {
    Vg weight[3][2], slope[3];
    for (int a = 0; a < kDims; ++a) {
      const Vg x = hn::LoadU(d, point[a] + s);
      Vcell cell;
      const Vg part = cell_part(x, level.resolution, cell);
      weight[a][0] = hn::Sub(one, part), weight[a][1] = part;
      slope[a] = hn::IfThenElseZero(hn::And(hn::Ge(x, zero), hn::Le(x, one)), scale);  // 0 where clamped
    }
#pragma GCC unroll 3
    for (int a = 0; a < kDims; ++a) {
      Vg total = zero;
#pragma GCC unroll 8
      for (int c = 0; c < (1 << kDims); ++c) {
        if ((c >> a) & 1) continue;
        Vg step = hn::Sub(hn::Load(d, &dots[c | (1 << a)][s]), hn::Load(d, &dots[c][s]));
#pragma GCC unroll 3
        for (int b = 0; b < kDims; ++b) {
          if (b != a) step = hn::Mul(step, weight[b][(c >> b) & 1]);
        }
        total = hn::Add(total, step);
      }
      hn::Store(hn::MulAdd(slope[a], total, hn::Load(d, sum + a * kTile + s)), d, sum + a * kTile + s);
    }
  }
}

template <int kDims>
HWY_INLINE void tile_slope(const GridLevel& level, int features, const float* table,
                           const float* const* point, CellTile& cells, const float* gradients, float* sum) {
  alignas(64) float dots[1 << kDims][kTile];
  cells_of<kDims>(level, features, point, cells);
  corner_dots<(1 << kDims)>(table, cells, features, gradients, dots);
  add_point_slopes<kDims>(level, point, dots, sum);
}

// sum (dimensions, kTile) += gradient of the point, from gradients (features, kTile) of this level's
// features. Every entry is read once.
HWY_NOINLINE inline void encode_tile_slope(const GridLevel& level, const GridConfig& grid,
                                           const float* parameters, const float* const* point,
                                           CellTile& cells, const float* gradients, float* sum) {
  const float* table = parameters + level.offset;
  const int n = grid.features;
  if (grid.dimensions == 3) {
    tile_slope<3>(level, n, table, point, cells, gradients, sum);
  } else if (grid.dimensions == 2) {
    tile_slope<2>(level, n, table, point, cells, gradients, sum);
  } else {
    tile_slope<1>(level, n, table, point, cells, gradients, sum);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#endif
