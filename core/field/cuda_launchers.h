// The launchers of the field's kernels (core/device/cuda_launch.h).
#pragma once

#include "core/device/cuda_launch.h"
#include "core/field/device_kernels.h"

namespace likeness::cuda {

cudaError_t encode(const Launch& launch, const EncodeArgs& args, std::size_t items);
cudaError_t encode_backward(const Launch& launch, const EncodeBackwardArgs& args, std::size_t items);
cudaError_t network_forward(const Launch& launch, const NetworkArgs& args, std::size_t items);
cudaError_t network_backward(const Launch& launch, const NetworkArgs& args, std::size_t items);
cudaError_t adam_lines(const Launch& launch, const AdamLinesArgs& args, std::size_t items);
cudaError_t adam_networks(const Launch& launch, const AdamNetworksArgs& args, std::size_t items);
cudaError_t adam_codes(const Launch& launch, const AdamCodesArgs& args, std::size_t items);

// A network on the matrix units; `taken`: false if they do not support it, and nothing was queued.
cudaError_t matrix_network(const Launch& launch, const NetworkArgs& args, std::size_t items, bool backward,
                           bool& taken);

// Whether the module has code for the device.
cudaError_t has_code();

}  // namespace likeness::cuda
