// The rays' loss and its gradients on a CUDA device: a thread per ray, a sum per warp.
#include "core/render/cuda_launchers.h"

namespace likeness::cuda {
namespace {

constexpr unsigned kThreads = 32;  // there are few rays, and each is slow

__global__ void __launch_bounds__(kThreads) loss_kernel(RayLossArgs args) {
  const std::uint32_t ray = blockIdx.x * kThreads + threadIdx.x;
  double error = ray < args.numbers->rays ? likeness::ray_loss(args, ray) : 0.0;
  for (int step = 16; step > 0; step /= 2) error += __shfl_down_sync(0xffffffffu, error, unsigned(step));
  if (threadIdx.x % 32 == 0) atomicAdd(&args.sums->error, error);
}

}  // namespace

cudaError_t ray_loss(const Launch& launch, const RayLossArgs& args, std::size_t items) {
  loss_kernel<<<blocks_of(items, kThreads), kThreads, 0, launch.stream>>>(args);
  return cudaGetLastError();
}

}  // namespace likeness::cuda
