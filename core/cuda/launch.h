// What the module's parts share: where kernels are queued, and the launcher of each. Plain C++17.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>

#include "core/bench/device_ceilings.h"
#include "core/device/device_api.h"
#include "core/field/device_kernels.h"
#include "core/render/device_loss.h"
#include "core/render/device_march.h"
#include "core/train/device_rays.h"

namespace likeness::cuda {

struct Launch {
  cudaStream_t stream;
  const DeviceFacts& facts;
};

// Blocks of `threads` for that many items.
inline unsigned blocks_of(std::size_t items, unsigned threads) {
  return unsigned((items + threads - 1) / threads);
}

// Each queues its kernel over at most `items` items and returns what the runtime says of the launch.
cudaError_t encode(const Launch& launch, const EncodeArgs& args, std::size_t items);
cudaError_t encode_backward(const Launch& launch, const EncodeBackwardArgs& args, std::size_t items);
cudaError_t network_forward(const Launch& launch, const NetworkArgs& args, std::size_t items);
cudaError_t network_backward(const Launch& launch, const NetworkArgs& args, std::size_t items);
cudaError_t adam_lines(const Launch& launch, const AdamLinesArgs& args, std::size_t items);
cudaError_t adam_networks(const Launch& launch, const AdamNetworksArgs& args, std::size_t items);
cudaError_t adam_codes(const Launch& launch, const AdamCodesArgs& args, std::size_t items);
cudaError_t ray_loss(const Launch& launch, const RayLossArgs& args, std::size_t items);
cudaError_t neck_cells(const Launch& launch, const NeckCellsArgs& args, std::size_t items);
cudaError_t march_strata(const Launch& launch, const MarchStrataArgs& args, std::size_t items);
cudaError_t march_rays(const Launch& launch, const MarchRaysArgs& args, std::size_t items);
cudaError_t ray_offsets(const Launch& launch, const RayOffsetsArgs& args, std::size_t items);
cudaError_t gather_samples(const Launch& launch, const GatherArgs& args, std::size_t items);
cudaError_t refine_strata(const Launch& launch, const RefineArgs& args, std::size_t items);
cudaError_t pick_samples(const Launch& launch, const PickArgs& args, std::size_t items);
cudaError_t composite_pixels(const Launch& launch, const CompositeArgs& args, std::size_t items);
cudaError_t choose_rays(const Launch& launch, const ChooseRaysArgs& args, std::size_t items);
cudaError_t march_chosen(const Launch& launch, const MarchChosenArgs& args, std::size_t items);
cudaError_t ordered_offsets(const Launch& launch, const OrderedOffsetsArgs& args, std::size_t items);
cudaError_t gather_chosen(const Launch& launch, const GatherChosenArgs& args, std::size_t items);
cudaError_t look_into_cells(const Launch& launch, const LookArgs& args, std::size_t items);
cudaError_t decay_cells(const Launch& launch, const DecayArgs& args, std::size_t items);
cudaError_t set_cell_bits(const Launch& launch, const CellBitsArgs& args, std::size_t items);
cudaError_t mark_bricks(const Launch& launch, const BricksArgs& args, std::size_t items);
cudaError_t bound_layers(const Launch& launch, const LayersArgs& args, std::size_t items);
cudaError_t bound_necks(const Launch& launch, const NeckBoxArgs& args, std::size_t items);
cudaError_t fill_necks(const Launch& launch, const FillNecksArgs& args, std::size_t items);
cudaError_t read_write(const Launch& launch, const CeilingArgs& args, std::size_t items);
cudaError_t matrix_rate(const Launch& launch, const CeilingArgs& args, std::size_t items);

// A network on the matrix units; `taken`: false where they do not cover it, and nothing was queued.
cudaError_t matrix_network(const Launch& launch, const NetworkArgs& args, std::size_t items, bool backward,
                           bool& taken);

// Whether the module holds code for the device.
cudaError_t has_code();

}  // namespace likeness::cuda
