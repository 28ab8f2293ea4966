// What goes wrong in pictures of an avatar beyond what its clip shows, in numbers. Pictures are 8-bit RGB of
// one size; masks have one channel, 255 inside; levels are of 255.
#pragma once

#include "core/base/linalg.h"
#include "core/image/image.h"

namespace likeness {

// Share of the mask's pixels that are specks: in some channel more than 48 levels off the truth and, in some
// channel, more than 48 off the median of their 7 x 7 neighbours. NaN for an empty mask.
double speck_share(const Image8& truth, const Image8& rendered, const Image8& mask);

// Mean colour over the mask, levels; NaN for an empty mask.
Vec3d mean_colour(const Image8& picture, const Image8& mask);

// Mean over the mask's pixels and channels of |a - b|, levels; NaN for an empty mask.
double mean_change(const Image8& a, const Image8& b, const Image8& mask);

// Area of both over area of either; 1 where both are empty.
double mask_iou(const Image8& a, const Image8& b);

}  // namespace likeness
