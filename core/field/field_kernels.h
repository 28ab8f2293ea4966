// The field's fast kernels (field_simd.cpp, train_simd.cpp), each over a range of samples; evaluate.cpp
// shares ranges among threads. Internal to core/field.
//
// Samples are worked on in tiles of kTile. An array "(tiles, rows, kTile)" holds, per tile, one row of kTile
// samples per component, so that SIMD lanes are samples and memory is read in order. The last tile of a batch
// is padded with copies of the last sample, whose gradients are zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/field/field.h"
#include "core/field/field_config.h"
#include "core/field/field_layout.h"

namespace likeness {

inline constexpr std::size_t kTile = 64;
inline constexpr std::size_t pair_count(std::size_t count) { return (count + 1) / 2; }
inline constexpr std::size_t tiles_of(std::size_t count) { return (count + kTile - 1) / kTile; }

// Gradients of the networks of one chunk of samples. Rows of weights are padded to whole vectors, and a bias
// is spread over the lanes, so that a tile is added without horizontal sums.
struct PartialLayer {
  std::size_t weights = 0, biases = 0;  // offsets; weights (outputs, stride), biases (outputs, kPartialLanes)
  std::size_t stride = 0;               // inputs rounded up
};
inline constexpr std::size_t kPartialLanes = 16;
struct PartialLayout {
  std::vector<PartialLayer> slice, density, colour;
  std::size_t count = 0;
};
PartialLayout make_partial_layout(const FieldLayout& layout);

struct Bf16Parts;

// What every kernel needs from the field and the batch.
struct KernelContext {
  const FieldConfig& config;
  const FieldLayout& layout;
  const float* tables;    // that the layout's levels
  const float* networks;  // and its layers point into
  const FieldInputs& inputs;
  const Bf16Parts* bf16 = nullptr;  // or null: all in single precision

  std::size_t density_inputs() const {
    return std::size_t(layout.position_features + layout.ambient_features + layout.concat_count);
  }
  // Number of inputs of the colour network.
  std::size_t colour_inputs() const {
    return std::size_t(config.geometry_features + layout.direction_features + config.latent_count);
  }
  // Rows that a training step keeps of a tile's forward pass for the backward pass: inputs of the slice
  // network, outputs of the hidden layers and of the networks; about a kilobyte per sample, or with bf16 two
  // thirds of it.
  std::size_t kept_rows() const {
    const std::size_t slice =
        layout.has_ambient() ? std::size_t(config.condition_count + config.slice_width) : 0;
    const auto hidden = [&](int layers, int width) {
      return std::size_t(layers) * (bf16 ? pair_count(std::size_t(width)) : std::size_t(width));
    };
    const std::size_t inputs =
        bf16 ? pair_count(density_inputs()) + pair_count(colour_inputs()) : colour_inputs();
    return slice + inputs + 1 + hidden(config.density_layers, config.density_width) +
           hidden(config.colour_layers, config.colour_width) + 3;
  }
  // Rows of gradients of codes that backward_tiles writes: latents, then conditions if wanted.
  std::size_t code_rows(bool want_conditions) const {
    return std::size_t(config.latent_count + (want_conditions ? config.condition_count : 0));
  }
};

// Parameters and inputs that do not match the layout are a programmer's mistake.
void check_inputs(const Field& field, const FieldLayout& layout, const FieldInputs& inputs);

// Floats of scratch a thread needs for the tiles of one field, forward and backward.
std::size_t scratch_floats(const FieldConfig& config, const FieldLayout& layout);

// Samples [begin, end) of a batch lie in the tiles from `tile` on, of which the last may be padded.
struct SampleRun {
  std::size_t begin = 0, end = 0, tile = 0;
};

// e of the runs' samples into features (tiles of the batch, density inputs, kTile).
void encode_positions(const KernelContext& context, std::span<const SampleRun> runs, float* scratch,
                      float* features);

// Samples [begin, end). `features`, `slice` and `kept` point at the tile of `begin`.
struct ForwardRange {
  std::size_t begin = 0, end = 0;
  float* features = nullptr;  // (tiles, density inputs, kTile): in: e; out: behind it a or psi
  float* slice = nullptr;     // (tiles, ambient dimensions, kTile): (w + 1) / 2
  float* kept = nullptr;      // (tiles, kept rows, kTile) for backward, or null
  float* scratch = nullptr;
  float *sigma = nullptr, *red = nullptr, *green = nullptr,
        *blue = nullptr;      // (N) of the batch; red null: density only
  float* geometry = nullptr;  // (N, geometry_stride) of the batch, or null: not kept
};
void forward_tiles(const KernelContext& context, const ForwardRange& range);

// Geometry features of a sample, padded to whole loads.
inline std::size_t geometry_stride(const FieldConfig& config) {
  return (std::size_t(config.geometry_features) + 3) / 4 * 4;
}

// Colours of samples chosen[begin..end) of the batch.
struct ColourRange {
  std::size_t begin = 0, end = 0;
  const std::uint32_t* chosen = nullptr;
  const float* geometry = nullptr;  // (N, geometry_stride) as left by forward_tiles
  float* scratch = nullptr;
  float *red = nullptr, *green = nullptr, *blue = nullptr;  // (chosen)
};
void colour_tiles(const KernelContext& context, const ColourRange& range);

struct BackwardRange {
  std::size_t begin = 0, end = 0;
  float* features = nullptr;  // in: as left by forward; out: gradients of e (complete) and a or psi
  const float* slice = nullptr;
  float* kept = nullptr;  // as left by forward; overwritten
  float* scratch = nullptr;
  FieldOutputGradients gradients;
  bool want_conditions = false;
  float* codes = nullptr;    // (tiles, code rows, kTile)
  float* partial = nullptr;  // added to
  const PartialLayout* partial_layout = nullptr;
};
void backward_tiles(const KernelContext& context, const BackwardRange& range);

// Adds the gradients of one level's table over the whole batch; marks its touched lines. Levels are
// independent. `features`: (tiles, density inputs, kTile) gradients from backward_tiles.
void scatter_level(const KernelContext& context, std::span<const SampleRun> runs, bool ambient, int level,
                   const float* features, const float* slice, float* gradients, std::uint8_t* touched);

// Gradient of a run's positions from the gradients of e.
void position_gradients(const KernelContext& context, const SampleRun& run, const float* features, float* x,
                        float* y, float* z);

// One Adam update of `count` values with the corrected learning rate; clears the gradients.
struct AdamStep {
  float rate = 0, beta1 = 0, beta2 = 0, epsilon = 0, l2 = 0;
  float keep = 1;  // of the values, before the step
};
void adam_update(float* values, float* gradients, float* first, float* second, std::size_t count,
                 const AdamStep& step);

}  // namespace likeness
