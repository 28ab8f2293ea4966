// Shared by the field's kernels over one tile of samples, for every SIMD target: scratch, rows of points, the
// outputs' functions. Included by field_simd.cpp and train_simd.cpp once per target.
#if defined(LIKENESS_TILE_SIMD_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef LIKENESS_TILE_SIMD_INL
#undef LIKENESS_TILE_SIMD_INL
#else
#define LIKENESS_TILE_SIMD_INL
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/field/field_bf16.h"
#include "core/field/field_kernels.h"
#include "core/field/grid_simd-inl.h"
#include "core/field/network_simd-inl.h"
#include "hwy/contrib/math/math-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {

// Tile buffers carved from a thread's scratch. Rows of kTile samples.
struct TileBuffers {
  CellTile* cells;
  float* point;            // (3): copies of a padded tile's points or directions; colours
  float* psi;              // (K)
  float* slice_hidden[1];  // (slice width)
  float* slice_out;        // (3)
  float* density_hidden[2];
  float* block;        // (1 + G + directions + L): density's output, whose tail is the colour network's input
  float* raw_density;  // (1): what backward needs of the block besides the colour network's input
  float* colour_hidden[2];
  float* rgb;                            // (3)
  float* block_gradient;                 // as block
  float* below[2];                       // (widest hidden layer), or pairs of the widest
  float* slice_below;                    // (slice width)
  float* w_gradient;                     // (3)
  float* turned;                         // (kTile, widest stride)
  float* samples;                        // (half of the widest layer)
  PairRows density_words, colour_words;  // of the networks in bfloat16, instead of hidden rows
  SlopeScratch slopes;                   // for their backward pass, in rows that single precision uses
  std::size_t size;                      // of all, floats
};

inline std::uint32_t* words_in(float* rows) { return reinterpret_cast<std::uint32_t*>(rows); }

inline std::size_t block_rows(const FieldConfig& config, const FieldLayout& layout) {
  return std::size_t(1 + config.geometry_features + layout.direction_features + config.latent_count);
}

// Without scratch, only `size` is valid.
inline TileBuffers carve(const FieldConfig& config, const FieldLayout& layout, float* scratch) {
  TileBuffers b;
  b.size = 0;
  const auto rows = [&](std::size_t count) {
    float* start = scratch ? scratch + b.size : nullptr;
    b.size += count * kTile;
    return start;
  };
  const std::size_t widest =
      std::size_t(std::max({config.slice_width, config.density_width, config.colour_width}));
  const std::size_t inputs = std::size_t(std::max(layout.position_features + config.condition_count,
                                                  layout.position_features + layout.ambient_features));
  const std::size_t block = block_rows(config, layout), outputs = std::max<std::size_t>(block, 3);
  b.cells = reinterpret_cast<CellTile*>(rows(sizeof(CellTile) / sizeof(float) / kTile));
  b.point = rows(3);
  b.psi = rows(std::size_t(config.condition_count));
  b.slice_hidden[0] = rows(std::size_t(config.slice_width));
  b.slice_out = rows(3);
  for (float*& hidden : b.density_hidden) hidden = rows(std::size_t(config.density_width));
  b.block = b.raw_density = rows(block);
  for (float*& hidden : b.colour_hidden) hidden = rows(std::size_t(config.colour_width));
  b.rgb = rows(3);
  b.block_gradient = rows(block);
  for (float*& below : b.below) below = rows(std::max(widest, pair_count(outputs)));
  b.slice_below = rows(std::size_t(config.slice_width));
  b.w_gradient = rows(3);
  b.samples = rows(pair_count(std::max(widest, outputs)));
  b.turned = rows(std::max({widest, inputs, block}) + kPartialLanes);
  b.density_words = b.colour_words = {words_in(b.turned), {words_in(b.below[0]), words_in(b.below[1])}};
  b.slopes = {words_in(b.turned), {words_in(b.below[0]), words_in(b.below[1])}, words_in(b.samples)};
  return b;
}

// What backward needs of the forward pass is in `kept` (kept rows, kTile) instead of the scratch.
inline void use_kept(const KernelContext& c, float* kept, TileBuffers& b) {
  const auto rows = [&](std::size_t count) {
    float* start = kept;
    kept += count * kTile;
    return start;
  };
  if (c.layout.has_ambient()) {
    b.psi = rows(std::size_t(c.config.condition_count));
    b.slice_hidden[0] = rows(std::size_t(c.config.slice_width));
  }
  if (c.bf16) {
    const auto words = [&](std::size_t inputs, int layers, int width, PairRows& to) {
      to.in = words_in(rows(pair_count(inputs)));
      for (int l = 0; l < layers; ++l) to.hidden[l] = words_in(rows(pair_count(std::size_t(width))));
    };
    words(c.density_inputs(), c.config.density_layers, c.config.density_width, b.density_words);
    words(c.colour_inputs(), c.config.colour_layers, c.config.colour_width, b.colour_words);
    b.raw_density = rows(1);
  } else {
    for (int l = 0; l < c.config.density_layers; ++l)
      b.density_hidden[l] = rows(std::size_t(c.config.density_width));
    b.block = b.raw_density = rows(block_rows(c.config, c.layout));
    for (int l = 0; l < c.config.colour_layers; ++l)
      b.colour_hidden[l] = rows(std::size_t(c.config.colour_width));
  }
  b.rgb = rows(3);
}

// A row of a tile: `count` values from `from`, the last repeated as padding.
inline void copy_padded(const float* from, std::size_t count, float* row) {
  std::memcpy(row, from, count * sizeof(float));
  std::fill(row + count, row + kTile, from[count - 1]);
}

// Rows of the batch's points for a tile: in place for a whole tile, in `copy` for a padded one.
inline void point_rows(const FieldInputs& inputs, std::size_t begin, std::size_t count, float* copy,
                       const float* (&point)[3]) {
  const float* axes[3] = {inputs.x, inputs.y, inputs.z};
  for (int a = 0; a < 3; ++a) {
    point[a] = axes[a] + begin;
    if (count == kTile) continue;
    copy_padded(point[a], count, copy + a * kTile);
    point[a] = copy + a * kTile;
  }
}

// Slope and value of the density; see field_layout.h.
HWY_INLINE Vf density_slope(Vf raw) {
  const Df d;
  return hn::Exp(d, hn::Min(raw, hn::Set(d, kDensityKnee)));
}
HWY_INLINE Vf density_of(Vf raw) {
  const Df d;
  const Vf beyond = hn::Max(hn::Sub(raw, hn::Set(d, kDensityKnee)), hn::Zero(d));
  const Vf slope = density_slope(raw);
  return hn::MulAdd(slope, beyond, slope);
}
HWY_INLINE Vf sigmoid(Vf raw) {
  const Df d;
  const Vf one = hn::Set(d, 1.0f);
  return hn::Div(one, hn::Add(one, hn::Exp(d, hn::Min(hn::Neg(raw), hn::Set(d, 80.0f)))));
}

inline void store_outputs(const float* row, std::size_t count, float* out) {
  std::memcpy(out, row, count * sizeof(float));
}

// Inputs of the slice network: the first rows of e, psi.
inline InputRows slice_input(const KernelContext& c, const TileBuffers& b, const float* features) {
  return {features, std::size_t(c.layout.slice_features), b.psi, std::size_t(c.config.condition_count)};
}

// Inputs of the colour network: the rows of b.block after the density.
inline InputRows colour_input(const KernelContext& c, const TileBuffers& b) {
  return {b.block + kTile, c.colour_inputs()};
}

// A level's rows of a tile are far from the next tile's, which hardware prefetchers do not predict: they are
// prefetched this many tiles ahead.
constexpr std::size_t kTilesAhead = 4;

// Prefetches the lines of `count` rows, for writing or only reading.
template <int kWrite>
HWY_INLINE void ask_for(const float* rows, std::size_t count) {
  for (std::size_t i = 0; i < count * kTile; i += kTableLine) __builtin_prefetch(rows + i, kWrite);
}

// Reads a table in order, which is faster than loading its lines as they are hit, if most are.
inline void warm(const float* table, std::size_t count, std::size_t samples) {
  constexpr std::size_t kHits = 1;  // samples per line, at least
  if (samples < kHits * count / kTableLine) return;
  for (std::size_t i = 0; i < count; i += kTableLine) __builtin_prefetch(table + i);
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#endif
