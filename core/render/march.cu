// From pixels to samples on a CUDA device: a thread a ray, or a sample.
#include "core/render/cuda_launchers.h"
#include "core/render/device_picture.h"

namespace likeness::cuda {
namespace {

constexpr unsigned kThreads = 128;
// Walks differ in length, and there are few: only every fourth thread of a warp has one, so that they wait
// less for each other and for memory.
constexpr unsigned kThreadsPerWalk = 4;

__device__ std::size_t item_of_thread() { return std::size_t(blockIdx.x) * blockDim.x + threadIdx.x; }

// The number in this frame is known only to the device.
__global__ void __launch_bounds__(kThreads) neck_kernel(const __grid_constant__ NeckCellsArgs args) {
  if (!args.scene.frame->neck.bends) return;
  const std::size_t count = neck_cell_count(*args.scene.frame), all = std::size_t(gridDim.x) * blockDim.x;
  for (std::size_t i = item_of_thread(); i < count; i += all) fill_neck_cell(args, i);
}

__global__ void __launch_bounds__(kThreads) strata_kernel(const __grid_constant__ MarchStrataArgs args) {
  const std::size_t item = item_of_thread(), r = item / kThreadsPerWalk;
  if (item % kThreadsPerWalk == 0 && r < args.out.rays) likeness::march_strata(args, r);
}

__global__ void __launch_bounds__(kThreads) rays_kernel(const __grid_constant__ MarchRaysArgs args) {
  const std::size_t item = item_of_thread(), lane = item / kThreadsPerWalk;
  if (item % kThreadsPerWalk == 0 && lane < args.lists.lanes) likeness::march_rays(args, lane);
}

struct Threads {
  __device__ std::uint32_t index() const { return blockIdx.x; }
  template <class F>
  __device__ void for_each(int count, const F& f) const {
    for (int i = int(threadIdx.x); i < count; i += int(blockDim.x)) f(i);
    __syncthreads();
  }
};

__global__ void __launch_bounds__(kScanRays) offsets_kernel(const __grid_constant__ RayOffsetsArgs args) {
  __shared__ std::uint32_t shared[7 * kScanRays];
  Threads block;
  likeness::ray_offsets(block, args, shared);
}

__global__ void __launch_bounds__(kThreads) gather_kernel(const __grid_constant__ GatherArgs args) {
  const std::size_t item = item_of_thread();
  if (item < std::size_t(args.rays.rays) * std::size_t(args.rays.most)) likeness::gather_sample(args, item);
}

__global__ void __launch_bounds__(kThreads) refine_kernel(const __grid_constant__ RefineArgs args) {
  if (const std::size_t r = item_of_thread(); r < args.strata.rays) likeness::refine_strata(args, r);
}

__global__ void __launch_bounds__(kThreads) pick_kernel(const __grid_constant__ PickArgs args) {
  if (const std::size_t pixel = item_of_thread(); pixel < args.out.rays) likeness::pick_samples(args, pixel);
}

__global__ void __launch_bounds__(kThreads) composite_kernel(const __grid_constant__ CompositeArgs args) {
  if (const std::size_t pixel = item_of_thread(); pixel < args.rays.rays)
    likeness::composite_pixel(args, pixel);
}

template <class Args>
cudaError_t queue(const Launch& launch, void (*kernel)(Args), const Args& args, std::size_t items) {
  kernel<<<blocks_of(items, kThreads), kThreads, 0, launch.stream>>>(args);
  return cudaGetLastError();
}

}  // namespace

cudaError_t neck_cells(const Launch& launch, const NeckCellsArgs& args, std::size_t items) {
  constexpr std::size_t kAtOnce = 65536;
  return queue(launch, neck_kernel, args, items < kAtOnce ? items : kAtOnce);
}

cudaError_t march_strata(const Launch& launch, const MarchStrataArgs& args, std::size_t items) {
  return queue(launch, strata_kernel, args, items * kThreadsPerWalk);
}

cudaError_t march_rays(const Launch& launch, const MarchRaysArgs& args, std::size_t items) {
  return queue(launch, rays_kernel, args, items * kThreadsPerWalk);
}

cudaError_t ray_offsets(const Launch& launch, const RayOffsetsArgs& args, std::size_t items) {
  offsets_kernel<<<blocks_of(items, kScanRays), kScanRays, 0, launch.stream>>>(args);
  return cudaGetLastError();
}

cudaError_t gather_samples(const Launch& launch, const GatherArgs& args, std::size_t items) {
  return queue(launch, gather_kernel, args, items);
}

cudaError_t refine_strata(const Launch& launch, const RefineArgs& args, std::size_t items) {
  return queue(launch, refine_kernel, args, items);
}

cudaError_t pick_samples(const Launch& launch, const PickArgs& args, std::size_t items) {
  return queue(launch, pick_kernel, args, items);
}

cudaError_t composite_pixels(const Launch& launch, const CompositeArgs& args, std::size_t items) {
  return queue(launch, composite_kernel, args, items);
}

}  // namespace likeness::cuda
