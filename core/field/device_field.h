// A field on a device: its parameters, a batch of samples, and the kernels over them, in the order of a pass.
// Queues work; waits for nothing.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/base/result.h"
#include "core/device/device.h"
#include "core/field/adam.h"
#include "core/field/device_kernels.h"
#include "core/field/field.h"

namespace likeness {

struct DeviceFieldOptions {
  std::size_t capacity = 131072;  // samples of a batch, at most
  std::size_t views = 1;          // rows of conditions and codes; with one, the samples need no view
  bool training = false;
  // Of the density and colour networks: single or bf16, which needs a device with matrix units. w and its
  // network are kept near single precision (then split), since ambient levels turn a small error of w into a
  // large one of a.
  NetworkPrecision precision = NetworkPrecision::bf16;
};

// Device memory of a field, bytes.
std::size_t device_field_bytes(const FieldConfig& config, const DeviceFieldOptions& options,
                               const DeviceFacts& facts);

// Chooses the number of samples per block of threads, and where it sums its gradients: the largest choice
// that fits. False if none does.
bool fit_network(NetworkArgs& args, std::size_t shared_bytes, bool backward);

class DeviceField {
 public:
  // Errors: out of memory; networks too wide for the device.
  static Result<std::unique_ptr<DeviceField>> make(std::shared_ptr<Device> device, const FieldConfig& config,
                                                   const DeviceFieldOptions& options);
  ~DeviceField();

  // -- The host's copies, with the moments if given. They must stay as they are until the device has been
  // waited for.
  Result<void> place(const Field& field, const AdamState* adam);
  Result<void> fetch(Field& field, AdamState* adam) const;

  // -- A batch. Counts go to `count`, a number in the device's memory that all kernels read.
  Result<void> set_samples(
      const FieldInputs& inputs);  // positions, directions, views; codes are set separately
  Result<void> set_conditions(const float* conditions, std::size_t rows);
  Result<void> set_codes(const float* codes, std::size_t rows);  // null: zeros from now on
  Result<void> set_count(std::uint32_t count);

  // -- Passes over the batch.
  Result<void> density();                  // sigma and geometry features
  Result<void> density(std::size_t most);  // if the batch is known to hold no more samples than that
  Result<void> colour();                   // after density
  Result<void> backward();                 // from d_sigma and d_colour; adds to the gradients
  Result<void> step_tables(const StepNumbers* numbers, const StepSums* sums);
  Result<void> step_networks(const StepNumbers* numbers, const StepSums* sums, int index);

  // -- Addresses in the device's memory.
  float* point(int k) const;   // (capacity) a coordinate of the samples' positions, from 3 on of directions
  std::int32_t* rows() const;  // (capacity) of conditions and codes, of a field with several
  float* sigma() const;        // (capacity)
  float* colours() const;      // (3, capacity)
  float *d_sigma() const, *d_colours() const;
  float *codes() const, *d_codes() const;  // (views, L), or null without latents
  std::uint32_t* count() const;
  float* gradients() const;  // of the parameters
  std::size_t capacity() const;

 private:
  struct Impl;
  explicit DeviceField(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
  std::uint32_t host_count_ = 0;  // what set_count copies from
};

// Factor on the learning rate of Adam's n-th step, for both moments' bias; [0] is not used.
std::vector<float> adam_corrections(const AdamOptions& options, std::size_t count);

}  // namespace likeness
