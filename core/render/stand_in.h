// A stand-in for an avatar's fields behind the same rays - stored values, say - so that two compared pictures
// differ in nothing but the fields.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/linalg.h"
#include "core/render/rays.h"

namespace likeness {

// Samples of one field that take light, ray after ray.
struct WeightedSamples {
  const FieldSamples* samples = nullptr;
  std::span<const std::uint32_t> slots;  // (N) of the samples
  std::span<const std::uint32_t> rays;   // (N) their rays, ascending
  std::span<const float> weights;        // (N) share of their ray's light
};

// Called for many bands of rays at once, each from its own thread.
class StandInFields {
 public:
  virtual ~StandInFields() = default;
  // (N) per cube side, as a field's. part: 0 head, 1 torso; the samples are canonical.
  virtual void densities(int part, const FieldSamples& samples, std::vector<float>& sigma) const = 0;
  // (R) Sets the rays' colours, without what lies behind: zero where a ray has no sample.
  virtual void colours(const std::array<WeightedSamples, 2>& parts, std::span<Vec3f> rays) const = 0;
};

}  // namespace likeness
