// The launchers of the kernels that measure a device (cuda_launch.h).
#pragma once

#include "core/device/cuda_launch.h"
#include "core/device/device_ceilings.h"

namespace likeness::cuda {

cudaError_t read_write(const Launch& launch, const CeilingArgs& args, std::size_t items);
cudaError_t matrix_rate(const Launch& launch, const CeilingArgs& args, std::size_t items);

}  // namespace likeness::cuda
