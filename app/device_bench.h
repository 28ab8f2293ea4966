// likeness bench --backend cuda.
#pragma once

#include "app/tables.h"
#include "app/terminal.h"
#include "core/lab/bench/device_speed.h"
#include "core/project/project.h"

namespace likeness::app {

// Measures and prints; of a project, if there is one, also its pictures and its training. The exit code.
int run_device_bench(const CommonOptions& common, const TableOptions& output,
                     const DeviceBenchOptions& options, const Project* project);

}  // namespace likeness::app
