// What colour the clip's pictures give the places of a surface.
#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "core/base/linalg.h"
#include "core/scene/mesh_scene.h"
#include "core/train/train.h"

namespace likeness {

// At most `most` numbers below `count`, evenly spread.
std::vector<std::size_t> evenly(std::size_t count, int most);

// A surface at a view's moment.
struct PosedSurface {
  std::vector<Vec3f> vertices;  // m, surface's frame
  Pose world_from_surface = Pose::Identity();
};
using PoseSurface = std::function<PosedSurface(const TrainingView&)>;
// What a view's camera sees of another surface, which may hide the first.
using SeeBefore = std::function<Raster(const TrainingView&)>;

struct ViewColours {
  std::vector<Vec3f> colour;  // (V) sRGB-encoded, [0, 1]; zero where no picture shows the place
  std::vector<float> weight;  // (V) sum over the pictures of how squarely they face it, cubed
  std::vector<int> pictures;  // (V) that show it

  // The cosine at which the pictures see it, by the mean of its cubes; 0 where none does.
  float squareness(std::size_t v) const {
    return pictures[v] > 0 ? std::cbrt(weight[v] / float(pictures[v])) : 0.f;
  }
};

// `triangles` are the surface's, and hide what lies behind them, as does what `before` sees, if given. Own
// views alone, at most `most` of them; where there is a matte, only inside the person.
ViewColours gather_colours(const TrainingSet& set, const std::vector<Triangle>& triangles,
                           const PoseSurface& pose, int most, const SeeBefore& before = {});

}  // namespace likeness
