// A device that is the processor: the kernels' own arithmetic (core/field/*_math.h, core/render/device_*.h,
// core/train/device_rays.h) in plain loops, memory that can run out, and failures on request. What it cannot
// show is how threads share the work; that is what the tests labelled gpu are for.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "core/device/device.h"

namespace likeness {

struct EmulatedFaults {
  DeviceStatus open = DeviceStatus::ok;
  std::size_t memory_bytes = std::size_t{8} << 30;
  std::size_t shared_bytes = 227 * 1024;
  bool matrix_units = true;
  long lost_after = -1;  // launches until the device is lost; < 0: never
  // Blocks of the networks have four threads that wait for each other where a device's do, so that the thread
  // sanitizer finds races. Otherwise one thread does it all.
  bool threads = false;
};

struct EmulatedCounts {
  std::size_t launches = 0, waits = 0, replays = 0, bytes = 0, max_bytes = 0;
  std::size_t waits_while_recording = 0;
  std::size_t bytes_in = 0;  // copied from the host
};

// There is one at a time; a new one resets the counts.
const DeviceApi& emulated_api(const EmulatedFaults& faults = {});
EmulatedCounts emulated_counts();
std::shared_ptr<Device> emulated_device(const EmulatedFaults& faults = {});

// The device that a program tests: the emulated one, or with LIKENESS_TEST_DEVICE=cuda in the environment a
// GPU; null if there is none; `why` then gives the reason.
bool tests_cuda();
std::shared_ptr<Device> tested_device(std::string& why);

}  // namespace likeness
