// Training on batches: shares chunks of blocks and levels of tables among threads. See train_fields.h.
//
// Chunks whose gradients are summed are fixed by the blocks and summed in order, and every table level has
// one owner, so that results do not depend on the number of threads.
#include "core/field/train_fields.h"

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <optional>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/field/aligned_floats.h"
#include "core/field/field_bf16.h"
#include "core/field/field_kernels.h"
#include "core/field/field_layout.h"
#include "core/field/huge_pages.h"
#include "core/field/rounded_tables.h"

namespace likeness {

struct FieldTape {
  AlignedFloats features, slice, codes, partials;  // see field_kernels.h; partials: one block per chunk
  RoundedTables rounded;                           // only the memory: refilled every step
};

namespace {

// Blocks that share one block of network gradients, and the samples of one if all are known beforehand.
constexpr std::size_t kChunkBlocks = 16, kBlockSamples = 256;

// Checks that every gradient array is present, and that every row a sample refers to exists.
void check_gradients(const Field& field, const FieldLayout& layout, const FieldInputs& inputs,
                     const FieldGradients& gradients) {
  LIKENESS_CHECK(gradients.parameters.size() == layout.parameter_count &&
                     gradients.touched.size() == layout.table_count / kTableLine,
                 "%zu gradients for %zu parameters", gradients.parameters.size(), layout.parameter_count);
  if (inputs.count == 0) return;
  std::int32_t first = 0, last = 0;
  if (inputs.view) {
    const auto [low, high] = std::minmax_element(inputs.view, inputs.view + inputs.count);
    first = *low, last = *high;
  }
  const std::size_t rows = std::size_t(last) + 1;
  LIKENESS_CHECK(first >= 0 && rows * std::size_t(field.config.latent_count) <= gradients.latents.size() &&
                     rows * std::size_t(field.config.condition_count) <= gradients.conditions.size(),
                 "views %d to %d, but gradients of %zu latents and %zu conditions", first, last,
                 gradients.latents.size(), gradients.conditions.size());
}

// Adds the chunks' blocks, in order, to the gradients of one network.
void reduce_network(const std::vector<DenseLayer>& layers, const std::vector<PartialLayer>& partial_layers,
                    const float* partials, std::size_t stride, std::size_t chunks, float* gradients) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const DenseLayer& layer = layers[l];
    const PartialLayer& partial = partial_layers[l];
    parallel_ranges(std::size_t(layer.outputs), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t o = begin; o < end; ++o) {
        float* row = gradients + layer.weights + o * std::size_t(layer.inputs);
        for (std::size_t k = 0; k < chunks; ++k) {
          const float* from = partials + k * stride + partial.weights + o * partial.stride;
          for (int i = 0; i < layer.inputs; ++i) row[i] += from[i];
          const float* lanes = partials + k * stride + partial.biases + o * kPartialLanes;
          gradients[layer.biases + o] += std::accumulate(lanes, lanes + kPartialLanes, 0.0f);
        }
      }
    });
  }
}

// table[view[n]][column] += row `column` of the tiles. Runs of one view, the samples of a ray, are added
// first.
void reduce_codes(const FieldInputs& inputs, std::span<const SampleRun> runs, const float* codes,
                  std::size_t rows, std::size_t row, float* table, std::size_t width, std::size_t column) {
  std::int32_t run = -1;
  float sum = 0;
  const auto flush = [&] {
    if (run >= 0) table[std::size_t(run) * width + column] += sum;
    sum = 0;
  };
  for (const SampleRun& samples : runs)
    for (std::size_t n = samples.begin; n < samples.end; ++n) {
      const std::int32_t view = inputs.view ? inputs.view[n] : 0;
      if (view != run) flush(), run = view;
      const std::size_t place = samples.tile * kTile + n - samples.begin;
      sum += codes[(place / kTile * rows + row) * kTile + place % kTile];
    }
  flush();
}

// The field's current values; empty in single precision.
std::optional<Bf16Parts> round_parts(const FieldStep& step, const FieldLayout& layout) {
  if (step.precision == FieldPrecision::exact || !has_bf16(step.field.config)) return std::nullopt;
  const float* parameters = step.field.parameters.data();
  round_tables(step.field, layout.table_count, step.tape.rounded);
  return Bf16Parts{step.tape.rounded.values(), exact_levels(step.field.config, layout),
                   pack_network(layout.density, parameters), pack_network(layout.colour, parameters),
                   pack_slopes(step.field.config, layout, parameters)};
}

// One field in a step.
struct Part {
  const FieldStep& step;
  FieldLayout layout = make_layout(step.field.config);
  std::optional<Bf16Parts> bf16;
  KernelContext context{step.field.config, layout, step.field.parameters.data(), step.field.parameters.data(),
                        step.inputs};
  PartialLayout partial = make_partial_layout(layout);
  std::vector<SampleRun> runs;  // of the chunks
  std::size_t codes = context.code_rows(step.gradients.want_conditions);
  std::size_t scratch = scratch_floats(step.field.config, layout);
  std::size_t ring = 0;  // tiles that can be forward but not yet backward

  explicit Part(const FieldStep& s) : step(s) {}
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
};

// Chunks start at whole tiles. The first thing to be done with a part.
void lay_out(Part& part) {
  const FieldStep& step = part.step;
  check_inputs(step.field, part.layout, step.inputs);
  check_gradients(step.field, part.layout, step.inputs, step.gradients);
  part.bf16 = round_parts(step, part.layout);
  part.context.bf16 = part.bf16 ? &*part.bf16 : nullptr;
  LIKENESS_CHECK(step.ends.empty() ? step.inputs.count == 0 : step.ends.back() == step.inputs.count,
                 "blocks of %zu samples, but %zu", step.ends.empty() ? 0 : step.ends.back(),
                 step.inputs.count);
  std::size_t tile = 0, begin = 0, largest = 0;
  for (std::size_t block = 0; block < step.ends.size(); ++block) {
    largest = std::max(largest, step.ends[block] - (block == 0 ? 0 : step.ends[block - 1]));
    if ((block + 1) % kChunkBlocks != 0 && block + 1 < step.ends.size()) continue;
    part.runs.push_back({begin, step.ends[block], tile});
    tile += tiles_of(step.ends[block] - begin), begin = step.ends[block];
  }
  part.ring = tiles_of(largest) + 2;
  for (std::vector<float>* array : {&step.out.sigma, &step.out.red, &step.out.green, &step.out.blue})
    array->resize(step.inputs.count);
  const std::size_t samples = tile * kTile;
  step.tape.features.reserve(samples * part.context.density_inputs());
  step.tape.slice.reserve(samples * std::size_t(std::max(part.layout.ambient_dimensions, 1)));
  step.tape.codes.reserve(samples * part.codes);
  step.tape.partials.reserve(part.runs.size() * part.partial.count);
}

float* training_scratch(std::size_t floats) {
  thread_local AlignedFloats scratch;
  return scratch.reserve(floats);
}

// A thread's pass through a chunk of one field: whole tiles go forward as far as a block needs them, and
// backward once all their samples have slopes.
class Walk {
 public:
  Walk(const Part& part, std::size_t chunk, float* kept) : part_(part), run_(part.runs[chunk]), kept_(kept) {
    partial_ = part.step.tape.partials.data() + chunk * part.partial.count;
    std::fill(partial_, partial_ + part.partial.count, 0.0f);
  }

  void forward_to(std::size_t end) {
    const KernelContext& c = part_.context;
    FieldOutputs& out = part_.step.out;
    for (; start_of(ahead_) < end; ++ahead_) {
      ForwardRange range;
      range.begin = start_of(ahead_), range.end = end_of(ahead_);
      range.features = features(ahead_), range.slice = slice(ahead_), range.kept = kept(ahead_);
      range.scratch = training_scratch(part_.scratch);
      range.sigma = out.sigma.data(), range.red = out.red.data();
      range.green = out.green.data(), range.blue = out.blue.data();
      forward_tiles(c, range);
    }
  }

  void backward_to(std::size_t end) {
    for (; back_ < ahead_ && end_of(back_) <= end; ++back_) {
      BackwardRange range;
      range.begin = start_of(back_), range.end = end_of(back_);
      range.features = features(back_), range.slice = slice(back_), range.kept = kept(back_);
      range.scratch = training_scratch(part_.scratch);
      range.gradients = part_.step.slopes;
      range.want_conditions = part_.step.gradients.want_conditions;
      range.codes = part_.step.tape.codes.data() + (run_.tile + back_) * part_.codes * kTile;
      range.partial = partial_, range.partial_layout = &part_.partial;
      backward_tiles(part_.context, range);
    }
  }

 private:
  std::size_t start_of(std::size_t tile) const { return run_.begin + tile * kTile; }
  std::size_t end_of(std::size_t tile) const { return std::min(start_of(tile + 1), run_.end); }
  float* features(std::size_t tile) const {
    return part_.step.tape.features.data() + (run_.tile + tile) * part_.context.density_inputs() * kTile;
  }
  float* slice(std::size_t tile) const {
    return part_.step.tape.slice.data() +
           (run_.tile + tile) * std::size_t(part_.layout.ambient_dimensions) * kTile;
  }
  float* kept(std::size_t tile) const {
    return kept_ + tile % part_.ring * part_.context.kept_rows() * kTile;
  }

  const Part& part_;
  const SampleRun run_;
  float *kept_, *partial_ = nullptr;
  std::size_t ahead_ = 0, back_ = 0;  // tiles
};

void encode(const Part& part) {
  // Large enough that a level's table is read often once it is in the cache, small enough for every thread.
  const std::size_t shares = std::size_t(std::max(1, current_thread_limit()));
  const std::size_t share = (part.runs.size() + shares - 1) / shares;
  parallel_ranges(part.runs.size(), share, [&](std::size_t begin, std::size_t end) {
    encode_positions(part.context, std::span(part.runs).subspan(begin, end - begin),
                     training_scratch(part.scratch), part.step.tape.features.data());
  });
}

void walk_chunk(std::span<const std::unique_ptr<Part>> parts, std::size_t chunk, std::size_t blocks,
                const BlockLoss& loss) {
  thread_local std::array<AlignedFloats, 2> kept;
  std::vector<Walk> walks;
  for (std::size_t f = 0; f < parts.size(); ++f) {
    const Part& part = *parts[f];
    walks.emplace_back(part, chunk, kept[f].reserve(part.ring * part.context.kept_rows() * kTile));
  }
  const std::size_t last = std::min(blocks, (chunk + 1) * kChunkBlocks);
  for (std::size_t block = chunk * kChunkBlocks; block < last; ++block) {
    for (std::size_t f = 0; f < parts.size(); ++f) walks[f].forward_to(parts[f]->step.ends[block]);
    if (loss) loss(block);
    for (std::size_t f = 0; f < parts.size(); ++f) walks[f].backward_to(parts[f]->step.ends[block]);
  }
}

// Tables and codes: every level and every entry of a code has one owner.
void scatter(const Part& part) {
  const FieldStep& step = part.step;
  FieldGradients& gradients = step.gradients;
  const std::size_t levels = part.layout.position.size(), tables = levels + part.layout.ambient.size();
  const std::size_t latents = std::size_t(step.field.config.latent_count);
  parallel_for(tables + part.codes, [&](std::size_t task) {
    if (task < tables) {
      const bool ambient = task >= levels;
      scatter_level(part.context, part.runs, ambient, int(ambient ? task - levels : task),
                    step.tape.features.data(), step.tape.slice.data(), gradients.parameters.data(),
                    gradients.touched.data());
      return;
    }
    const std::size_t row = task - tables;
    const float* codes = step.tape.codes.data();
    if (row < latents) {
      if (step.inputs.latents)
        reduce_codes(step.inputs, part.runs, codes, part.codes, row, gradients.latents.data(), latents, row);
    } else {
      reduce_codes(step.inputs, part.runs, codes, part.codes, row, gradients.conditions.data(),
                   std::size_t(step.field.config.condition_count), row - latents);
    }
  });
  if (!gradients.want_positions) return;
  for (std::vector<float>* array : {&gradients.x, &gradients.y, &gradients.z})
    array->resize(step.inputs.count);
  parallel_for(part.runs.size(), [&](std::size_t run) {
    position_gradients(part.context, part.runs[run], step.tape.features.data(), gradients.x.data(),
                       gradients.y.data(), gradients.z.data());
  });
}

void reduce_networks(const Part& part) {
  const float* partials = part.step.tape.partials.data();
  float* g = part.step.gradients.parameters.data();
  const std::size_t count = part.partial.count, chunks = part.runs.size();
  reduce_network(part.layout.slice, part.partial.slice, partials, count, chunks, g);
  reduce_network(part.layout.density, part.partial.density, partials, count, chunks, g);
  reduce_network(part.layout.colour, part.partial.colour, partials, count, chunks, g);
}

}  // namespace

std::shared_ptr<FieldTape> make_tape() { return std::make_shared<FieldTape>(); }

FieldGradients make_gradients(const Field& field, std::size_t views) {
  const FieldLayout layout = make_layout(field.config);
  FieldGradients gradients;
  gradients.parameters = large_array(layout.parameter_count);
  gradients.touched.assign(layout.table_count / kTableLine, 0);
  gradients.latents.assign(views * std::size_t(field.config.latent_count), 0.0f);
  gradients.conditions.assign(views * std::size_t(field.config.condition_count), 0.0f);
  return gradients;
}

void clear_gradients(FieldGradients& gradients) {
  for (std::vector<float>* array : {&gradients.parameters, &gradients.latents, &gradients.conditions}) {
    std::fill(array->begin(), array->end(), 0.0f);
  }
  std::fill(gradients.touched.begin(), gradients.touched.end(), std::uint8_t{0});
}

void train_fields(std::span<const FieldStep> steps, const BlockLoss& loss) {
  if (steps.empty()) return;
  const std::size_t blocks = steps[0].ends.size();
  std::vector<std::unique_ptr<Part>> parts;
  for (const FieldStep& step : steps) {
    LIKENESS_CHECK(step.ends.size() == blocks && steps.size() <= 2, "%zu and %zu blocks of %zu fields",
                   blocks, step.ends.size(), steps.size());
    parts.push_back(std::make_unique<Part>(step));
    lay_out(*parts.back());
    encode(*parts.back());
  }
  parallel_for((blocks + kChunkBlocks - 1) / kChunkBlocks,
               [&](std::size_t chunk) { walk_chunk(parts, chunk, blocks, loss); });
  for (const std::unique_ptr<Part>& part : parts) {
    reduce_networks(*part);
    scatter(*part);
  }
}

void train_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out,
                 const FieldOutputGradients& slopes, FieldTape& tape, FieldGradients& gradients,
                 FieldPrecision precision) {
  std::vector<std::size_t> ends;
  for (std::size_t end = 0; end < inputs.count;) {
    end = std::min(inputs.count, end + kBlockSamples);
    ends.push_back(end);
  }
  const FieldStep step{field, inputs, ends, out, slopes, tape, gradients, precision};
  train_fields({&step, 1}, nullptr);
}

}  // namespace likeness
