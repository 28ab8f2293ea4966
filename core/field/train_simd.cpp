// The field's backward kernels over ranges of samples, and Adam, compiled as those of field_simd.cpp: see
// field_kernels.h. Symbols as in field.h.
#include "core/field/field_kernels.h"

#include <algorithm>
#include <cstring>

#include "core/field/field_bf16.h"

// AVX2 and AVX-512 beside the baseline (SSSE3, NEON); the sets in between gain nothing here and cost build
// time. Vectors are kept in arrays, which those of Arm's SVE, of no known length, cannot be.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/field/train_simd.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.h, which includes this file again once per target:
#include "core/field/tile_simd-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {

// Gradients of the linear outputs: b.rgb in place, and row 0 of b.block_gradient for the density.
void output_gradients(const BackwardRange& r, const TileBuffers& b, std::size_t begin, std::size_t count) {
  const Df d;
  const float* from[4] = {r.gradients.sigma, r.gradients.red, r.gradients.green, r.gradients.blue};
  alignas(64) float given[4][kTile] = {};
  for (int k = 0; k < 4; ++k) std::memcpy(given[k], from[k] + begin, count * sizeof(float));
  for (std::size_t s = 0; s < kTile; s += kLanes) {
    hn::Store(hn::Mul(hn::Load(d, given[0] + s), density_slope(hn::Load(d, b.raw_density + s))), d,
              b.block_gradient + s);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vf value = sigmoid(hn::Load(d, b.rgb + k * kTile + s));
      const Vf slope = hn::Mul(value, hn::Sub(hn::Set(d, 1.0f), value));
      hn::Store(hn::Mul(hn::Load(d, given[k + 1] + s), slope), d, b.rgb + k * kTile + s);
    }
  }
}

// From the gradients of a (in `features`) through w to H; returns the gradient of H's first sums.
const float* slice_backward(const KernelContext& c, const BackwardRange& r, const TileBuffers& b,
                            const float* features, const float* slice) {
  const Df d;
  const std::size_t dimensions = std::size_t(c.layout.ambient_dimensions);
  const std::size_t e = std::size_t(c.layout.position_features);
  std::fill(b.w_gradient, b.w_gradient + 3 * kTile, 0.0f);
  const float* point[3] = {slice, slice + kTile, slice + 2 * kTile};
  const float* rows = features + e * kTile;
  for (const GridLevel& level : c.layout.ambient) {
    encode_tile_slope(level, c.config.ambient_grid, c.tables, point, *b.cells, rows, b.w_gradient);
    rows += std::size_t(c.config.ambient_grid.features) * kTile;
  }
  const Vf one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f), two = hn::Set(d, 2.0f);
  for (std::size_t s = 0; s < dimensions * kTile; s += kLanes) {
    const Vf w = hn::MulSub(two, hn::Load(d, slice + s), one);
    const Vf slope = hn::Mul(half, hn::NegMulAdd(w, w, one));
    hn::Store(hn::Mul(hn::Load(d, b.w_gradient + s), slope), d, b.w_gradient + s);
  }
  float* const below[2] = {nullptr, b.slice_below};  // of one hidden layer
  return network_backward(c.networks, c.layout.slice, slice_input(c, b, features), b.slice_hidden,
                          b.w_gradient, below, r.partial_layout->slice, r.partial, b.turned);
}

// Gradients of a network's first sums, in rows or, in bfloat16, as words of pairs.
struct FirstSlopes {
  const float* rows = nullptr;
  const std::uint32_t* words = nullptr;
};

// From b.rgb's gradients.
FirstSlopes colour_backward(const KernelContext& c, const BackwardRange& r, const TileBuffers& b) {
  if (c.bf16)
    return {nullptr, network_backward_bf16(c.bf16->slopes.colour, b.colour_words, b.rgb,
                                           r.partial_layout->colour, r.partial, b.slopes)};
  return {network_backward(c.networks, c.layout.colour, colour_input(c, b), b.colour_hidden, b.rgb, b.below,
                           r.partial_layout->colour, r.partial, b.turned)};
}

// From b.block_gradient.
FirstSlopes density_backward(const KernelContext& c, const BackwardRange& r, const TileBuffers& b,
                             const float* features) {
  if (c.bf16)
    return {nullptr, network_backward_bf16(c.bf16->slopes.density, b.density_words, b.block_gradient,
                                           r.partial_layout->density, r.partial, b.slopes)};
  return {network_backward(c.networks, c.layout.density, {features, c.density_inputs()}, b.density_hidden,
                           b.block_gradient, b.below, r.partial_layout->density, r.partial, b.turned)};
}

// rows = gradients of inputs [first, first + count); `transposed`: these inputs' part of c.bf16->slopes.
void input_rows(const KernelContext& c, const DenseLayer& layer, PackedLayer PackedSlopes::*transposed,
                const FirstSlopes& g, std::size_t first, std::size_t count, float* rows) {
  if (c.bf16)
    input_gradient_bf16(c.bf16->slopes.*transposed, g.words, rows);
  else
    input_gradient<Finish::kLinear>(c.networks, layer, g.rows, first, count, rows);
}

// Gradients of psi's entries that act only in a region. rows: (condition_count, kTile).
void weigh_condition_slopes(const KernelContext& c, std::size_t begin, std::size_t count, float* rows) {
  const std::size_t local = std::size_t(c.config.local_conditions),
                    first = std::size_t(c.config.condition_count) - local;
  for (std::size_t k = 0; k < local; ++k) {
    const float* weights = c.inputs.local + k * c.inputs.count + begin;
    for (std::size_t s = 0; s < kTile; ++s) rows[(first + k) * kTile + s] *= weights[std::min(s, count - 1)];
  }
}

void backward_tile(const KernelContext& c, const BackwardRange& r, const TileBuffers& b, std::size_t begin,
                   float* features, const float* slice, float* codes) {
  const std::size_t count = std::min(kTile, r.end - begin);
  const std::size_t geometry = std::size_t(c.config.geometry_features);
  const std::size_t latents = std::size_t(c.config.latent_count);
  const DenseLayer &colour = c.layout.colour[0], &density = c.layout.density[0];
  output_gradients(r, b, begin, count);
  FirstSlopes g = colour_backward(c, r, b);
  input_rows(c, colour, &PackedSlopes::colour_geometry, g, 0, geometry, b.block_gradient + kTile);
  input_rows(c, colour, &PackedSlopes::colour_latents, g, geometry + std::size_t(c.layout.direction_features),
             latents, codes);
  g = density_backward(c, r, b, features);
  // The slice depends on the gradients of the density's inputs: e is needed until both are computed.
  const std::size_t e = std::size_t(c.layout.position_features), rest = c.density_inputs() - e;
  input_rows(c, density, &PackedSlopes::density_rest, g, e, rest, features + e * kTile);
  float* condition_rows = r.want_conditions ? codes + latents * kTile : nullptr;
  if (!c.layout.has_ambient()) {
    input_rows(c, density, &PackedSlopes::density_position, g, 0, e, features);
    if (condition_rows) {
      std::memcpy(condition_rows, features + e * kTile, rest * kTile * sizeof(float));
      weigh_condition_slopes(c, begin, count, condition_rows);
    }
    return;
  }
  // H is always in single precision; its scratch must not overlap g.
  const float* h = slice_backward(c, r, b, features, slice);
  input_rows(c, density, &PackedSlopes::density_position, g, 0, e, features);
  const std::size_t seen = std::size_t(c.layout.slice_features);
  input_gradient<Finish::kAdd>(c.networks, c.layout.slice[0], h, 0, seen, features);
  if (!condition_rows) return;
  input_gradient<Finish::kLinear>(c.networks, c.layout.slice[0], h, seen,
                                  std::size_t(c.config.condition_count), condition_rows);
  weigh_condition_slopes(c, begin, count, condition_rows);
}

void BackwardTiles(const KernelContext& c, const BackwardRange& r) {
  TileBuffers b = carve(c.config, c.layout, r.scratch);
  float* features = r.features;
  const float* slice = r.slice;
  float* kept = r.kept;
  float* codes = r.codes;
  for (std::size_t begin = r.begin; begin < r.end; begin += kTile) {
    use_kept(c, kept, b);
    kept += c.kept_rows() * kTile;
    backward_tile(c, r, b, begin, features, slice, codes);
    features += c.density_inputs() * kTile;
    slice += std::size_t(c.layout.ambient_dimensions) * kTile;
    codes += c.code_rows(r.want_conditions) * kTile;
  }
}

void ScatterLevel(const KernelContext& c, std::span<const SampleRun> runs, bool ambient, int index,
                  const float* features, const float* slice, float* gradients, std::uint8_t* touched) {
  const GridConfig& grid = ambient ? c.config.ambient_grid : c.config.position;
  const GridLevel& level = (ambient ? c.layout.ambient : c.layout.position)[std::size_t(index)];
  const std::size_t first = (ambient ? std::size_t(c.layout.position_features) : 0) +
                            std::size_t(index) * std::size_t(grid.features);
  const std::size_t dimensions = std::size_t(c.layout.ambient_dimensions);
  const std::size_t width = std::size_t(grid.features);
  alignas(64) CellTile cells;
  alignas(64) float copy[3 * kTile];
  warm(gradients + level.offset, level.entries * width, c.inputs.count);
  for (const SampleRun& run : runs) {
    std::size_t tile = run.tile;
    for (std::size_t begin = run.begin; begin < run.end; begin += kTile, ++tile) {
      const std::size_t count = std::min(kTile, run.end - begin);
      const float* w = slice + tile * dimensions * kTile;
      const float* point[3] = {w, w + kTile, w + 2 * kTile};
      if (!ambient) point_rows(c.inputs, begin, count, copy, point);
      const float* rows = features + (tile * c.density_inputs() + first) * kTile;
      ask_for<0>(rows + kTilesAhead * c.density_inputs() * kTile, width);
      encode_tile_backward(level, grid, point, cells, rows, count, gradients);
    }
  }
  mark_lines(gradients + level.offset, level.entries * width, touched + level.offset / kTableLine);
}

void PositionGradients(const KernelContext& c, const SampleRun& run, const float* features, float* x,
                       float* y, float* z) {
  alignas(64) CellTile cells;
  alignas(64) float copy[3 * kTile], sum[3 * kTile];
  const std::size_t width = std::size_t(c.config.position.features);
  std::size_t tile = run.tile;
  for (std::size_t begin = run.begin; begin < run.end; begin += kTile, ++tile) {
    const std::size_t count = std::min(kTile, run.end - begin);
    const float* point[3];
    point_rows(c.inputs, begin, count, copy, point);
    std::fill(sum, sum + 3 * kTile, 0.0f);
    const float* rows = features + tile * c.density_inputs() * kTile;
    for (std::size_t l = 0; l < c.layout.position.size(); ++l, rows += width * kTile) {
      encode_tile_slope(c.layout.position[l], c.config.position, c.tables, point, cells, rows, sum);
    }
    store_outputs(sum, count, x + begin);
    store_outputs(sum + kTile, count, y + begin);
    store_outputs(sum + 2 * kTile, count, z + begin);
  }
}

void AdamUpdate(float* values, float* gradients, float* first, float* second, std::size_t count,
                const AdamStep& step) {
  const Df d;
  const Vf beta1 = hn::Set(d, step.beta1), beta2 = hn::Set(d, step.beta2), rate = hn::Set(d, step.rate);
  const Vf rest1 = hn::Set(d, 1 - step.beta1), rest2 = hn::Set(d, 1 - step.beta2);
  const Vf epsilon = hn::Set(d, step.epsilon), l2 = hn::Set(d, step.l2), keep = hn::Set(d, step.keep);
  const auto update = [&](float* value, float* gradient, float* m, float* v) HWY_ATTR {
    const Vf old = hn::LoadU(d, value);
    const Vf g = hn::MulAdd(l2, old, hn::LoadU(d, gradient));
    const Vf m1 = hn::MulAdd(beta1, hn::LoadU(d, m), hn::Mul(rest1, g));
    const Vf v1 = hn::MulAdd(beta2, hn::LoadU(d, v), hn::Mul(hn::Mul(rest2, g), g));
    hn::StoreU(m1, d, m);
    hn::StoreU(v1, d, v);
    hn::StoreU(hn::Sub(hn::Mul(keep, old), hn::Div(hn::Mul(rate, m1), hn::Add(hn::Sqrt(v1), epsilon))), d,
               value);
    hn::StoreU(hn::Zero(d), d, gradient);
  };
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) update(values + i, gradients + i, first + i, second + i);
  if (i == count) return;
  // The rest through copies padded to a vector.
  const std::size_t rest = count - i;
  float* arrays[4] = {values + i, gradients + i, first + i, second + i};
  alignas(64) float padded[4][kLanes] = {};
  for (int k = 0; k < 4; ++k) std::memcpy(padded[k], arrays[k], rest * sizeof(float));
  update(padded[0], padded[1], padded[2], padded[3]);
  for (int k = 0; k < 4; ++k) std::memcpy(arrays[k], padded[k], rest * sizeof(float));
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace likeness {

HWY_EXPORT(BackwardTiles);
HWY_EXPORT(ScatterLevel);
HWY_EXPORT(PositionGradients);
HWY_EXPORT(AdamUpdate);

void backward_tiles(const KernelContext& context, const BackwardRange& range) {
  HWY_DYNAMIC_DISPATCH(BackwardTiles)(context, range);
}
void scatter_level(const KernelContext& context, std::span<const SampleRun> runs, bool ambient, int level,
                   const float* features, const float* slice, float* gradients, std::uint8_t* touched) {
  HWY_DYNAMIC_DISPATCH(ScatterLevel)
  (context, runs, ambient, level, features, slice, gradients, touched);
}
void position_gradients(const KernelContext& context, const SampleRun& run, const float* features, float* x,
                        float* y, float* z) {
  HWY_DYNAMIC_DISPATCH(PositionGradients)(context, run, features, x, y, z);
}
void adam_update(float* values, float* gradients, float* first, float* second, std::size_t count,
                 const AdamStep& step) {
  HWY_DYNAMIC_DISPATCH(AdamUpdate)(values, gradients, first, second, count, step);
}

PartialLayout make_partial_layout(const FieldLayout& layout) {
  PartialLayout partial;
  const auto add = [&](const std::vector<DenseLayer>& layers, std::vector<PartialLayer>& to) {
    for (const DenseLayer& layer : layers) {
      PartialLayer p;
      p.stride = (std::size_t(layer.inputs) + kPartialLanes - 1) / kPartialLanes * kPartialLanes;
      p.weights = partial.count;
      p.biases = p.weights + p.stride * std::size_t(layer.outputs);
      partial.count = p.biases + kPartialLanes * std::size_t(layer.outputs);
      to.push_back(p);
    }
  };
  add(layout.slice, partial.slice);
  add(layout.density, partial.density);
  add(layout.colour, partial.colour);
  return partial;
}

}  // namespace likeness
#endif  // HWY_ONCE
