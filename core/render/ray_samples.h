// What lies along a ray: stretches, the samples that represent them, cells' contents. Plain C++17: the CUDA
// kernels read it too.
#pragma once

#include <cstdint>

namespace likeness {

struct Interval {
  float near = 0, far = 0;  // m along the ray
  float depth = 0;          // optical depth expected in it; 0: not known
};

struct RaySample {
  float t = 0;    // m
  float dt = 0;   // m of ray this sample represents
  int field = 0;  // 0 head, 1 torso
};

// A stretch of a ray represented by one sample. It may reach over a gap between cells, and from one field to
// the other.
struct RayStratum {
  RaySample sample;  // in its middle
  float start = 0;   // m of the lists' length before it; it goes on for sample.dt
};

// The contents of a cell of a field's grids.
struct CellContent {
  bool occupied = false, core = false;
  std::uint8_t opacity = 0;
};

// The share that pictures and training spread evenly: with a quarter, training stalls after a thousand steps,
// since nothing is learnt where nothing is expected.
constexpr float kEvenShare = 0.5f;

}  // namespace likeness
