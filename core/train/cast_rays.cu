// A training's rays and cell look-ups on a CUDA device: a thread per ray, sample, cell, brick or view.
#include "core/train/cuda_launchers.h"

namespace likeness::cuda {
namespace {

constexpr unsigned kThreads = 128;
// Walks differ in length, and there are few: only every fourth thread of a warp has one, so that they wait
// less for each other and for memory.
constexpr unsigned kWalkThreads = 64, kThreadsPerWalk = 4;

__device__ std::size_t item_of_thread() { return std::size_t(blockIdx.x) * blockDim.x + threadIdx.x; }

// choose_ray by kTries threads, which make the tries in turn; the one with the first successful try
// continues.
static_assert(32 % kTries == 0 && kTries < 32 && kMaskedTries % kTries == 0 && kWalkThreads % 32 == 0);
__global__ void __launch_bounds__(kWalkThreads, 8)
    choose_kernel(const __grid_constant__ ChooseRaysArgs args) {
  const std::size_t item = item_of_thread(), r = item / kTries;
  if (r >= args.rays.rays) return;  // all of a ray's threads
  const int own = int(item % kTries), first = int(threadIdx.x % 32) - own;
  const unsigned mates = ((1u << kTries) - 1u) << first;
  DeviceViews views(args);
  const ChoiceNumbers numbers = numbers_of_step(args);
  const RayDraw draw = begin_choice(views, numbers, r);
  RandomStream random = draw.random;
  random.skip(std::uint64_t(own * kDrawsOfTry));
  for (int attempt = own;; attempt += kTries) {
    PixelPlace pixel;
    const bool met = try_pixel(views, draw, attempt, random, pixel);
    const unsigned found = __ballot_sync(mates, met) >> first;
    const bool over = attempt - own + kTries >= draw.tries;
    if (found == 0 && !over) {
      random.skip(std::uint64_t((kTries - 1) * kDrawsOfTry));
      continue;
    }
    const int last = found != 0 ? __ffs(int(found)) - 1 : kTries - 1;
    if (own == last) set_chosen(args, r, views, end_choice(views, numbers, draw.view, pixel, random));
    return;
  }
}

__global__ void __launch_bounds__(kWalkThreads) march_kernel(const __grid_constant__ MarchChosenArgs args) {
  const std::size_t item = item_of_thread(), lane = item / kThreadsPerWalk;
  if (item % kThreadsPerWalk == 0 && lane < args.lists.lanes) likeness::march_chosen(args, lane);
}

struct Threads {
  __device__ std::uint32_t index() const { return blockIdx.x; }
  template <class F>
  __device__ void for_each(int count, const F& f) const {
    for (int i = int(threadIdx.x); i < count; i += int(blockDim.x)) f(i);
    __syncthreads();
  }
};

__global__ void __launch_bounds__(kScanRays) offsets_kernel(const __grid_constant__ OrderedOffsetsArgs args) {
  __shared__ std::uint32_t shared[8 * kScanRays];
  Threads block;
  likeness::ordered_offsets(block, args, shared);
}

__global__ void __launch_bounds__(kThreads) gather_kernel(const __grid_constant__ GatherChosenArgs args) {
  const std::size_t item = item_of_thread();
  if (item < std::size_t(args.placed.rays) * std::size_t(args.placed.most))
    likeness::gather_chosen(args, item);
}

__global__ void __launch_bounds__(kThreads) look_kernel(const __grid_constant__ LookUpArgs args) {
  if (const std::size_t i = item_of_thread(); i < args.count) look_up_cell(args, i);
}

__global__ void __launch_bounds__(kThreads) decay_kernel(const __grid_constant__ DecayArgs args) {
  if (const std::size_t i = item_of_thread(); i < args.count) decay_cell(args, i);
}

__global__ void __launch_bounds__(kThreads)
    bits_kernel(const __grid_constant__ CellBitsArgs args, std::size_t items) {
  if (const std::size_t byte = item_of_thread(); byte < items) likeness::set_cell_bits(args, byte);
}

__global__ void __launch_bounds__(kThreads)
    bricks_kernel(const __grid_constant__ BricksArgs args, std::size_t items) {
  if (const std::size_t i = item_of_thread(); i < items) mark_brick(args, i);
}

__global__ void __launch_bounds__(kThreads)
    layers_kernel(const __grid_constant__ LayersArgs args, std::size_t items) {
  if (const std::size_t y = item_of_thread(); y < items) bound_layer(args, y);
}

__global__ void __launch_bounds__(kThreads) necks_kernel(const __grid_constant__ NeckBoxArgs args) {
  if (const std::size_t v = item_of_thread(); v < args.views.count) bound_neck_of_view(args, v);
}

__global__ void __launch_bounds__(kThreads) fill_kernel(const __grid_constant__ FillNecksArgs args) {
  const FrameNumbers& frame = frame_of(args.views, blockIdx.y);
  if (!neck_cells_of(args.views, blockIdx.y, frame)) return;
  const std::size_t count = neck_cell_count(frame);
  for (std::size_t i = item_of_thread(); i < count; i += std::size_t(gridDim.x) * blockDim.x)
    fill_neck(args, blockIdx.y, i);
}

template <class... Args>
cudaError_t queue(const Launch& launch, void (*kernel)(Args...), unsigned threads, std::size_t items,
                  const Args&... args) {
  kernel<<<blocks_of(items, threads), threads, 0, launch.stream>>>(args...);
  return cudaGetLastError();
}

}  // namespace

cudaError_t choose_rays(const Launch& launch, const ChooseRaysArgs& args, std::size_t items) {
  return queue(launch, choose_kernel, kWalkThreads, items * kTries, args);
}

cudaError_t march_chosen(const Launch& launch, const MarchChosenArgs& args, std::size_t items) {
  return queue(launch, march_kernel, kWalkThreads, items * kThreadsPerWalk, args);
}

cudaError_t ordered_offsets(const Launch& launch, const OrderedOffsetsArgs& args, std::size_t items) {
  return queue(launch, offsets_kernel, kScanRays, items, args);
}

cudaError_t gather_chosen(const Launch& launch, const GatherChosenArgs& args, std::size_t items) {
  return queue(launch, gather_kernel, kThreads, items, args);
}

cudaError_t look_up_cells(const Launch& launch, const LookUpArgs& args, std::size_t items) {
  return queue(launch, look_kernel, kThreads, items, args);
}

cudaError_t decay_cells(const Launch& launch, const DecayArgs& args, std::size_t items) {
  return queue(launch, decay_kernel, kThreads, items, args);
}

cudaError_t set_cell_bits(const Launch& launch, const CellBitsArgs& args, std::size_t items) {
  return queue(launch, bits_kernel, kThreads, items, args, items);
}

cudaError_t mark_bricks(const Launch& launch, const BricksArgs& args, std::size_t items) {
  return queue(launch, bricks_kernel, kThreads, items, args, items);
}

cudaError_t bound_layers(const Launch& launch, const LayersArgs& args, std::size_t items) {
  return queue(launch, layers_kernel, kThreads, items, args, items);
}

cudaError_t bound_necks(const Launch& launch, const NeckBoxArgs& args, std::size_t items) {
  return queue(launch, necks_kernel, kThreads, items, args);
}

cudaError_t fill_necks(const Launch& launch, const FillNecksArgs& args, std::size_t) {
  constexpr unsigned kBlocksOfView = 64;
  fill_kernel<<<dim3(kBlocksOfView, args.views.count), kThreads, 0, launch.stream>>>(args);
  return cudaGetLastError();
}

}  // namespace likeness::cuda
