// Kernels that reach the peak rates of a device: see device_ceilings.h.
#include "core/device/device_ceilings.h"

#include <cuda_bf16.h>
#include <mma.h>

#include "core/device/cuda_launchers.h"

namespace likeness::cuda {
namespace {

constexpr unsigned kThreads = 256;

__global__ void __launch_bounds__(kThreads) read_write_kernel(CeilingArgs args, std::size_t items) {
  const std::size_t i = std::size_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i >= items) return;
  float4 v = reinterpret_cast<const float4*>(args.in)[i];
  v.x += 1, v.y += 1, v.z += 1, v.w += 1;
  reinterpret_cast<float4*>(args.out)[i] = v;
}

__global__ void __launch_bounds__(kThreads) matrix_rate_kernel(CeilingArgs args, std::size_t items) {
#if __CUDA_ARCH__ >= 800
  namespace wmma = nvcuda::wmma;
  const std::size_t item = (std::size_t(blockIdx.x) * kThreads + threadIdx.x) / 32;
  if (item >= items) return;
  wmma::fragment<wmma::matrix_a, 16, 16, 16, __nv_bfloat16, wmma::row_major> a;
  wmma::fragment<wmma::matrix_b, 16, 16, 16, __nv_bfloat16, wmma::col_major> b;
  wmma::fragment<wmma::accumulator, 16, 16, 16, float> sum[kMatrixChains];
  wmma::fill_fragment(a, __nv_bfloat16(0.5f));
  wmma::fill_fragment(b, __nv_bfloat16(0.25f));
  for (auto& s : sum) wmma::fill_fragment(s, 0.0f);
  for (int k = 0; k < args.repeats; ++k)
#pragma unroll
    for (auto& s : sum) wmma::mma_sync(s, a, b, s);
  float total = 0;
  for (auto& s : sum)
    for (int e = 0; e < s.num_elements; ++e) total += s.x[e];
  if (threadIdx.x % 32 == 0) args.out[item] = total;
#endif
}

}  // namespace

cudaError_t read_write(const Launch& launch, const CeilingArgs& args, std::size_t items) {
  read_write_kernel<<<blocks_of(items, kThreads), kThreads, 0, launch.stream>>>(args, items);
  return cudaGetLastError();
}

cudaError_t matrix_rate(const Launch& launch, const CeilingArgs& args, std::size_t items) {
  matrix_rate_kernel<<<blocks_of(32 * items, kThreads), kThreads, 0, launch.stream>>>(args, items);
  return cudaGetLastError();
}

}  // namespace likeness::cuda
