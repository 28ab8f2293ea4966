// The field's forward kernels over ranges of samples, compiled for several instruction sets and chosen at run
// time: see field_kernels.h. Symbols as in field.h.
#include "core/field/field_kernels.h"

#include <algorithm>
#include <cstring>

#include "core/field/field_bf16.h"

// AVX2 and AVX-512 beside the baseline (SSSE3, NEON); the sets in between gain nothing here and cost build
// time. Vectors are kept in arrays, which those of Arm's SVE, of no known length, cannot be.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/field/field_simd.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.h, which includes this file again once per target:
#include "core/field/tile_simd-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {

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

// Entries of psi that act only in a region, times the samples' weights. psi: (condition_count, kTile).
void weigh_local_rows(const KernelContext& c, std::size_t begin, std::size_t count, float* psi) {
  const std::size_t local = std::size_t(c.config.local_conditions),
                    first = std::size_t(c.config.condition_count) - local;
  for (std::size_t k = 0; k < local; ++k) {
    const float* weights = c.inputs.local + k * c.inputs.count + begin;
    float* row = psi + (first + k) * kTile;
    for (std::size_t s = 0; s < kTile; ++s) row[s] *= weights[std::min(s, count - 1)];
  }
}

// point (3, kTile) = (0, 0, 1), the meaning of missing directions.
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

// rows (features, kTile): a level's values at the points.
void encode(const KernelContext& c, const GridLevel& level, const GridConfig& grid, bool exact,
            const float* const* point, const TileBuffers& b, float* rows) {
  if (!exact)
    encode_tile_bf16(level, grid, c.bf16->tables, point, rows);
  else
    encode_tile(level, grid, c.tables, point, *b.cells, rows);
}

// w and the ambient features, or psi, after e in `features`; (w + 1) / 2 into `slice`.
void complete_features(const KernelContext& c, const TileBuffers& b, std::size_t begin, std::size_t count,
                       float* features, float* slice) {
  const Df d;
  const std::size_t e = std::size_t(c.layout.position_features);
  if (!c.layout.has_ambient()) {
    code_rows(c.inputs, c.inputs.conditions, std::size_t(c.layout.concat_count), begin, count,
              features + e * kTile);
    weigh_local_rows(c, begin, count, features + e * kTile);
    return;
  }
  code_rows(c.inputs, c.inputs.conditions, std::size_t(c.config.condition_count), begin, count, b.psi);
  weigh_local_rows(c, begin, count, b.psi);
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
    encode(c, level, c.config.ambient_grid, !c.bf16, point, b, rows);
    rows += std::size_t(c.config.ambient_grid.features) * kTile;
  }
}

// Density network: b.block, of which only the density unless the rest is wanted, b.raw_density, and the
// hidden rows or words.
void density_network(const KernelContext& c, const TileBuffers& b, const float* features, bool geometry) {
  const std::size_t outputs = geometry ? 1 + std::size_t(c.config.geometry_features) : 1;
  if (c.bf16)
    network_bf16(c.bf16->density, features, b.density_words, outputs, b.block);
  else
    network_forward(c.networks, c.layout.density, {features, c.density_inputs()}, b.density_hidden, outputs,
                    b.block);
  if (b.raw_density != b.block) std::memcpy(b.raw_density, b.block, kTile * sizeof(float));
}

// Rows of b.block after the geometry features.
float* direction_place(const KernelContext& c, const TileBuffers& b) {
  return b.block + (1 + std::size_t(c.config.geometry_features)) * kTile;
}

// b.rgb (before the sigmoid) and the hidden rows or words, from the rows of b.block after the density.
void colour_network(const KernelContext& c, const TileBuffers& b) {
  if (c.bf16)
    network_bf16(c.bf16->colour, b.block + kTile, b.colour_words, 3, b.rgb);
  else
    network_forward(c.networks, c.layout.colour, colour_input(c, b), b.colour_hidden, 3, b.rgb);
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
    const bool exact = !c.bf16 || l < c.bf16->exact_levels;
    if (exact) warm(c.tables + level.offset, level.entries * width, samples);
    for (const SampleRun& run : runs) {
      float* to = features + (run.tile * rows + l * width) * kTile;
      for (std::size_t begin = run.begin; begin < run.end; begin += kTile, to += rows * kTile) {
        const float* point[3];
        point_rows(c.inputs, begin, std::min(kTile, run.end - begin), b.point, point);
        ask_for<1>(to + kTilesAhead * rows * kTile, width);
        encode(c, level, c.config.position, exact, point, b, to);
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
std::size_t scratch_floats(const FieldConfig& config, const FieldLayout& layout) {
  return HWY_DYNAMIC_DISPATCH(ScratchFloats)(config, layout);
}

}  // namespace likeness
#endif  // HWY_ONCE
