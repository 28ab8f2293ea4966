// The launchers of the kernels that make pictures, and of the rays' loss (core/device/cuda_launch.h).
#pragma once

#include "core/device/cuda_launch.h"
#include "core/render/device_loss.h"
#include "core/render/device_march.h"

namespace likeness::cuda {

cudaError_t ray_loss(const Launch& launch, const RayLossArgs& args, std::size_t items);
cudaError_t neck_cells(const Launch& launch, const NeckCellsArgs& args, std::size_t items);
cudaError_t march_strata(const Launch& launch, const MarchStrataArgs& args, std::size_t items);
cudaError_t march_rays(const Launch& launch, const MarchRaysArgs& args, std::size_t items);
cudaError_t ray_offsets(const Launch& launch, const RayOffsetsArgs& args, std::size_t items);
cudaError_t gather_samples(const Launch& launch, const GatherArgs& args, std::size_t items);
cudaError_t refine_strata(const Launch& launch, const RefineArgs& args, std::size_t items);
cudaError_t pick_samples(const Launch& launch, const PickArgs& args, std::size_t items);
cudaError_t composite_pixels(const Launch& launch, const CompositeArgs& args, std::size_t items);

}  // namespace likeness::cuda
