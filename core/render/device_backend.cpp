// Fields on a device: see backend.h. A step is recorded once and replayed: copies in, one replay, one number
// out, and the host waits only for that.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/field/device_field.h"
#include "core/render/backend.h"
#include "core/render/device_frame.h"
#include "core/render/device_loss.h"

namespace likeness {
namespace {

// Samples of a batch: whole groups of threads.
std::size_t capacity_of(const LearnerShape& shape) {
  return (shape.rays * shape.samples_per_ray + 255) / 256 * 256;
}

float corrected(float rate, std::uint64_t step) {
  const AdamOptions options;
  const double t = double(step);
  return float(double(rate) * std::sqrt(1 - std::pow(double(options.beta2), t)) /
               (1 - std::pow(double(options.beta1), t)));
}

// The kernels give every sample of a picture the same condition.
Error painted_attributes() {
  return {ErrorCode::bad_input, "Painted attributes are computed only on the processor.",
          "Use --backend cpu, or train without them (likeness attribute remove PROJECT NAME).",
          "CUDA, attributes"};
}

class DeviceLearner : public FieldLearner {
 public:
  DeviceLearner(std::shared_ptr<Device> device, const LearntParts& parts, const LearnerShape& shape)
      : device_(std::move(device)), parts_(parts), shape_(shape) {}
  ~DeviceLearner() override {
    for (void* recording : {recording_, cast_recording_})
      if (recording) device_->forget(recording);
  }

  Result<void> prepare(NetworkPrecision precision) {
    const std::size_t most = capacity_of(shape_);
    std::size_t bytes = 0;
    const DeviceFieldOptions options{most, 2 * shape_.views, true, precision};
    for (const LearntParts::Part& part : parts_.fields)
      if (part.field) bytes += device_field_bytes(part.field->config, options, device_->facts());
    if (const auto free = device_->facts().free_bytes; bytes > free)
      return Error{ErrorCode::failed,
                   fmt::format("Training takes {:.2f} GiB of the GPU's memory, and {:.2f} are free.",
                               double(bytes) / double(1 << 30), double(free) / double(1 << 30)),
                   "Close other programs that use the GPU, or use --backend cpu.", "CUDA"};
    for (std::size_t f = 0; f < 2; ++f) {
      if (!parts_.fields[f].field) continue;
      auto made = DeviceField::make(device_, parts_.fields[f].field->config, options);
      if (!made) return made.error();
      fields_[f] = std::move(*made);
    }
    const std::size_t r = shape_.rays;
    if (auto done = make(begin_, r + 1); !done) return done;
    if (auto done = make(dt_, most); !done) return done;
    if (auto done = make(of_field_, most); !done) return done;
    if (auto done = make(slot_, most); !done) return done;
    if (auto done = make(target_, 3 * r); !done) return done;
    if (auto done = make(background_, 3 * r); !done) return done;
    if (auto done = make(numbers_, 1); !done) return done;
    if (auto done = make(sums_, 1); !done) return done;
    if (auto done = make(codes_first_, half()); !done) return done;
    if (auto done = make(codes_second_, half()); !done) return done;
    batch_ = {device_,
              {fields_[0].get(), fields_[1].get()},
              begin_.data(),
              slot_.data(),
              dt_.data(),
              target_.data(),
              background_.data(),
              of_field_.data(),
              numbers_.data(),
              sums_.data()};
    return place();
  }

  Result<LearningResult> step(const LearningStep& step) override {
    const std::size_t rays = step.cast ? step.cast_rays : step.target.size(),
                      samples = step.cast ? 0 : step.samples.dt.size();
    LIKENESS_CHECK(step.patches.empty(), "%zu patches for a learner without", step.patches.size());
    LIKENESS_CHECK(rays <= shape_.rays && samples <= capacity_of(shape_) && step.views == shape_.views,
                   "%zu rays, %zu samples and %zu views for a learner of %zu, %zu and %zu", rays, samples,
                   step.views, shape_.rays, capacity_of(shape_), shape_.views);
    if (auto done = copy_numbers(step, rays); !done) return done.error();
    if (!step.cast)
      if (auto done = copy_rays(step); !done) return done.error();
    void*& recording = step.cast ? cast_recording_ : recording_;
    if (step.cast && recording && step.cast->version() != cast_version_)
      device_->forget(recording), recording = nullptr;
    if (!recording) {
      auto made = record(step);
      if (!made) return made.error();
      recording = *made;
      if (step.cast) cast_version_ = step.cast->version();
    }
    if (auto done = device_->replay(recording); !done) return done.error();
    StepSums sums{};
    if (auto done = device_->copy_out(&sums, sums_.data(), sizeof(sums)); !done) return done.error();
    if (auto done = device_->wait(); !done) return done.error();
    const std::uint32_t* const count = step.cast ? sums.count : host_numbers_.count;
    const LearningResult result{sums.error / (3 * double(rays)), 0, {count[0], count[1]}};
    if (std::isfinite(result.loss)) count_step(result);
    return result;
  }

  const DeviceBatch* device_batch() override { return &batch_; }

  Result<void> densities(int field, const FieldInputs& inputs, std::vector<float>& sigma) override {
    DeviceField& on = *fields_[std::size_t(field)];
    sigma.resize(inputs.count);
    if (auto done = on.set_conditions(inputs.conditions, 2 * shape_.views); !done) return done;
    for (std::size_t first = 0; first < inputs.count; first += on.capacity()) {
      FieldInputs part = inputs;
      part.count = std::min(on.capacity(), inputs.count - first);
      for (const float** axis : {&part.x, &part.y, &part.z}) *axis += first;
      part.dx = part.dy = part.dz = nullptr;
      if (part.view) part.view += first;
      if (auto done = on.set_samples(part); !done) return done;
      if (auto done = on.set_count(std::uint32_t(part.count)); !done) return done;
      if (auto done = on.density(); !done) return done;
      if (auto done = device_->copy_out(sigma.data() + first, on.sigma(), part.count * sizeof(float)); !done)
        return done;
      if (auto done = device_->wait(); !done) return done;
    }
    return {};
  }

  Result<void> fetch() override {
    for (std::size_t f = 0; f < 2; ++f)
      if (fields_[f])
        if (auto done = fields_[f]->fetch(*parts_.fields[f].field, parts_.fields[f].adam); !done) return done;
    if (half() > 0) {
      ArrayAdamState& adam = *parts_.codes_adam;
      adam.first.resize(half()), adam.second.resize(half());
      const std::size_t bytes = half() * sizeof(float);
      if (auto done = device_->copy_out(parts_.codes->data(), fields_[0]->codes(), bytes); !done) return done;
      if (auto done = device_->copy_out(adam.first.data(), codes_first_.data(), bytes); !done) return done;
      if (auto done = device_->copy_out(adam.second.data(), codes_second_.data(), bytes); !done) return done;
    }
    return device_->wait();
  }

  Result<void> place() override {
    for (std::size_t f = 0; f < 2; ++f)
      if (fields_[f])
        if (auto done = fields_[f]->place(*parts_.fields[f].field, parts_.fields[f].adam); !done) return done;
    const bool codes = half() > 0;
    if (fields_[0])
      if (auto done = fields_[0]->set_codes(codes ? parts_.codes->data() : nullptr, 2 * shape_.views); !done)
        return done;
    if (codes) {
      const ArrayAdamState& adam = *parts_.codes_adam;
      const std::size_t bytes = half() * sizeof(float);
      for (const auto& [to, from] :
           {std::pair{codes_first_.data(), &adam.first}, std::pair{codes_second_.data(), &adam.second}})
        if (auto done = from->size() == half() ? device_->copy_in(to, from->data(), bytes)
                                               : device_->clear(to, bytes);
            !done)
          return done;
    }
    return device_->wait();
  }

 private:
  template <class T>
  Result<void> make(DeviceArray<T>& array, std::size_t count) {
    auto made = DeviceArray<T>::make(device_, count);
    if (!made) return made.error();
    array = std::move(*made);
    return {};
  }

  std::size_t half() const { return parts_.codes ? parts_.codes->size() / 2 : 0; }

  template <class T, class U>
  Result<void> send(const DeviceArray<T>& to, const U* from, std::size_t bytes) {
    return device_->copy_in(to.data(), from, bytes);
  }

  // Copies what every step needs; counts of rays cast on the device are set here.
  Result<void> copy_numbers(const LearningStep& step, std::size_t rays) {
    host_numbers_ = {};
    host_numbers_.rays = std::uint32_t(rays);
    host_numbers_.loss_scale = 1 / (3 * float(rays));
    host_numbers_.table_rate = step.table_rate;
    host_numbers_.table_keep =
        AdamOptions{.table_rate = step.table_rate, .table_decay = step.table_decay}.table_keep();
    for (std::size_t f = 0; f < 2; ++f) {
      if (!fields_[f]) continue;
      if (!step.cast) host_numbers_.count[f] = std::uint32_t(step.samples.fields[f].count());
      host_numbers_.network_rate[f] = corrected(step.network_rate, parts_.fields[f].adam->step + 1);
    }
    if (half() > 0) host_numbers_.code_rate = corrected(step.code_rate, parts_.codes_adam->step + 1);
    if (auto done = fields_[0]->set_conditions(step.conditions.data(), 2 * step.views); !done) return done;
    return send(numbers_, &host_numbers_, sizeof(host_numbers_));
  }

  Result<void> copy_rays(const LearningStep& step) {
    const SampleBatch& samples = step.samples;
    const std::size_t rays = step.target.size(), count = samples.dt.size();
    for (std::size_t f = 0; f < 2; ++f) {
      if (!fields_[f]) continue;
      if (auto done = fields_[f]->set_samples(samples.fields[f].inputs(nullptr, nullptr)); !done) return done;
      if (auto done = fields_[f]->set_count(host_numbers_.count[f]); !done) return done;
    }
    if (auto done = send(begin_, samples.begin.data(), (rays + 1) * 4); !done) return done;
    if (auto done = send(dt_, samples.dt.data(), count * 4); !done) return done;
    if (auto done = send(of_field_, samples.field.data(), count); !done) return done;
    if (auto done = send(slot_, samples.slot.data(), count * 4); !done) return done;
    if (auto done = send(target_, step.target.data(), rays * sizeof(Vec3f)); !done) return done;
    return send(background_, step.background.data(), rays * sizeof(Vec3f));
  }

  Result<void*> record(const LearningStep& step) {
    if (auto done = device_->record(); !done) return done.error();
    const Result<void> queued = queue_step(step);
    auto made = device_->end_record();  // whatever happened, recording ends
    if (!queued) return queued.error();
    return made;
  }

  Result<void> queue_step(const LearningStep& step) {
    static_assert(sizeof(Vec3f) == 3 * sizeof(float));
    if (auto done = device_->clear(sums_.data(), sizeof(StepSums)); !done) return done;
    if (step.cast)
      if (auto done = step.cast->queue_rays(batch_); !done) return done;
    RayLossArgs loss{{},           begin_.data(),  dt_.data(),         of_field_.data(),
                     slot_.data(), target_.data(), background_.data(), numbers_.data(),
                     sums_.data()};
    for (std::size_t f = 0; f < 2; ++f) {
      if (!fields_[f]) continue;
      DeviceField& on = *fields_[f];
      if (auto done = on.density(); !done) return done;
      if (auto done = on.colour(); !done) return done;
      loss.field[f] = {on.sigma(), on.colours(), on.d_sigma(), on.d_colours(), std::uint32_t(on.capacity())};
    }
    if (auto done = device_->launch(Kernel::ray_loss, loss, shape_.rays); !done) return done;
    for (std::size_t f = 0; f < 2; ++f) {
      if (!fields_[f]) continue;
      if (auto done = fields_[f]->backward(); !done) return done;
      if (auto done = fields_[f]->step_tables(numbers_.data(), sums_.data()); !done) return done;
      if (auto done = fields_[f]->step_networks(numbers_.data(), sums_.data(), int(f)); !done) return done;
    }
    if (half() == 0) return {};
    const AdamOptions options;
    const AdamCodesArgs codes{fields_[0]->codes(),
                              fields_[0]->d_codes(),
                              codes_first_.data(),
                              codes_second_.data(),
                              step.code_penalty,
                              std::uint32_t(shape_.views),
                              std::uint32_t(shape_.centred()),
                              std::uint32_t(half() / shape_.views),
                              {options.beta1, options.beta2, options.network_epsilon},
                              numbers_.data(),
                              sums_.data()};
    return device_->launch(Kernel::adam_codes, codes, 1);
  }

  // As adam_step does for fields on the host.
  void count_step(const LearningResult& result) {
    for (std::size_t f = 0; f < 2; ++f)
      if (fields_[f] && result.samples[f] > 0) ++parts_.fields[f].adam->step;
    if (half() > 0 && result.samples[0] > 0) ++parts_.codes_adam->step;
  }

  std::shared_ptr<Device> device_;
  LearntParts parts_;
  LearnerShape shape_;
  std::array<std::unique_ptr<DeviceField>, 2> fields_;
  DeviceArray<std::uint32_t> begin_, slot_;
  DeviceArray<float> dt_, target_, background_, codes_first_, codes_second_;
  DeviceArray<std::uint8_t> of_field_;
  DeviceArray<StepNumbers> numbers_;
  DeviceArray<StepSums> sums_;
  StepNumbers host_numbers_{};
  DeviceBatch batch_;
  void *recording_ = nullptr, *cast_recording_ = nullptr;  // of steps with the host's rays, and the device's
  std::uint64_t cast_version_ = 0;
};

class DeviceBackend : public Backend {
 public:
  DeviceBackend(std::shared_ptr<Device> device, bool halves) : device_(std::move(device)), halves_(halves) {}
  std::string name() const override { return "cuda"; }
  Result<std::unique_ptr<FieldLearner>> make_learner(const LearntParts& parts,
                                                     const LearnerShape& shape) override {
    if (shape.patches)
      return Error{ErrorCode::bad_input, "The landmark loss is computed only on the processor.",
                   "Use --backend cpu, or train without --landmark-loss.", "CUDA, landmark loss"};
    if (const Field* head = parts.fields[0].field; head && head->config.local_conditions > 0)
      return painted_attributes();
    auto learner = std::make_unique<DeviceLearner>(device_, parts, shape);
    if (auto done = learner->prepare(halves_ ? NetworkPrecision::bf16 : NetworkPrecision::single); !done)
      return done.error();
    return std::unique_ptr<FieldLearner>(std::move(learner));
  }
  Result<std::unique_ptr<FrameRenderer>> make_renderer(const Avatar& avatar) override {
    if (!avatar.attributes.empty()) return painted_attributes();
    return device_renderer(device_, avatar, halves_);
  }

 private:
  std::shared_ptr<Device> device_;
  bool halves_;
};

}  // namespace

std::shared_ptr<Backend> device_backend(std::shared_ptr<Device> device, bool halves) {
  return std::make_shared<DeviceBackend>(std::move(device), halves);
}

}  // namespace likeness
