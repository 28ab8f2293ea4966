// Where a kernel of the CUDA module is queued. Each room declares the launchers of its own kernels in its
// cuda_launchers.h, each of which queues its kernel over at most `items` items and returns the runtime's
// status of the launch; core/cuda puts them into the module's table. Plain C++17.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>

#include "core/device/device_api.h"

namespace likeness::cuda {

struct Launch {
  cudaStream_t stream;
  const DeviceFacts& facts;
};

// Number of blocks of `threads` for that many items.
inline unsigned blocks_of(std::size_t items, unsigned threads) {
  return unsigned((items + threads - 1) / threads);
}

}  // namespace likeness::cuda
