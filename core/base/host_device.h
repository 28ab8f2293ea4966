// LIKENESS_HOST_DEVICE: marks functions that both the processor and a CUDA device run. Such headers are plain
// C++17 with pointers and sizes, so that nvcc and the compiler of everything else read the same text.
#pragma once

#ifdef __CUDACC__
#define LIKENESS_HOST_DEVICE __host__ __device__
#else
#define LIKENESS_HOST_DEVICE
#endif
