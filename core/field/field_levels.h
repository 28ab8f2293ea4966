// Levels, layers and constants that every implementation of the field shares. Plain C++17: the CUDA kernels
// read it too.
#pragma once

#include <cstddef>
#include <cstdint>

namespace likeness {

// One level of a grid. `resolution` cells along an axis, resolution + 1 vertices. A level whose vertices fit
// the table is dense (x fastest), otherwise a vertex's entry is its spatial hash.
struct GridLevel {
  int resolution = 0;
  bool hashed = false;
  std::uint32_t mask = 0;     // entries - 1 when hashed
  std::uint32_t stride[3]{};  // of a dense level, entries
  std::size_t offset = 0;     // of the first parameter
  std::size_t entries = 0;
};

// out = W in + b, W row-major (outputs, inputs).
struct DenseLayer {
  int inputs = 0, outputs = 0;
  std::size_t weights = 0, biases = 0;  // offsets into the parameters
};

// Primes of the spatial hash of Teschner et al. 2003 as used by Mueller et al. 2022; 1 keeps neighbours in x
// in one cache line.
constexpr std::uint32_t kHashPrimeY = 2654435761u, kHashPrimeZ = 805459861u;
constexpr std::uint32_t kHashPrime[3] = {1u, kHashPrimeY, kHashPrimeZ};

// Sparse gradients and Adam move this many table parameters (64 bytes) at a time.
constexpr std::size_t kTableLine = 16;

// Density: exp(r) to r = kDensityKnee, then its tangent.
constexpr float kDensityKnee = 9.0f;

// Real spherical harmonics of degree <= 2 have 9 functions; these are the constants of the polynomials.
constexpr int kDirectionFeatures = 9;
constexpr double kHarmonic0 = 0.28209479177387814;   // sqrt(1 / (4 pi))
constexpr double kHarmonic1 = 0.4886025119029199;    // sqrt(3 / (4 pi))
constexpr double kHarmonic2 = 1.0925484305920792;    // sqrt(15 / (4 pi))
constexpr double kHarmonic2z = 0.31539156525252005;  // sqrt(5 / (16 pi))
constexpr double kHarmonic2xy = 0.5462742152960396;  // sqrt(15 / (16 pi))

}  // namespace likeness
