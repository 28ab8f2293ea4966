// Timing the standard field on a device: see device_speed.h.
#include "core/lab/bench/device_speed.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "core/device/device_ceilings.h"
#include "core/field/field_reference.h"
#include "core/lab/bench/relative_l2.h"
#include "core/lab/bench/standard_field.h"

namespace likeness {
namespace {

constexpr double kSingleMargin = 1e-4, kHalfMargin = 4e-3;

// Median device time of `work`, after one round that does not count.
Result<double> timed(Device& device, int rounds, const std::function<Result<void>()>& work) {
  std::vector<double> seconds;
  for (int k = 0; k <= rounds; ++k) {
    if (auto done = device.mark(0); !done) return done.error();
    if (auto done = work(); !done) return done.error();
    if (auto done = device.mark(1); !done) return done.error();
    if (auto done = device.wait(); !done) return done.error();
    const auto taken = device.between(0, 1);
    if (!taken) return taken.error();
    if (k > 0) seconds.push_back(*taken);
  }
  std::nth_element(seconds.begin(), seconds.begin() + std::ptrdiff_t(seconds.size() / 2), seconds.end());
  return seconds[seconds.size() / 2];
}

Result<DeviceCeilings> measure_ceilings(std::shared_ptr<Device> device, const DeviceBenchOptions& options) {
  const std::size_t items = options.ceiling_bytes / 16;
  auto in = DeviceArray<float>::make(device, 4 * items), out = DeviceArray<float>::make(device, 4 * items);
  if (!in) return in.error();
  if (!out) return out.error();
  if (auto done = device->clear(in->data(), 16 * items); !done) return done.error();
  DeviceCeilings ceilings;
  CeilingArgs args{in->data(), out->data(), options.matrix_repeats};
  const auto moved =
      timed(*device, options.rounds, [&] { return device->launch(Kernel::read_write, args, items); });
  if (!moved) return moved.error();
  ceilings.bandwidth_gbs = 32e-9 * double(items) / *moved;
  if (!device->facts().matrix_units) return ceilings;
  const std::size_t warps = std::size_t(device->facts().multiprocessors) * 64;
  const auto multiplied =
      timed(*device, options.rounds, [&] { return device->launch(Kernel::matrix_rate, args, warps); });
  if (!multiplied) return multiplied.error();
  ceilings.matrix_tflops =
      1e-12 * 8192.0 * kMatrixChains * double(options.matrix_repeats) * double(warps) / *multiplied;
  return ceilings;
}

// A field with a batch on the device, and the inputs of a step of Adam.
struct Setup {
  std::unique_ptr<DeviceField> on;
  DeviceArray<StepNumbers> numbers;
  DeviceArray<StepSums> sums;
};

Result<Setup> set_up(std::shared_ptr<Device> device, const Field& field, const StandardBatch& batch,
                     NetworkPrecision precision) {
  const std::size_t n = batch.x.size();
  auto made = DeviceField::make(device, field.config, {n, batch.views, true, precision});
  if (!made) return made.error();
  auto numbers = DeviceArray<StepNumbers>::make(device, 1);
  auto sums = DeviceArray<StepSums>::make(device, 1);
  if (!numbers) return numbers.error();
  if (!sums) return sums.error();
  Setup setup{std::move(*made), std::move(*numbers), std::move(*sums)};
  const AdamState adam = make_adam_state(field);
  const StepNumbers step{{std::uint32_t(n), 0}, 1, 1, 1e-2f, 1, {3e-3f, 0}, 0};
  const float* slopes[4] = {batch.sigma.data(), batch.red.data(), batch.green.data(), batch.blue.data()};
  if (auto done = setup.on->place(field, &adam); !done) return done.error();
  if (auto done = setup.on->set_samples(batch.inputs()); !done) return done.error();
  if (auto done = setup.on->set_conditions(batch.conditions.data(), batch.views); !done) return done.error();
  if (auto done = setup.on->set_codes(batch.latents.data(), batch.views); !done) return done.error();
  if (auto done = setup.on->set_count(std::uint32_t(n)); !done) return done.error();
  if (auto done = device->copy_in(setup.numbers.data(), &step, sizeof(step)); !done) return done.error();
  if (auto done = device->clear(setup.sums.data(), sizeof(StepSums)); !done) return done.error();
  for (std::size_t k = 0; k < 4; ++k) {
    float* to = k == 0 ? setup.on->d_sigma() : setup.on->d_colours() + (k - 1) * n;
    if (auto done = device->copy_in(to, slopes[k], n * sizeof(float)); !done) return done.error();
  }
  if (auto done = device->wait(); !done) return done.error();
  return setup;
}

Result<void> inference(Setup& setup) {
  if (auto done = setup.on->density(); !done) return done;
  return setup.on->colour();
}

Result<void> training(Setup& setup) {
  if (auto done = inference(setup); !done) return done;
  if (auto done = setup.on->backward(); !done) return done;
  if (auto done = setup.on->step_tables(setup.numbers.data(), setup.sums.data()); !done) return done;
  return setup.on->step_networks(setup.numbers.data(), setup.sums.data(), 0);
}

// As the trainer does it: recorded once, then replayed.
Result<double> timed_recording(Device& device, int rounds, const std::function<Result<void>()>& work) {
  if (auto done = device.record(); !done) return done.error();
  const auto queued = work();
  const auto recording = device.end_record();
  if (!queued) return queued.error();
  if (!recording) return recording.error();
  auto seconds = timed(device, rounds, [&] { return device.replay(*recording); });
  device.forget(*recording);
  return seconds;
}

DevicePass pass_of(double seconds, const DeviceWork& work, const DeviceCeilings& ceilings,
                   std::size_t samples) {
  const double floor = floor_seconds(work, ceilings);
  return {seconds, floor, floor / seconds, 1e-6 * double(samples) / seconds};
}

Result<DeviceBatchSpeed> measure_batch(std::shared_ptr<Device> device, const DeviceCeilings& ceilings,
                                       std::size_t samples, NetworkPrecision precision,
                                       const DeviceBenchOptions& options) {
  const Field field = standard_field(options.seed);
  const StandardBatch batch = standard_batch(field.config, samples, options.seed + 1);
  auto setup = set_up(device, field, batch, precision);
  if (!setup) return setup.error();
  const auto forward = timed_recording(*device, options.rounds, [&] { return inference(*setup); });
  if (!forward) return forward.error();
  const auto step = timed_recording(*device, options.rounds, [&] { return training(*setup); });
  if (!step) return step.error();
  return DeviceBatchSpeed{samples, precision,
                          pass_of(*forward, inference_work(field.config, samples), ceilings, samples),
                          pass_of(*step, training_work(field.config, samples), ceilings, samples)};
}

Result<DeviceFieldError> measure_error(std::shared_ptr<Device> device, NetworkPrecision precision,
                                       const DeviceBenchOptions& options) {
  const Field field = standard_field(options.seed);
  StandardBatch batch = standard_batch(field.config, options.error_samples, options.seed + 1);
  const std::vector<double> parameters(field.parameters.begin(), field.parameters.end());
  const auto samples = reference_samples<double>(field.config, batch.inputs(), batch.views);
  const auto margin = reference_margin<double>(field.config, parameters, samples);
  for (std::size_t n = 0; n < margin.size(); ++n)
    if (margin[n] < (precision == NetworkPrecision::bf16 ? kHalfMargin : kSingleMargin))
      batch.sigma[n] = batch.red[n] = batch.green[n] = batch.blue[n] = 0;
  const auto truth = reference_forward<double>(field.config, parameters, samples);
  const auto slopes = reference_backward<double>(field.config, parameters, samples,
                                                 {{batch.sigma.begin(), batch.sigma.end()},
                                                  {batch.red.begin(), batch.red.end()},
                                                  {batch.green.begin(), batch.green.end()},
                                                  {batch.blue.begin(), batch.blue.end()}});
  auto setup = set_up(device, field, batch, precision);
  if (!setup) return setup.error();
  if (auto done = inference(*setup); !done) return done.error();
  if (auto done = setup->on->backward(); !done) return done.error();
  const std::size_t n = batch.x.size();
  std::vector<float> sigma(n), colours(3 * n), gradients(field.parameters.size());
  for (const auto& [to, from] : {std::pair<std::vector<float>*, const float*>{&sigma, setup->on->sigma()},
                                 {&colours, setup->on->colours()},
                                 {&gradients, setup->on->gradients()}})
    if (auto done = device->copy_out(to->data(), from, to->size() * sizeof(float)); !done)
      return done.error();
  if (auto done = device->wait(); !done) return done.error();
  DeviceFieldError error{precision, relative_l2(sigma, truth.sigma), 0, 0};
  const std::vector<double>* rows[3] = {&truth.red, &truth.green, &truth.blue};
  for (std::size_t c = 0; c < 3; ++c)
    error.outputs = std::max(error.outputs, relative_l2(std::span(colours).subspan(c * n, n), *rows[c]));
  for (const ParameterBlock& block : parameter_layout(field.config)) {
    double& worst = block.table ? error.tables : error.networks;
    worst = std::max(worst, relative_l2(std::span(gradients).subspan(block.offset, block.count),
                                        std::span(slopes.parameters).subspan(block.offset, block.count)));
  }
  return error;
}

}  // namespace

Result<DeviceBenchReport> measure_device(std::shared_ptr<Device> device, const DeviceBenchOptions& options,
                                         const Progress& progress, std::stop_token stop) {
  DeviceBenchReport report;
  report.facts = device->facts();
  const auto ceilings = measure_ceilings(device, options);
  if (!ceilings) return ceilings.error();
  report.ceilings = *ceilings;
  std::vector<NetworkPrecision> precisions{NetworkPrecision::single};
  if (device->facts().matrix_units) precisions.insert(precisions.begin(), NetworkPrecision::bf16);
  const double parts = double(precisions.size() * (options.batches.size() + 1) + 2);
  double part = 0;
  for (const NetworkPrecision precision : precisions) {
    for (const std::size_t samples : options.batches) {
      if (stop.stop_requested()) return cancelled_error();
      progress.report(part++ / parts, "timing the field");
      auto speed = measure_batch(device, report.ceilings, samples, precision, options);
      if (!speed) return speed.error();
      report.speeds.push_back(*speed);
    }
    progress.report(part++ / parts, "comparing with double");
    auto error = measure_error(device, precision, options);
    if (!error) return error.error();
    report.errors.push_back(*error);
  }
  progress.report(part++ / parts, "timing pictures");
  auto frames = measure_frames(device, report.ceilings, options, stop);
  if (!frames) return frames.error();
  report.frames = std::move(*frames);
  progress.report(part / parts, "timing a training's steps");
  auto step = measure_step(device, report.ceilings, options, stop);
  if (!step) return step.error();
  report.step = *step;
  return report;
}

}  // namespace likeness
