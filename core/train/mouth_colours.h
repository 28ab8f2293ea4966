// What a mouth looks like inside whose clip never opens it: teeth like the whites of the eyes, tongue and
// walls in the lips' own red, darker the deeper they lie.
#pragma once

#include <vector>

#include "core/head/pose_head.h"

namespace likeness {

// Which vertices lie inside the mouth, (V) 1 = yes; none for a model without such parts.
std::vector<std::uint8_t> inside_mouth(const HeadModel& model);

// Sets the colours (V, sRGB-encoded) of those that are known less than wholly (V, 0..1), mixing with what is
// known; the others' give lips and eyes. rest: (V) vertices, m.
void colour_mouth(const HeadModel& model, const std::vector<Vec3f>& rest, std::vector<float>& known,
                  std::vector<Vec3f>& colours);

}  // namespace likeness
