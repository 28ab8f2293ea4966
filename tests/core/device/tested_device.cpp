// The device that a program tests.
#include <cstdlib>
#include <string_view>

#include "core/device/load_device.h"
#include "tests/core/device/emulated_device.h"

namespace likeness {

bool tests_cuda() {
  const char* asked = std::getenv("LIKENESS_TEST_DEVICE");
  return asked != nullptr && std::string_view(asked) == "cuda";
}

std::shared_ptr<Device> tested_device(std::string& why) {
  if (!tests_cuda()) return emulated_device();
  const auto device = open_cuda_device();
  if (device) return *device;
  why = device.error().what;
  return nullptr;
}

}  // namespace likeness
