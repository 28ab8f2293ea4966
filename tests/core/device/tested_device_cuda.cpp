// Tests of a device on the CUDA one.
#include "core/device/load_device.h"
#include "tests/core/device/emulated_device.h"

namespace likeness {

std::shared_ptr<Device> tested_device(std::string& why) {
  const auto device = open_cuda_device();
  if (device) return *device;
  why = device.error().what;
  return nullptr;
}

}  // namespace likeness
