// Compiled when configuring: whether nvcc and its host compiler support the language that the kernels are
// written in.
#include <cstddef>

template <class F>
__host__ __device__ void twice(const F& f) {
  f(0), f(1);
}

__host__ __device__ inline void fill(int* out) {
  twice([&](int i) { out[i] = i; });
}

__global__ void kernel(int* out) {
  if constexpr (sizeof(std::size_t) == 8) fill(out);
}
