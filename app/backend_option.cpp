// --backend: see backend_option.h.
#include "app/backend_option.h"

#include <fmt/format.h>

#include <cstdio>
#include <map>

#include "app/standard_streams.h"
#include "core/device/load_device.h"

namespace likeness::app {

void add_common_options_with_cuda(CLI::App& verb, CommonOptions& options) {
  add_common_options(verb, options);
  verb.remove_option(verb.get_option("--backend"));
  verb.add_option("--backend", options.backend,
                  "Where to compute: cpu, cuda (an NVIDIA GPU), or auto: the GPU if it can be used, "
                  "otherwise or if it fails the processor")
      ->check(CLI::IsMember({"cpu", "cuda", "auto"}));
}

void add_precision_option(CLI::App& verb, FieldPrecision& precision) {
  const std::map<std::string, FieldPrecision> names{{"single", FieldPrecision::exact},
                                                    {"bf16", FieldPrecision::bf16}};
  verb.add_option("--precision", precision,
                  "Numbers that training multiplies: bf16 (the default), if the processor or GPU can, or "
                  "single")
      ->transform(CLI::CheckedTransformer(names));
}

Result<ChosenBackend> chosen_backend(const CommonOptions& options, FieldPrecision precision) {
  ChosenBackend chosen;
  chosen.precision = precision;
  if (options.backend == "cpu") return chosen;
  chosen.fall_back = options.backend == "auto";
  auto device = open_cuda_device();
  if (device) {
    chosen.backend = device_backend(std::move(*device), precision == FieldPrecision::bf16);
  } else if (!chosen.fall_back) {
    return device.error();
  }
  return chosen;
}

Result<RenderPlace> chosen_place(const CommonOptions& options) {
  auto chosen = chosen_backend(options, FieldPrecision::bf16);
  if (!chosen) return chosen.error();
  return RenderPlace{std::move(chosen->backend), chosen->fall_back, [](const std::string& text) {
                       clear_line();
                       tell("note: {}\n", text);
                     }};
}

}  // namespace likeness::app
