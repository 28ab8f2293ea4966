// From what was painted on pictures to a region of the canonical face: the paint is carried to the posed
// head's vertices through the frame's track, united over the frames, softened, and laid into a lattice around
// the resting face.
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
  float rim = 0.006f;    // m beyond what was painted over which the weight fades on the surface
  float reach = 0.012f;  // m off the surface where the weight is whole: a cheek rises
  float far = 0.022f;    // m off the surface where it is gone
  float cell = 0.003f;   // m between the lattice's nodes; grows where it would take more than 64 an axis
};

// How far each vertex lies under the paint, 0..1 (V); 0 where it is not seen. cover: (h, w, 1) of the
// camera's picture, 0..1. posed: (V) of the frame, head frame.
std::vector<float> carry_paint(const HeadModel& model, std::span<const Vec3f> posed, const Camera& camera,
                               const Pose& world_from_head, const Image& cover);

// Distance of every vertex to the nearest with paint of a half or more, m (V), along straight lines over the
// resting face; infinite without any paint.
std::vector<float> distance_to_paint(std::span<const Vec3f> rest, std::span<const float> paint);

// 1 where painted, 0 from the rim's end on (V).
std::vector<float> soft_weights(std::span<const float> distance, const RegionOptions& options = {});

// The lattice around the resting face. weights: (V), at least one above 0.
AttributeRegion make_region(const std::string& name, const HeadModel& model, std::span<const Vec3f> rest,
                            std::span<const float> weights, const RegionOptions& options = {});

}  // namespace likeness
