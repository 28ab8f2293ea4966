// Grey pictures with holes, and their pyramids: what dense alignment compares.
#pragma once

#include <vector>

#include "core/camera/camera.h"
#include "core/image/image.h"

namespace likeness {

// One channel, 0..255; NaN where nothing is known (the person, what no frame saw).
using GreyPicture = Image;

// Px at a film's border that resampling and coding spoil.
inline constexpr int kSpoiltRim = 2;

// hole: one channel of the same size, non-zero = not known; may be null. The outermost `rim` pixels, which
// resampling and coding spoil, are not known either.
GreyPicture grey_picture(const Image8& grey, const Image8* hole, int rim);

// Half the size, rounded up; a pixel's place halves exactly. Binomial weights (1 3 3 1)/8 over the known
// pixels; known where they have at least three quarters of the weight.
GreyPicture halved(const GreyPicture& picture);

// From the picture itself downwards; at most `levels` of them.
std::vector<GreyPicture> grey_pyramid(GreyPicture picture, int levels);

// As many as leave at least 28 px of the shorter side: less shows no scene.
int pyramid_levels(int width, int height);

// Intrinsics of level `level` of a pyramid: places halve with each.
Intrinsics at_level(Intrinsics k, int level);

// Standard deviation of the noise from pixel to pixel (Immerkaer 1996, "Fast noise variance estimation"), by
// the median of the known places, so that edges do not count. 0..255 units; a coded film has less of it than
// its sensor.
double pixel_noise(const GreyPicture& picture);

}  // namespace likeness
