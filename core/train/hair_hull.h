// How far hair stands off the head model's bare scalp: read off the mattes where it stands against the
// background, and spread over the rest of the scalp as a smooth closed hull.
#pragma once

#include <cstdint>
#include <vector>

#include "core/head/pose_head.h"
#include "core/train/train.h"

namespace likeness {

struct HairHull {
  std::vector<float> thickness;  // (V) m outwards along the posed head's normal; 0 on face, ears and neck
  std::vector<float> hairy;      // (V) 0 = skin .. 1 = scalp
};

// From own views with a matte; without any the scalp is bare. Ears are not covered by it. triangles: of the
// model, those that belong to the head.
HairHull make_hair_hull(const TrainingSet& set, const HeadShape& shape,
                        const std::vector<Triangle>& triangles);

}  // namespace likeness
