// What the program needs of a compute device, as a table of C functions. The CUDA module (core/cuda) fills
// one in and is loaded at run time, so that the program starts without a driver; tests fill in their own.
// Plain C++17: nvcc reads this too.
//
// A context belongs to one thread at a time. Copies, clears and launches are queued and run in order; `wait`
// waits for all of them. Errors in queued work are reported by a later call, `wait` at the latest.
#pragma once

#include <cstddef>
#include <cstdint>

namespace likeness {

enum class DeviceStatus : std::int32_t {
  ok = 0,
  no_driver,        // there is no driver, or it does not respond
  driver_too_old,   // older than the module's toolkit needs
  no_device,        // a driver, but no device
  device_too_old,   // the module has no code for this device
  out_of_memory,    // the allocation did not fit
  too_large,        // a kernel needs more resources than a multiprocessor has
  lost,             // the device no longer responds, or a kernel crashed it
  unknown_request,  // module and program differ in version
  failed
};

struct DeviceFacts {
  char name[128];
  std::int32_t major, minor;     // compute capability
  std::int32_t driver, toolkit;  // 1000 * major + 10 * minor
  std::int32_t multiprocessors;
  std::int32_t matrix_units;  // 1: bfloat16 matrix products (compute capability 8.0)
  std::uint64_t memory_bytes, free_bytes;
  std::uint64_t shared_bytes;  // a block can have at most
};

// Raised whenever the table or an argument of a kernel changes.
constexpr std::uint32_t kDeviceApiVersion = 5;

struct DeviceApi {
  std::uint32_t version;
  // `context` is null unless the status is ok; `facts` holds whatever could be determined.
  DeviceStatus (*open)(void** context, DeviceFacts* facts);
  void (*close)(void* context);
  DeviceStatus (*allocate)(void* context, std::size_t bytes, void** memory);
  void (*release)(void* context, void* memory);
  // The host's memory must stay as it is until the next `wait`.
  DeviceStatus (*copy_in)(void* context, void* to, const void* from, std::size_t bytes);
  DeviceStatus (*copy_out)(void* context, void* to, const void* from, std::size_t bytes);
  DeviceStatus (*clear)(void* context, void* memory, std::size_t bytes);
  // One kernel (kernel_ids.h) over `items` items at most; `args` is copied.
  DeviceStatus (*launch)(void* context, std::int32_t kernel, const void* args, std::size_t bytes,
                         std::size_t items);
  // Between `record` and `end_record` launches and clears are kept instead of run; `replay` queues them all.
  DeviceStatus (*record)(void* context);
  DeviceStatus (*end_record)(void* context, void** recording);
  DeviceStatus (*replay)(void* context, void* recording);
  void (*forget)(void* context, void* recording);
  DeviceStatus (*wait)(void* context);
  // Clocks of the device: `mark` notes the time when the work queued so far is done, under a number in [0,
  // 8).
  DeviceStatus (*mark)(void* context, std::int32_t number);
  DeviceStatus (*between)(void* context, std::int32_t first, std::int32_t second, double* seconds);
  // The driver's message for the last status that was not ok.
  const char* (*last_message)(void* context);
};

// The one name a module exports.
constexpr const char* kDeviceApiSymbol = "likeness_device_api";
using DeviceApiFunction = const DeviceApi* (*)(std::uint32_t version);  // null: another version

}  // namespace likeness
