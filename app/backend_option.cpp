// --backend: see backend_option.h.
#include "app/backend_option.h"

#include "core/device/load_device.h"

namespace likeness::app {

void add_common_options_with_cuda(CLI::App& verb, CommonOptions& options) {
  add_common_options(verb, options);
  verb.remove_option(verb.get_option("--backend"));
  verb.add_option(
          "--backend", options.backend,
          "Where to compute: cpu, cuda (an NVIDIA GPU), or auto: the GPU where it can be used, and the "
          "processor where it cannot or fails")
      ->check(CLI::IsMember({"cpu", "cuda", "auto"}));
}

Result<ChosenBackend> chosen_backend(const CommonOptions& options) {
  ChosenBackend chosen;
  if (options.backend == "cpu") return chosen;
  chosen.fall_back = options.backend == "auto";
  auto device = open_cuda_device();
  if (device) {
    chosen.backend = device_backend(std::move(*device));
  } else if (!chosen.fall_back) {
    return device.error();
  }
  return chosen;
}

}  // namespace likeness::app
