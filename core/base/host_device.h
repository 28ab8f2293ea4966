// LIKENESS_HOST_DEVICE: before functions that the processor and a CUDA device both run. Such headers are
// plain C++17 with pointers and sizes, so that nvcc and the compiler of the rest read the same text.
#pragma once

#ifdef __CUDACC__
#define LIKENESS_HOST_DEVICE __host__ __device__
#else
#define LIKENESS_HOST_DEVICE
#endif
