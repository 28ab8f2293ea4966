// What colour the clip's pictures give the places of a surface.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/base/linalg.h"
#include "core/train/train.h"

namespace likeness {

// At most `most` numbers below `count`, evenly spread.
std::vector<std::size_t> evenly(std::size_t count, int most);

struct ViewColours {
  std::vector<Vec3f> colour;  // (V) sRGB-encoded, [0, 1]; zero where no picture shows the place
  std::vector<float> weight;  // (V) sum over the pictures of how squarely they face it, cubed
};

// pose: (V) vertices of the surface for an articulation, head frame, m; `triangles` are theirs, and hide what
// lies behind them. Own views alone, at most `most` of them; where there is a matte, only inside the person.
ViewColours gather_colours(const TrainingSet& set, const std::vector<Triangle>& triangles,
                           const std::function<std::vector<Vec3f>(const Articulation&)>& pose, int most);

}  // namespace likeness
