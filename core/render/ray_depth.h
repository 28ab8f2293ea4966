// How far away the surface of an avatar is: where its rays' light comes from, for measurements of its shape.
#pragma once

#include <vector>

#include "core/camera/camera.h"
#include "core/render/render.h"

namespace likeness {

// Per pixel, row-major: the mean distance along its ray of what takes its light, weighted by how much of it
// each sample takes, and the share that is taken in all, 0..1.
struct RayDepths {
  std::vector<float> metres;  // (height * width) along the unit ray; 0 where nothing is met
  std::vector<float> alpha;   // (height * width)
};

// state: of pose_avatar. In single precision, with samples enough for a figure: slower than a picture.
RayDepths ray_depths(const Avatar& avatar, const Camera& camera, const RenderState& state);

}  // namespace likeness
