// Fields on the processor: see backend.h.
#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/field/evaluate.h"
#include "core/field/train_fields.h"
#include "core/render/backend.h"
#include "core/render/composite.h"

namespace likeness {
namespace {

constexpr int kMaxSamples = 16;

// Rays whose samples are evaluated and backpropagated together.
constexpr std::size_t kBlockRays = 16;

// Scratch of a field in training.
struct Scratch {
  std::shared_ptr<FieldTape> tape = make_tape();
  FieldGradients gradients;
  FieldOutputs outputs;
  std::vector<float> d_sigma, d_red, d_green, d_blue;
  std::vector<std::size_t> ends;  // of the blocks' samples

  void resize_slopes(std::size_t count) {
    for (auto* v : {&d_sigma, &d_red, &d_green, &d_blue}) v->resize(count);
  }
};

// Consecutive rays; patch: the patch they form, or null.
struct RayBlock {
  std::size_t begin = 0, end = 0;
  const RayPatch* patch = nullptr;
};

// Rays outside patches in blocks of kBlockRays, every patch in one of its own.
void divide_rays(const LearningStep& step, std::vector<RayBlock>& blocks) {
  blocks.clear();
  const std::size_t rays = step.samples.begin.size() - 1;
  auto patch = step.patches.begin();
  for (std::size_t r = 0; r < rays; r = blocks.back().end) {
    const bool at_patch = patch != step.patches.end() && patch->first == r;
    const std::size_t stop = patch != step.patches.end() ? patch->first : rays;
    blocks.push_back(at_patch ? RayBlock{r, r + patch->count, &*patch}
                              : RayBlock{r, std::min(stop, r + kBlockRays)});
    LIKENESS_CHECK(blocks.back().end > r && blocks.back().end <= rays, "rays %zu to %zu of %zu", r,
                   blocks.back().end, rays);
    if (at_patch) ++patch;
  }
}

struct BlockError {
  double squared = 0, patch = 0;
};

// Forward and backward compositing of a block's rays; returns their summed squared error and the patch's
// loss.
struct RayLoss {
  const LearningStep& step;
  std::array<Scratch, 2>& fields;
  float scale = 1;        // of the squared error: 1 / (rays * channels)
  float patch_scale = 0;  // of a patch's loss

  // A ray's samples; returns their number.
  int gather(std::size_t r, float* sigma, float* colour) const {
    const SampleBatch& samples = step.samples;
    const std::uint32_t first = samples.begin[r];
    const int n = int(samples.begin[r + 1] - first);
    for (int i = 0; i < n; ++i) {
      const FieldOutputs& out = fields[samples.field[first + i]].outputs;
      const std::uint32_t at = samples.slot[first + i];
      sigma[i] = out.sigma[at];
      colour[3 * i] = out.red[at], colour[3 * i + 1] = out.green[at], colour[3 * i + 2] = out.blue[at];
    }
    return n;
  }

  float difference(std::size_t r, const Composited<float>& seen, int c) const {
    return seen.colour[c] + seen.transmittance * step.background[r][c] - step.target[r][c];
  }

  // Sets the slopes (rays of the patch, 3) of its loss.
  double patch_slopes(const RayPatch& patch, std::vector<float>& slopes) const {
    float sigma[kMaxSamples], colour[3 * kMaxSamples];
    thread_local std::vector<float> differences;
    differences.clear();
    for (std::size_t r = patch.first; r < patch.first + patch.count; ++r) {
      const int n = gather(r, sigma, colour);
      const Composited<float> seen =
          composite_ray(n, sigma, step.samples.dt.data() + step.samples.begin[r], colour);
      for (int c = 0; c < 3; ++c) differences.push_back(difference(r, seen, c));
    }
    slopes.resize(differences.size());
    return patch_loss<float>(patch.map, patch_scale * patch.weight, differences, slopes);
  }

  BlockError operator()(const RayBlock& block) const {
    const SampleBatch& samples = step.samples;
    float sigma[kMaxSamples], colour[3 * kMaxSamples], d_sigma[kMaxSamples], d_colour[3 * kMaxSamples];
    thread_local std::vector<float> slopes;
    BlockError error;
    if (block.patch) error.patch = patch_slopes(*block.patch, slopes);
    for (std::size_t r = block.begin; r < block.end; ++r) {
      const std::uint32_t first = samples.begin[r];
      const int n = gather(r, sigma, colour);
      const Composited<float> seen = composite_ray(n, sigma, samples.dt.data() + first, colour);
      float d_pixel[3];
      for (int c = 0; c < 3; ++c) {
        const float off = difference(r, seen, c);
        error.squared += double(off) * off;
        d_pixel[c] = 2 * scale * off;
        if (block.patch) d_pixel[c] += slopes[3 * (r - block.begin) + std::size_t(c)];
      }
      composite_ray_backward(n, sigma, samples.dt.data() + first, colour, step.background[r].data(), seen,
                             d_pixel, 0.f, d_sigma, d_colour);
      for (int i = 0; i < n; ++i) {
        Scratch& field = fields[samples.field[first + i]];
        const std::uint32_t at = samples.slot[first + i];
        field.d_sigma[at] = d_sigma[i];
        field.d_red[at] = d_colour[3 * i], field.d_green[at] = d_colour[3 * i + 1];
        field.d_blue[at] = d_colour[3 * i + 2];
      }
    }
    return error;
  }
};

class CpuLearner : public FieldLearner {
 public:
  CpuLearner(const LearntParts& parts, const LearnerShape& shape, FieldPrecision precision)
      : parts_(parts), precision_(precision), centred_views_(shape.centred()) {
    LIKENESS_CHECK(shape.samples_per_ray <= std::size_t(kMaxSamples), "%zu samples a ray",
                   shape.samples_per_ray);
    for (std::size_t f = 0; f < 2; ++f)
      if (parts_.fields[f].field)
        scratch_[f].gradients = make_gradients(*parts_.fields[f].field, 2 * shape.views);
  }

  Result<LearningResult> step(const LearningStep& step) override {
    const float* codes = parts_.codes && !parts_.codes->empty() ? parts_.codes->data() : nullptr;
    divide_rays(step, blocks_);
    end_blocks(step.samples);
    std::vector<FieldStep> passes;
    for (std::size_t f = 0; f < 2; ++f) {
      const FieldSamples& samples = step.samples.fields[f];
      if (!parts_.fields[f].field || samples.count() == 0) continue;
      Scratch& own = scratch_[f];
      own.resize_slopes(samples.count());
      const FieldOutputGradients slopes{own.d_sigma.data(), own.d_red.data(), own.d_green.data(),
                                        own.d_blue.data()};
      passes.push_back({*parts_.fields[f].field,
                        samples.inputs(step.conditions.data(), f == 0 ? codes : nullptr), own.ends,
                        own.outputs, slopes, *own.tape, own.gradients, precision_});
    }
    const LearningResult result = train(step, passes);
    if (!std::isfinite(result.loss + result.patch_loss)) {
      for (const FieldStep& pass : passes) clear_gradients(pass.gradients);
      return result;
    }
    AdamOptions adam;
    adam.table_rate = step.table_rate, adam.network_rate = step.network_rate;
    adam.table_decay = step.table_decay;
    for (std::size_t f = 0; f < 2; ++f)
      if (parts_.fields[f].field && step.samples.fields[f].count() > 0)
        adam_step(*parts_.fields[f].field, scratch_[f].gradients, *parts_.fields[f].adam, adam);
    if (step.code_rate > 0 && step.samples.fields[0].count() > 0) update_codes(step, adam);
    return result;
  }

  Result<void> densities(int field, const FieldInputs& inputs, std::vector<float>& sigma) override {
    evaluate_density(*parts_.fields[std::size_t(field)].field, inputs, sigma);
    return {};
  }
  Result<void> fetch() override { return {}; }
  Result<void> place() override { return {}; }

 private:
  // Rays are in order in both fields.
  void end_blocks(const SampleBatch& samples) {
    std::array<std::size_t, 2> count{};
    for (Scratch& field : scratch_) field.ends.clear();
    for (const RayBlock& block : blocks_) {
      for (std::size_t i = samples.begin[block.begin]; i < samples.begin[block.end]; ++i)
        ++count[samples.field[i]];
      for (std::size_t f = 0; f < 2; ++f) scratch_[f].ends.push_back(count[f]);
    }
  }

  // Gradients of the fields; returns the loss, summed by blocks so that it does not depend on the threads.
  LearningResult train(const LearningStep& step, std::span<const FieldStep> passes) {
    const std::size_t rays = step.target.size();
    const RayLoss loss{step, scratch_, 1.f / (3 * float(rays)),
                       step.patch_weight / float(std::max<std::size_t>(1, step.patches.size()))};
    std::vector<BlockError> errors(blocks_.size());
    const auto block_loss = [&](std::size_t block) { errors[block] = loss(blocks_[block]); };
    if (passes.empty())  // no ray meets a field
      parallel_for(errors.size(), block_loss);
    else
      train_fields(passes, block_loss);
    LearningResult result;
    for (std::size_t f = 0; f < 2; ++f) result.samples[f] = step.samples.fields[f].count();
    for (const BlockError& error : errors) result.loss += error.squared, result.patch_loss += error.patch;
    result.loss /= 3 * double(rays);
    return result;
  }

  void update_codes(const LearningStep& step, const AdamOptions& options) {
    std::vector<float>& all = *parts_.codes;
    const std::size_t views = step.views, length = views == 0 ? 0 : all.size() / (2 * views);
    const std::size_t half = views * length;
    if (half == 0) return;
    std::vector<float>& latents = scratch_[0].gradients.latents;
    std::vector<float> codes(all.begin(), all.begin() + std::ptrdiff_t(half));
    std::vector<float> slope(latents.begin(), latents.begin() + std::ptrdiff_t(half));
    for (std::size_t i = 0; i < half; ++i) slope[i] += 2 * step.code_penalty * codes[i] / float(half);
    adam_step(codes, slope, *parts_.codes_adam, step.code_rate, options);
    for (std::size_t l = 0; l < length; ++l) {
      double mean = 0;
      for (std::size_t v = 0; v < centred_views_; ++v) mean += codes[v * length + l];
      mean /= double(centred_views_);
      for (std::size_t v = 0; v < centred_views_; ++v) codes[v * length + l] -= float(mean);
    }
    std::copy(codes.begin(), codes.end(), all.begin());
    std::fill(latents.begin(), latents.end(), 0.f);
  }

  LearntParts parts_;
  FieldPrecision precision_;
  std::size_t centred_views_;
  std::array<Scratch, 2> scratch_;
  std::vector<RayBlock> blocks_;  // of the step
};

class CpuBackend : public Backend {
 public:
  explicit CpuBackend(FieldPrecision precision) : precision_(precision) {}
  std::string name() const override { return "cpu"; }
  Result<std::unique_ptr<FieldLearner>> make_learner(const LearntParts& parts,
                                                     const LearnerShape& shape) override {
    return std::unique_ptr<FieldLearner>(std::make_unique<CpuLearner>(parts, shape, precision_));
  }
  Result<std::unique_ptr<FrameRenderer>> make_renderer(const Avatar& avatar) override {
    return cpu_renderer(avatar);
  }

 private:
  FieldPrecision precision_;
};

}  // namespace

std::shared_ptr<Backend> cpu_backend(FieldPrecision precision) {
  return std::make_shared<CpuBackend>(precision);
}

}  // namespace likeness
