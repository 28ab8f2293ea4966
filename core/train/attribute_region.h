// From paint on pictures to a region of the canonical face: the paint is transferred to the posed head's
// vertices through the frame's track, merged over the frames, softened, and stored in a lattice around the
// resting face.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/camera/camera.h"
#include "core/head/pose_head.h"
#include "core/image/image.h"
#include "core/render/attribute.h"

namespace likeness {

struct RegionOptions {
  float rim = 0.006f;    // m beyond the paint over which the weight fades on the surface
  float reach = 0.012f;  // m off the surface up to which the weight is full: a cheek rises
  float far = 0.022f;    // m off the surface at which it reaches zero
  float cell = 0.003f;   // m between the lattice's nodes; grows if it would take more than 64 per axis
};

// How far each vertex lies under the paint, 0..1 (V); 0 where it is not seen. cover: (h, w, 1) of the
// camera's picture, 0..1. posed: (V) of the frame, head frame.
std::vector<float> carry_paint(const HeadModel& model, std::span<const Vec3f> posed, const Camera& camera,
                               const Pose& world_from_head, const Image& cover);

// Distance of every vertex to the nearest with paint of a half or more, m (V), along straight lines over the
// resting face; infinite if there is no paint.
std::vector<float> distance_to_paint(std::span<const Vec3f> rest, std::span<const float> paint);

// 1 where painted, 0 from the rim's end on (V).
std::vector<float> soft_weights(std::span<const float> distance, const RegionOptions& options = {});

// The lattice around the resting face. weights: (V), at least one above 0.
AttributeRegion make_region(const std::string& name, const HeadModel& model, std::span<const Vec3f> rest,
                            std::span<const float> weights, const RegionOptions& options = {});

}  // namespace likeness
