// The figures of `likeness bench --backend cuda --json`, from a program small enough to be carried to a
// machine that has a GPU and nothing else.
#include <fmt/format.h>

#include "core/device/load_device.h"
#include "core/lab/bench/device_report.h"

int main() {
  using namespace likeness;
  auto device = open_cuda_device();
  if (!device) {
    fmt::print(stderr, "{}\n{}\n", device.error().what, device.error().fix);
    return 1;
  }
  const auto report = measure_device(*device, {}, Progress(), {});
  if (!report) {
    fmt::print(stderr, "{}\n{}\n", report.error().what, report.error().fix);
    return 1;
  }
  fmt::print("{}\n", to_json(*report).dump(2));
  return 0;
}
