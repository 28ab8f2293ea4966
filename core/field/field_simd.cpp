// The field's kernels over ranges of samples, compiled for several instruction sets and chosen at run time:
// see field_kernels.h. Symbols as in field.h.
#include "core/field/field_kernels.h"

#include <algorithm>
#include <cstring>

#include "core/field/field_bf16.h"

// AVX2 and AVX-512 beside the baseline (SSSE3, NEON); the sets in between gain nothing here and cost build
// time.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/field/field_simd.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.h, which includes this file again once per target:
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
  float* block;  // (1 + G + directions + L): density's output, whose tail is the colour network's input
  float* colour_hidden[2];
  float* rgb;             // (3)
  float* block_gradient;  // as block
  float* below[2];        // (widest hidden layer)
  float* slice_below;     // (slice width)
  float* w_gradient;      // (3)
  float* turned;          // (kTile, widest stride)
  std::size_t size;       // of all, floats
};

std::size_t block_rows(const FieldConfig& config, const FieldLayout& layout) {
  return std::size_t(1 + config.geometry_features + layout.direction_features + config.latent_count);
}

// Without scratch, only `size` is of use.
TileBuffers carve(const FieldConfig& config, const FieldLayout& layout, float* scratch) {
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
  const std::size_t block = block_rows(config, layout);
  b.cells = reinterpret_cast<CellTile*>(rows(sizeof(CellTile) / sizeof(float) / kTile));
  b.point = rows(3);
  b.psi = rows(std::size_t(config.condition_count));
  b.slice_hidden[0] = rows(std::size_t(config.slice_width));
  b.slice_out = rows(3);
  for (float*& hidden : b.density_hidden) hidden = rows(std::size_t(config.density_width));
  b.block = rows(block);
  for (float*& hidden : b.colour_hidden) hidden = rows(std::size_t(config.colour_width));
  b.rgb = rows(3);
  b.block_gradient = rows(block);
  for (float*& below : b.below) below = rows(widest);
  b.slice_below = rows(std::size_t(config.slice_width));
  b.w_gradient = rows(3);
  b.turned = rows(std::max({widest, inputs, block}) + kPartialLanes);
  return b;
}

// What backward needs of the forward pass lies in `kept` (kept rows, kTile) instead of the scratch.
void use_kept(const KernelContext& c, float* kept, TileBuffers& b) {
  const auto rows = [&](std::size_t count) {
    float* start = kept;
    kept += count * kTile;
    return start;
  };
  if (c.layout.has_ambient()) {
    b.psi = rows(std::size_t(c.config.condition_count));
    b.slice_hidden[0] = rows(std::size_t(c.config.slice_width));
  }
  for (int l = 0; l < c.config.density_layers; ++l)
    b.density_hidden[l] = rows(std::size_t(c.config.density_width));
  b.block = rows(block_rows(c.config, c.layout));
  for (int l = 0; l < c.config.colour_layers; ++l)
    b.colour_hidden[l] = rows(std::size_t(c.config.colour_width));
  b.rgb = rows(3);
}

// A row of a tile: `count` values from `from`, the last repeated as padding.
void copy_padded(const float* from, std::size_t count, float* row) {
  std::memcpy(row, from, count * sizeof(float));
  std::fill(row + count, row + kTile, from[count - 1]);
}

// Rows of the batch's points for a tile; of a whole tile in place, of a padded one in `copy`.
void point_rows(const FieldInputs& inputs, std::size_t begin, std::size_t count, float* copy,
                const float* (&point)[3]) {
  const float* axes[3] = {inputs.x, inputs.y, inputs.z};
  for (int a = 0; a < 3; ++a) {
    point[a] = axes[a] + begin;
    if (count == kTile) continue;
    copy_padded(point[a], count, copy + a * kTile);
    point[a] = copy + a * kTile;
  }
}

// rows (width, kTile) = table[view(s)][k]; zeros without a table. Samples of a ray share a view, so whole
// runs are filled.
template <class View>
void fill_code_rows(const View& view, const float* table, std::size_t width, float* rows) {
  for (std::size_t first = 0, last = 0; first < kTile; first = last) {
    const std::size_t row = view(first);
    for (last = first + 1; last < kTile && view(last) == row;) ++last;
    for (std::size_t k = 0; k < width; ++k) {
      std::fill(rows + k * kTile + first, rows + k * kTile + last, table ? table[row * width + k] : 0.0f);
    }
  }
}

void code_rows(const FieldInputs& inputs, const float* table, std::size_t width, std::size_t begin,
               std::size_t count, float* rows) {
  const auto view = [&](std::size_t s) {
    return inputs.view ? std::size_t(inputs.view[begin + std::min(s, count - 1)]) : 0;
  };
  fill_code_rows(view, table, width, rows);
}

// point (3, kTile) = (0, 0, 1), which is what missing directions mean.
void forward_directions(float* point) {
  std::fill(point, point + 2 * kTile, 0.0f);
  std::fill(point + 2 * kTile, point + 3 * kTile, 1.0f);
}

// rows (kDirectionFeatures, kTile): real spherical harmonics of the directions `point` (3, kTile).
void harmonic_rows(const float* point, float* rows) {
  const Df d;
  const auto k = [&](double value) HWY_ATTR { return hn::Set(d, float(value)); };
  for (std::size_t s = 0; s < kTile; s += kLanes) {
    const Vf x = hn::Load(d, point + s), y = hn::Load(d, point + kTile + s),
             z = hn::Load(d, point + 2 * kTile + s);
    const Vf values[kDirectionFeatures] = {
        k(kHarmonic0),
        hn::Mul(k(kHarmonic1), y),
        hn::Mul(k(kHarmonic1), z),
        hn::Mul(k(kHarmonic1), x),
        hn::Mul(hn::Mul(k(kHarmonic2), x), y),
        hn::Mul(hn::Mul(k(kHarmonic2), y), z),
        hn::Mul(k(kHarmonic2z), hn::Sub(hn::Mul(k(3), hn::Mul(z, z)), k(1))),
        hn::Mul(hn::Mul(k(kHarmonic2), x), z),
        hn::Mul(k(kHarmonic2xy), hn::Sub(hn::Mul(x, x), hn::Mul(y, y)))};
    for (int f = 0; f < kDirectionFeatures; ++f) hn::Store(values[f], d, rows + f * kTile + s);
  }
}

void direction_rows(const FieldInputs& inputs, std::size_t begin, std::size_t count, float* copy,
                    float* rows) {
  if (inputs.dx) {
    copy_padded(inputs.dx + begin, count, copy);
    copy_padded(inputs.dy + begin, count, copy + kTile);
    copy_padded(inputs.dz + begin, count, copy + 2 * kTile);
  } else {
    forward_directions(copy);
  }
  harmonic_rows(copy, rows);
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

void store_outputs(const float* row, std::size_t count, float* out) {
  std::memcpy(out, row, count * sizeof(float));
}

// What the slice network sees: the first rows of e, psi.
InputRows slice_input(const KernelContext& c, const TileBuffers& b, const float* features) {
  return {features, std::size_t(c.layout.slice_features), b.psi, std::size_t(c.config.condition_count)};
}

// rows (features, kTile): what a level holds at the points.
void encode(const KernelContext& c, const GridLevel& level, const GridConfig& grid, const float* const* point,
            const TileBuffers& b, float* rows) {
  if (c.bf16)
    encode_tile_bf16(level, grid, c.bf16->tables, point, rows);
  else
    encode_tile(level, grid, c.tables, point, *b.cells, rows);
}

// Words for network_bf16 in rows that only backward uses.
PairScratch pair_scratch(const TileBuffers& b) {
  const auto words = [](float* rows) { return reinterpret_cast<std::uint32_t*>(rows); };
  return {words(b.turned), {words(b.below[0]), words(b.below[1])}};
}

// w and the ambient features, or psi, behind e in `features`; (w + 1) / 2 into `slice`.
void complete_features(const KernelContext& c, const TileBuffers& b, std::size_t begin, std::size_t count,
                       float* features, float* slice) {
  const Df d;
  const std::size_t e = std::size_t(c.layout.position_features);
  if (!c.layout.has_ambient()) {
    code_rows(c.inputs, c.inputs.conditions, std::size_t(c.layout.concat_count), begin, count,
              features + e * kTile);
    return;
  }
  code_rows(c.inputs, c.inputs.conditions, std::size_t(c.config.condition_count), begin, count, b.psi);
  network_forward(c.networks, c.layout.slice, slice_input(c, b, features), b.slice_hidden,
                  std::size_t(c.layout.ambient_dimensions), b.slice_out);
  const Vf half = hn::Set(d, 0.5f);
  const std::size_t dimensions = std::size_t(c.layout.ambient_dimensions);
  for (std::size_t s = 0; s < dimensions * kTile; s += kLanes) {
    hn::Store(hn::MulAdd(half, hn::Tanh(d, hn::Load(d, b.slice_out + s)), half), d, slice + s);
  }
  const float* point[3] = {slice, slice + kTile, slice + 2 * kTile};
  float* rows = features + e * kTile;
  for (const GridLevel& level : c.layout.ambient) {
    encode(c, level, c.config.ambient_grid, point, b, rows);
    rows += std::size_t(c.config.ambient_grid.features) * kTile;
  }
}

// Density network: b.block, of which the density alone unless the rest is wanted, and the hidden rows.
void density_network(const KernelContext& c, const TileBuffers& b, const float* features, bool geometry) {
  const std::size_t outputs = geometry ? 1 + std::size_t(c.config.geometry_features) : 1;
  if (c.bf16)
    network_bf16(c.bf16->density, features, pair_scratch(b), outputs, b.block);
  else
    network_forward(c.networks, c.layout.density, {features, c.density_inputs()}, b.density_hidden, outputs,
                    b.block);
}

// Rows of b.block behind the geometry features.
float* direction_place(const KernelContext& c, const TileBuffers& b) {
  return b.block + (1 + std::size_t(c.config.geometry_features)) * kTile;
}

// What the colour network sees: the rows of b.block behind the density.
InputRows colour_input(const KernelContext& c, const TileBuffers& b) {
  return {b.block + kTile, block_rows(c.config, c.layout) - 1};
}

// b.rgb (before the sigmoid) and the hidden rows, from the rows of b.block behind the density.
void colour_network(const KernelContext& c, const TileBuffers& b) {
  if (c.bf16)
    network_bf16(c.bf16->colour, b.block + kTile, pair_scratch(b), 3, b.rgb);
  else
    network_forward(c.networks, c.layout.colour, colour_input(c, b), b.colour_hidden, 3, b.rgb);
}

// A level's rows of a tile lie far from the next tile's, which no processor foresees: they are asked for this
// many tiles before.
constexpr std::size_t kTilesAhead = 4;

// Asks for the lines of `count` rows, to be written or only read.
template <int kWrite>
HWY_INLINE void ask_for(const float* rows, std::size_t count) {
  for (std::size_t i = 0; i < count * kTile; i += kTableLine) __builtin_prefetch(rows + i, kWrite);
}

// Reads a table in order, which is faster than letting its lines come as they are hit, if most are.
void warm(const float* table, std::size_t count, std::size_t samples) {
  constexpr std::size_t kHits = 1;  // samples a line at least
  if (samples < kHits * count / kTableLine) return;
  for (std::size_t i = 0; i < count; i += kTableLine) __builtin_prefetch(table + i);
}

std::size_t samples_of(std::span<const SampleRun> runs) {
  std::size_t count = 0;
  for (const SampleRun& run : runs) count += run.end - run.begin;
  return count;
}

void EncodePositions(const KernelContext& c, std::span<const SampleRun> runs, float* scratch,
                     float* features) {
  const TileBuffers b = carve(c.config, c.layout, scratch);
  const std::size_t rows = c.density_inputs(), width = std::size_t(c.config.position.features);
  const std::size_t samples = samples_of(runs);
  for (std::size_t l = 0; l < c.layout.position.size(); ++l) {  // outermost: one table at a time stays in L2
    const GridLevel& level = c.layout.position[l];
    if (!c.bf16) warm(c.tables + level.offset, level.entries * width, samples);
    for (const SampleRun& run : runs) {
      float* to = features + (run.tile * rows + l * width) * kTile;
      for (std::size_t begin = run.begin; begin < run.end; begin += kTile, to += rows * kTile) {
        const float* point[3];
        point_rows(c.inputs, begin, std::min(kTile, run.end - begin), b.point, point);
        ask_for<1>(to + kTilesAhead * rows * kTile, width);
        encode(c, level, c.config.position, point, b, to);
      }
    }
  }
}

void store_colours(const TileBuffers& b, std::size_t count, float* red, float* green, float* blue) {
  const Df d;
  for (std::size_t s = 0; s < 3 * kTile; s += kLanes)
    hn::Store(sigmoid(hn::Load(d, b.rgb + s)), d, b.point + s);
  store_outputs(b.point, count, red);
  store_outputs(b.point + kTile, count, green);
  store_outputs(b.point + 2 * kTile, count, blue);
}

void ForwardTiles(const KernelContext& c, const ForwardRange& r) {
  const Df d;
  TileBuffers b = carve(c.config, c.layout, r.scratch);
  const std::size_t geometry = std::size_t(c.config.geometry_features), stride = geometry_stride(c.config);
  float* features = r.features;
  float* slice = r.slice;
  float* kept = r.kept;
  for (std::size_t begin = r.begin; begin < r.end; begin += kTile) {
    const std::size_t count = std::min(kTile, r.end - begin);
    if (kept) {
      use_kept(c, kept, b);
      kept += c.kept_rows() * kTile;
    }
    complete_features(c, b, begin, count, features, slice);
    density_network(c, b, features, r.red || r.geometry);
    for (std::size_t s = 0; s < kTile; s += kLanes) {
      hn::Store(density_of(hn::Load(d, b.block + s)), d, b.block_gradient + s);
    }
    store_outputs(b.block_gradient, count, r.sigma + begin);
    if (r.geometry) {
      transpose_tile({b.block + kTile, geometry}, stride, b.turned);
      store_outputs(b.turned, count * stride, r.geometry + begin * stride);
    }
    if (r.red) {
      float* rows = direction_place(c, b);
      if (c.layout.direction_features > 0) direction_rows(c.inputs, begin, count, b.point, rows);
      rows += std::size_t(c.layout.direction_features) * kTile;
      code_rows(c.inputs, c.inputs.latents, std::size_t(c.config.latent_count), begin, count, rows);
      colour_network(c, b);
      store_colours(b, count, r.red + begin, r.green + begin, r.blue + begin);
    }
    features += c.density_inputs() * kTile;
    slice += std::size_t(c.layout.ambient_dimensions) * kTile;
  }
}

// b.block's geometry rows from the chosen samples' features; `index(s)` is the sample of lane s.
template <class Index>
void geometry_rows(const KernelContext& c, const TileBuffers& b, const Index& index, const float* geometry) {
  const hn::FixedTag<float, 4> d;
  const std::size_t width = std::size_t(c.config.geometry_features), stride = geometry_stride(c.config);
  for (std::size_t s = 0; s < kTile; s += 4) {
    const float* from[4];
    for (std::size_t k = 0; k < 4; ++k) from[k] = geometry + index(s + k) * stride;
    for (std::size_t f = 0; f < width; f += 4) {
      hn::Vec<decltype(d)> v[4];
      for (int k = 0; k < 4; ++k) v[k] = hn::LoadU(d, from[k] + f);
      transpose_quad(v);
      for (std::size_t k = 0; k < std::min<std::size_t>(4, width - f); ++k)
        hn::Store(v[k], d, b.block + (1 + f + k) * kTile + s);
    }
  }
}

void ColourTiles(const KernelContext& c, const ColourRange& r) {
  const TileBuffers b = carve(c.config, c.layout, r.scratch);
  const FieldInputs& in = c.inputs;
  for (std::size_t begin = r.begin; begin < r.end; begin += kTile) {
    const std::size_t count = std::min(kTile, r.end - begin);
    const auto index = [&](std::size_t s) { return std::size_t(r.chosen[begin + std::min(s, count - 1)]); };
    geometry_rows(c, b, index, r.geometry);
    float* rows = direction_place(c, b);
    if (c.layout.direction_features > 0) {
      forward_directions(b.point);
      for (std::size_t s = 0; in.dx && s < kTile; ++s) {
        const std::size_t i = index(s);
        b.point[s] = in.dx[i], b.point[kTile + s] = in.dy[i], b.point[2 * kTile + s] = in.dz[i];
      }
      harmonic_rows(b.point, rows);
      rows += std::size_t(c.layout.direction_features) * kTile;
    }
    fill_code_rows([&](std::size_t s) { return in.view ? std::size_t(in.view[index(s)]) : 0; }, in.latents,
                   std::size_t(c.config.latent_count), rows);
    colour_network(c, b);
    store_colours(b, count, r.red + begin, r.green + begin, r.blue + begin);
  }
}

// Gradients of the linear outputs: b.rgb in place, and row 0 of b.block_gradient for the density.
void output_gradients(const BackwardRange& r, const TileBuffers& b, std::size_t begin, std::size_t count) {
  const Df d;
  const float* from[4] = {r.gradients.sigma, r.gradients.red, r.gradients.green, r.gradients.blue};
  alignas(64) float given[4][kTile] = {};
  for (int k = 0; k < 4; ++k) std::memcpy(given[k], from[k] + begin, count * sizeof(float));
  for (std::size_t s = 0; s < kTile; s += kLanes) {
    hn::Store(hn::Mul(hn::Load(d, given[0] + s), density_slope(hn::Load(d, b.block + s))), d,
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

void backward_tile(const KernelContext& c, const BackwardRange& r, const TileBuffers& b, std::size_t begin,
                   float* features, const float* slice, float* codes) {
  const std::size_t count = std::min(kTile, r.end - begin);
  const std::size_t geometry = std::size_t(c.config.geometry_features);
  const std::size_t latents = std::size_t(c.config.latent_count);
  output_gradients(r, b, begin, count);
  // -- Colour
  const float* g = network_backward(c.networks, c.layout.colour, colour_input(c, b), b.colour_hidden, b.rgb,
                                    b.below, r.partial_layout->colour, r.partial, b.turned);
  input_gradient<Finish::kLinear>(c.networks, c.layout.colour[0], g, 0, geometry, b.block_gradient + kTile);
  input_gradient<Finish::kLinear>(c.networks, c.layout.colour[0], g,
                                  geometry + std::size_t(c.layout.direction_features), latents, codes);
  // -- Density, and the slice between the gradients of its inputs: e is needed until both are there.
  const std::size_t e = std::size_t(c.layout.position_features), rest = c.density_inputs() - e;
  g = network_backward(c.networks, c.layout.density, {features, e + rest}, b.density_hidden, b.block_gradient,
                       b.below, r.partial_layout->density, r.partial, b.turned);
  const DenseLayer& density = c.layout.density[0];
  input_gradient<Finish::kLinear>(c.networks, density, g, e, rest, features + e * kTile);
  float* condition_rows = r.want_conditions ? codes + latents * kTile : nullptr;
  if (c.layout.has_ambient()) {
    const float* h = slice_backward(c, r, b, features, slice);
    input_gradient<Finish::kLinear>(c.networks, density, g, 0, e, features);
    const std::size_t seen = std::size_t(c.layout.slice_features);
    input_gradient<Finish::kAdd>(c.networks, c.layout.slice[0], h, 0, seen, features);
    if (condition_rows)
      input_gradient<Finish::kLinear>(c.networks, c.layout.slice[0], h, seen,
                                      std::size_t(c.config.condition_count), condition_rows);
    return;
  }
  input_gradient<Finish::kLinear>(c.networks, density, g, 0, e, features);
  if (condition_rows) std::memcpy(condition_rows, features + e * kTile, rest * kTile * sizeof(float));
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

std::size_t ScratchFloats(const FieldConfig& config, const FieldLayout& layout) {
  return carve(config, layout, nullptr).size;
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace likeness {

HWY_EXPORT(EncodePositions);
HWY_EXPORT(ForwardTiles);
HWY_EXPORT(ColourTiles);
HWY_EXPORT(BackwardTiles);
HWY_EXPORT(ScatterLevel);
HWY_EXPORT(PositionGradients);
HWY_EXPORT(AdamUpdate);
HWY_EXPORT(ScratchFloats);

void encode_positions(const KernelContext& context, std::span<const SampleRun> runs, float* scratch,
                      float* features) {
  HWY_DYNAMIC_DISPATCH(EncodePositions)(context, runs, scratch, features);
}
void forward_tiles(const KernelContext& context, const ForwardRange& range) {
  HWY_DYNAMIC_DISPATCH(ForwardTiles)(context, range);
}
void colour_tiles(const KernelContext& context, const ColourRange& range) {
  HWY_DYNAMIC_DISPATCH(ColourTiles)(context, range);
}
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
std::size_t scratch_floats(const FieldConfig& config, const FieldLayout& layout) {
  return HWY_DYNAMIC_DISPATCH(ScratchFloats)(config, layout);
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
