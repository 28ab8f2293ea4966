// What lies along a ray: stretches, the samples that stand for them, what cells hold. Plain C++17: the CUDA
// kernels read it, too.
#pragma once

#include <cstdint>

namespace likeness {

struct Interval {
  float near = 0, far = 0;  // m along the ray
  float depth = 0;          // optical depth expected in it; 0: not known
};

struct RaySample {
  float t = 0;    // m
  float dt = 0;   // m of ray this sample stands for
  int field = 0;  // 0 head, 1 torso
};

// A stretch of a ray that one sample stands for. It may reach over a gap between cells, and from one field to
// the other.
struct RayStratum {
  RaySample sample;  // in its middle
  float start = 0;   // m of the lists' length before it; it goes on for sample.dt
};

// What a cell of a field's grids holds.
struct CellContent {
  bool occupied = false, core = false;
  std::uint8_t opacity = 0;
};

// What pictures and trainings spread evenly: with a quarter a training stands still after a thousand steps,
// since nothing is learnt where nothing is expected.
constexpr float kEvenShare = 0.5f;

}  // namespace likeness
