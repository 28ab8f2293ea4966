// Loading the CUDA module: see load_device.h.
#include "core/device/load_device.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "core/base/program_files.h"

namespace likeness {
namespace {

const DeviceApi* load_module(const std::filesystem::path& path, std::string& why) {
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    const char* said = ::dlerror();
    why = said ? said : "it cannot be loaded";
    return nullptr;
  }
  const auto function = reinterpret_cast<DeviceApiFunction>(::dlsym(library, kDeviceApiSymbol));
  const DeviceApi* api = function ? function(kDeviceApiVersion) : nullptr;
  if (!api) why = "its version differs from this program's";
  return api;
}

bool load_driver() {
  void* library = ::dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library) ::dlclose(library);
  return library != nullptr;
}

}  // namespace

ModuleLoader system_loader() {
  ModuleLoader loader;
  if (const char* given = std::getenv("LIKENESS_CUDA_MODULE")) {
    loader.places = {given};
  } else {
    const std::filesystem::path program = program_file();
    if (!program.empty())
      loader.places = {program.parent_path() / kCudaModuleName,
                       program.parent_path().parent_path() / "lib" / "likeness" / kCudaModuleName};
  }
  loader.exists = [](const std::filesystem::path& path) {
    std::error_code failed;
    return std::filesystem::exists(path, failed);
  };
  loader.has_driver = load_driver;
  loader.load = load_module;
  return loader;
}

Result<std::shared_ptr<Device>> open_cuda_device(const ModuleLoader& loader) {
  const auto place = std::find_if(loader.places.begin(), loader.places.end(), loader.exists);
  if (place == loader.places.end())
    return Error{ErrorCode::missing_dependency,
                 fmt::format("This build computes on the processor: there is no {}.", kCudaModuleName),
                 "For an NVIDIA GPU, build with -DLIKENESS_CUDA=ON where CUDA's nvcc is installed.", "CUDA"};
  if (!loader.has_driver()) return device_error(DeviceStatus::no_driver, {}, "", "");
  std::string why;
  const DeviceApi* api = loader.load(*place, why);
  if (!api)
    return Error{ErrorCode::missing_dependency, fmt::format("The CUDA module cannot be used: {}.", why),
                 "Install the program and its module from one build.", place->string()};
  return Device::open(*api);
}

}  // namespace likeness
