// The launchers of the kernels that choose a training's rays and look cells up (core/device/cuda_launch.h).
#pragma once

#include "core/device/cuda_launch.h"
#include "core/train/device_rays.h"

namespace likeness::cuda {

cudaError_t choose_rays(const Launch& launch, const ChooseRaysArgs& args, std::size_t items);
cudaError_t march_chosen(const Launch& launch, const MarchChosenArgs& args, std::size_t items);
cudaError_t ordered_offsets(const Launch& launch, const OrderedOffsetsArgs& args, std::size_t items);
cudaError_t gather_chosen(const Launch& launch, const GatherChosenArgs& args, std::size_t items);
cudaError_t look_up_cells(const Launch& launch, const LookUpArgs& args, std::size_t items);
cudaError_t decay_cells(const Launch& launch, const DecayArgs& args, std::size_t items);
cudaError_t set_cell_bits(const Launch& launch, const CellBitsArgs& args, std::size_t items);
cudaError_t mark_bricks(const Launch& launch, const BricksArgs& args, std::size_t items);
cudaError_t bound_layers(const Launch& launch, const LayersArgs& args, std::size_t items);
cudaError_t bound_necks(const Launch& launch, const NeckBoxArgs& args, std::size_t items);
cudaError_t fill_necks(const Launch& launch, const FillNecksArgs& args, std::size_t items);

}  // namespace likeness::cuda
