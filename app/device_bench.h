// likeness bench --backend cuda.
#pragma once

#include "app/terminal.h"
#include "core/bench/device_speed.h"

namespace likeness::app {

// Measures and prints; the exit code.
int run_device_bench(const CommonOptions& common, const DeviceBenchOptions& options);

}  // namespace likeness::app
