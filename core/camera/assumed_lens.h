// The lens of a resting camera for which nothing was solved.
#pragma once

#include "core/camera/camera.h"

namespace likeness {

// The focal length over the picture's shorter side where nothing is known: for a picture as phones film it,
// however they are held, and for a square, which was cropped from another, often one filmed from afar.
inline constexpr double kPhoneFocal = 1.4, kCutOutFocal = 2;

// For a lens with this 35 mm equivalent focal length, by the film's longer side. The axis passes through the
// middle of the picture; no distortion.
Intrinsics film_intrinsics(int width, int height, double focal_35mm);

// When only the clip is known. focal_35mm: as in VideoInfo; 0: not known. It is ignored for pictures of a
// shape that no camera films: the size of the pictures they were cropped from is unknown.
Intrinsics assumed_intrinsics(int width, int height, double focal_35mm);

}  // namespace likeness
