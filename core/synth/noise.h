// Deterministic noise on points of space: the basis of every procedural texture of the demo.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/linalg.h"

namespace likeness {

inline std::uint32_t hash_u32(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  return x ^ (x >> 16);
}

inline std::uint32_t hash_cell(int x, int y, int z, std::uint32_t seed) {
  return hash_u32(std::uint32_t(x) * 0x9e3779b1U ^
                  hash_u32(std::uint32_t(y) * 0x85ebca77U ^ hash_u32(std::uint32_t(z) * 0xc2b2ae3dU + seed)));
}

// [0, 1)
inline float hash_unit(std::uint32_t x) { return float(hash_u32(x) >> 8) * (1.0f / 16777216.0f); }
inline float hash_unit(int x, int y, int z, std::uint32_t seed) {
  return float(hash_cell(x, y, z, seed) >> 8) * (1.0f / 16777216.0f);
}

// A stream of random numbers whose whole state is one counter.
struct RandomStream {
  std::uint32_t state = 1;
  float unit() { return hash_unit(state += 0x9e3779b9U); }  // [0, 1)
  float between(float low, float high) { return low + (high - low) * unit(); }
  int below(int count) { return std::min(count - 1, int(unit() * float(count))); }
};

inline float smoothstep(float low, float high, float x) {
  const float t = std::min(1.0f, std::max(0.0f, (x - low) / (high - low)));
  return t * t * (3 - 2 * t);
}

template <class T>
T mix(const T& a, const T& b, float t) {
  return a * (1 - t) + b * t;
}

// Smooth noise of unit feature size: about [-1, 1], mean 0.
float noise(const Vec3f& p, std::uint32_t seed);
// Octaves of noise, each of half the size and `gain` times the height; about [-1, 1].
float fractal_noise(const Vec3f& p, int octaves, std::uint32_t seed, float gain = 0.5f);

}  // namespace likeness
