// Finding and opening the CUDA device, and why there is none.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/device/device.h"

namespace likeness {

inline constexpr const char* kCudaModuleName = "liblikeness_cuda.so";

// How libraries are found and loaded; tests substitute their own.
struct ModuleLoader {
  std::vector<std::filesystem::path> places;  // of the module, in order
  std::function<bool(const std::filesystem::path&)> exists;
  std::function<bool()> has_driver;  // libcuda.so.1 can be loaded
  // The module's table, or null and why not. The library stays loaded.
  std::function<const DeviceApi*(const std::filesystem::path&, std::string& why)> load;
};
// Beside the program and in ../lib/likeness; with the variable LIKENESS_CUDA_MODULE, that file only.
ModuleLoader system_loader();

// The error says which of these it is: no module built, no driver, driver too old, no device, no memory.
Result<std::shared_ptr<Device>> open_cuda_device(const ModuleLoader& loader = system_loader());

}  // namespace likeness
