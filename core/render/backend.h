// Where fields compute. The trainer and the renderer know only this: the processor does it in core/field's
// SIMD kernels, a CUDA device in its own. Both read and write the same parameters, so an avatar or checkpoint
// made by one goes on in the other.
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

// What is learnt, in the host's memory. Refers to the owner's.
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

// Where a step's rays and samples lie on a device, for whoever casts the rays there (core/train/cast_rays.h).
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

// Casts rays where a learner computes.
class DeviceRaySource {
 public:
  virtual ~DeviceRaySource() = default;
  // Queues what fills the batch, counts included. It is recorded in front of the step and replayed for as
  // long as the version stays.
  virtual Result<void> queue_rays(const DeviceBatch& batch) = 0;
  virtual std::uint64_t version() const = 0;
};

// One step's rays, their samples and what the step is to do.
struct LearningStep {
  const SampleBatch& samples;
  std::span<const Vec3f> target, background;  // (R) sRGB-encoded
  std::span<const float> conditions;          // (2 views, K)
  std::size_t views = 0;
  float table_rate = 0, network_rate = 0;
  float table_decay = 0;   // AdamOptions::table_decay
  float code_rate = 0;     // 0: the codes stay
  float code_penalty = 0;  // weight of the codes' mean square in the loss
  // Ascending, apart from each other. Their rays count in the squared error like all others.
  std::span<const RayPatch> patches;
  float patch_weight = 0;  // of the mean over the patches of their losses
  // Of a learner with a device_batch: `cast_rays` rays come from here, and samples, target and background are
  // not looked at.
  DeviceRaySource* cast = nullptr;
  std::size_t cast_rays = 0;
};

struct LearningResult {
  // The mean squared error over rays and channels, and patch_weight times the patches' mean loss; either not
  // finite: nothing was changed.
  double loss = 0, patch_loss = 0;
  std::array<std::size_t, 2> samples{};  // of each field
};

// Learns fields from rays: forward, compositing, loss, backward, Adam.
class FieldLearner {
 public:
  virtual ~FieldLearner() = default;
  virtual Result<LearningResult> step(const LearningStep& step) = 0;
  // Where it takes rays that are cast on its device; null: it takes the host's only.
  virtual const DeviceBatch* device_batch() { return nullptr; }
  // Densities of one of the fields, of a batch of any size.
  virtual Result<void> densities(int field, const FieldInputs& inputs, std::vector<float>& sigma) = 0;
  // Brings the parts up to date with what has been learnt; and the other way round, after they were changed.
  virtual Result<void> fetch() = 0;
  virtual Result<void> place() = 0;
};

// The most that a step asks for.
struct LearnerShape {
  std::size_t rays = 0, samples_per_ray = 0, views = 0;
  // The first of the views, whose codes keep a zero mean, so that the code of zero is theirs; 0: all.
  std::size_t centred_views = 0;
  bool patches = false;  // whether steps have patches
  std::size_t centred() const { return centred_views > 0 ? centred_views : views; }
};

// Renders pictures of one avatar, whose parameters it may hold where it computes.
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

// precision: of the products of trainings, where the processor has both; densities are always exact.
std::shared_ptr<Backend> cpu_backend(FieldPrecision precision = FieldPrecision::bf16);

// On a device (core/device), which knows no patches: a learner of them is refused. halves: products in
// bfloat16 where the device has matrix units for it.
std::shared_ptr<Backend> device_backend(std::shared_ptr<Device> device, bool halves = true);

// What a device makes of options: a ray for every pixel, a colour for every sample that counts.
RenderOptions device_options(RenderOptions options);

// Where pictures are rendered.
struct RenderPlace {
  std::shared_ptr<Backend> backend;             // null: the processor
  bool fall_back = false;                       // where that fails, the processor goes on
  std::function<void(const std::string&)> say;  // told, once, why it does
};
std::unique_ptr<FrameRenderer> cpu_renderer(const Avatar& avatar);
// The avatar must stay as and where it is.
Result<std::unique_ptr<FrameRenderer>> make_renderer(const RenderPlace& place, const Avatar& avatar);

// Whether work failed because of where it was done, and what to say where the processor takes it over.
bool failed_on_device(const Error& error);
std::string continuing_on_processor(const Error& error);

}  // namespace likeness
