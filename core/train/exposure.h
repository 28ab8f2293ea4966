// Exposure and white balance that wander while a phone films, told from the background: it is the same in all
// frames before a plate, so that what differs is the camera's doing. With the plate's exposure given to all
// of them, one face has one colour; otherwise the field learns their mean, and the codes of the frames what
// no other picture has.
#pragma once

#include <optional>
#include <vector>

#include "core/base/linalg.h"
#include "core/image/image.h"
#include "core/image/tiled_mask.h"
#include "core/train/train.h"

namespace likeness {

// What a frame's exposure makes of the plate's: a factor on linear light for each channel, within a factor of
// four. From pixels beside the person (alpha: of the picture's size) where the plate was seen, neither dark
// nor near the brightest; the mean of what lies near their median, as a passer-by or a shadow changes few.
// nullopt: too few of them.
std::optional<Vec3f> exposure_beside(const Image8& picture, const TiledMask& alpha,
                                     const PlatePicture& behind);

// sRGB-encoded colours with that factor on their light; beyond the brightest, the brightest.
Image8 exposed(const Image8& picture, const Vec3f& factor);
Image exposed(Image picture, const Vec3f& factor);  // (h, w, 3) 0..1

// One for each of own_views(set). A view that says nothing has that between its neighbours', ones where none
// does.
std::vector<Vec3f> view_exposures(const TrainingSet& set);
// rms over views and channels of the natural logarithm, about each channel's mean; nullopt for fewer than
// two.
std::optional<double> exposure_drift(const std::vector<Vec3f>& exposures);
// Gives the plate's exposure to all own views. exposures: of view_exposures.
void even_exposure(const std::vector<Vec3f>& exposures, TrainingSet& set);

}  // namespace likeness
