// Where fields are computed. The trainer and the renderer use only this: the processor computes in
// core/field's SIMD kernels, a CUDA device in its own. Both read and write the same parameters, so an avatar
// or checkpoint made by one can be continued on the other.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/device/device.h"
#include "core/field/adam.h"
#include "core/field/field.h"
#include "core/field/precision.h"
#include "core/render/patch_loss.h"
#include "core/render/rays.h"
#include "core/render/render.h"

namespace likeness {

// What is learnt, in the host's memory. Refers to its owner's data.
struct LearntParts {
  struct Part {
    Field* field = nullptr;  // null: no such field
    AdamState* adam = nullptr;
  };
  std::array<Part, 2> fields;           // head, torso
  std::vector<float>* codes = nullptr;  // (2 views, L) of the head's field, or empty
  ArrayAdamState* codes_adam = nullptr;
};

class DeviceField;
struct StepNumbers;
struct StepSums;

// Where a step's rays and samples are on a device, for the code that casts the rays there
// (core/train/cast_rays.h).
struct DeviceBatch {
  std::shared_ptr<Device> device;
  std::array<DeviceField*, 2> fields{};  // null: no such field
  // As in SampleBatch and RayBatch.
  std::uint32_t *begin = nullptr, *slot = nullptr;
  float *dt = nullptr, *target = nullptr, *background = nullptr;
  std::uint8_t* of_field = nullptr;
  StepNumbers* numbers = nullptr;
  StepSums* sums = nullptr;
};

// Casts rays on the device where a learner computes.
class DeviceRaySource {
 public:
  virtual ~DeviceRaySource() = default;
  // Queues the work that fills the batch, counts included. It is recorded before the step and replayed as
  // long as the version is unchanged.
  virtual Result<void> queue_rays(const DeviceBatch& batch) = 0;
  virtual std::uint64_t version() const = 0;
};

// One step's rays, their samples and its settings.
struct LearningStep {
  const SampleBatch& samples;
  std::span<const Vec3f> target, background;  // (R) sRGB-encoded
  std::span<const float> conditions;          // (2 views, K)
  std::size_t views = 0;
  float table_rate = 0, network_rate = 0;
  float table_decay = 0;   // AdamOptions::table_decay
  float code_rate = 0;     // 0: the codes are unchanged
  float code_penalty = 0;  // weight of the codes' mean square in the loss
  // Ascending, apart from each other. Their rays count in the squared error like all others.
  std::span<const RayPatch> patches;
  float patch_weight = 0;  // of the mean over the patches of their losses
  // For a learner with a device_batch: `cast_rays` rays come from here, and samples, target and background
  // are ignored.
  DeviceRaySource* cast = nullptr;
  std::size_t cast_rays = 0;
};

struct LearningResult {
  // The mean squared error over rays and channels, and patch_weight times the patches' mean loss; if either
  // is not finite, nothing was changed.
  double loss = 0, patch_loss = 0;
  std::array<std::size_t, 2> samples{};  // of each field
};

// Learns fields from rays: forward, compositing, loss, backward, Adam.
class FieldLearner {
 public:
  virtual ~FieldLearner() = default;
  virtual Result<LearningResult> step(const LearningStep& step) = 0;
  // Where it takes rays cast on its device; null: it takes only the host's.
  virtual const DeviceBatch* device_batch() { return nullptr; }
  // Densities of one of the fields, for a batch of any size.
  virtual Result<void> densities(int field, const FieldInputs& inputs, std::vector<float>& sigma) = 0;
  // Copies what has been learnt to the parts; and the other way round, after they were changed.
  virtual Result<void> fetch() = 0;
  virtual Result<void> place() = 0;
};

// Upper bounds of a step.
struct LearnerShape {
  std::size_t rays = 0, samples_per_ray = 0, views = 0;
  // Number of first views whose codes keep a zero mean, so that the zero code stands for them; 0: all.
  std::size_t centred_views = 0;
  bool patches = false;  // whether steps have patches
  std::size_t centred() const { return centred_views > 0 ? centred_views : views; }
};

// Renders pictures of one avatar, whose parameters it may keep on its device.
class FrameRenderer {
 public:
  virtual ~FrameRenderer() = default;
  // As render_frame. Errors: a device that fails.
  virtual Result<RenderedFrame> render(const Camera& camera, const RenderState& state,
                                       const RenderOptions& options) = 0;
  virtual std::string backend() const = 0;  // cpu, cuda
};

class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;  // cpu, cuda
  // The parts must stay where they are.
  virtual Result<std::unique_ptr<FieldLearner>> make_learner(const LearntParts& parts,
                                                             const LearnerShape& shape) = 0;
  // The avatar must stay as and where it is.
  virtual Result<std::unique_ptr<FrameRenderer>> make_renderer(const Avatar& avatar) = 0;
};

// precision: of the matrix products in training, if the processor supports both; densities are always exact.
std::shared_ptr<Backend> cpu_backend(FieldPrecision precision = FieldPrecision::bf16);

// On a device (core/device), which does not support patches: a learner with them is refused. halves: products
// in bfloat16 if the device has matrix units for it.
std::shared_ptr<Backend> device_backend(std::shared_ptr<Device> device, bool halves = true);

// The options as a device applies them: a ray for every pixel, a colour for every sample that counts.
RenderOptions device_options(RenderOptions options);

// Where pictures are rendered.
struct RenderPlace {
  std::shared_ptr<Backend> backend;             // null: the processor
  bool fall_back = false;                       // if that fails, the processor takes over
  std::function<void(const std::string&)> say;  // called once, with the reason
};
std::unique_ptr<FrameRenderer> cpu_renderer(const Avatar& avatar);
// The avatar must stay as and where it is.
Result<std::unique_ptr<FrameRenderer>> make_renderer(const RenderPlace& place, const Avatar& avatar);

// Whether work failed because of the device, and the message when the processor takes over.
bool failed_on_device(const Error& error);
std::string continuing_on_processor(const Error& error);

}  // namespace likeness
