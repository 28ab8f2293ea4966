// The lens of a resting camera that nothing was solved for.
#pragma once

#include "core/camera/camera.h"

namespace likeness {

// The focal length over the picture's shorter side where nothing is known: of a picture as phones film it,
// however they are held, and of a square, which was cut out of another, as often as not of one filmed from
// afar.
inline constexpr double kPhoneFocal = 1.4, kCutOutFocal = 2;

// Of a lens of so many mm as on 35 mm film, by its longer side. The axis passes through the middle of the
// picture; no distortion.
Intrinsics film_intrinsics(int width, int height, double focal_35mm);

// Where nobody says more than the clip. focal_35mm: as VideoInfo has it; 0: not known. It is not believed of
// pictures that no camera films: nobody knows how large those were that they were cut out of.
Intrinsics assumed_intrinsics(int width, int height, double focal_35mm);

}  // namespace likeness
