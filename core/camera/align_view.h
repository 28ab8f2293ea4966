// Dense alignment of one picture to a mosaic: Gauss-Newton on grey values from coarse to fine (Lucas & Kanade
// 1981; Baker & Matthews 2004), over every background pixel, so that it works where there are no corners.
//
// Minimises over the view, a gain g and a bias b
//     sum over pixels p of rho(g M(place of p) + b + l_tile - I(p)) + priors,
// rho Tukey's biweight. Its scale grows with the slope of the picture: at an edge, half a pixel of
// disagreement is no outlier. l_tile, light that changes from place to place (a shadow, vignetting), is one
// value for each tile of the picture, as large as the tiles' mean residuals are found to be, and eliminated.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "core/camera/grey_pyramid.h"
#include "core/camera/handheld_view.h"

namespace likeness {

// What is aligned to. Levels of a picture that looks straight ahead in the world.
struct ViewTarget {
  Intrinsics intrinsics;            // of level 0
  std::vector<GreyPicture> levels;  // 0..255, NaN where nothing is known
};

// What is known before a picture is looked at.
struct ViewPrior {
  bool shifts = true;     // false: the shift stays as it is
  double shift_px = 0;    // scale of the shift: beyond it, it is allowed ever more readily (Cauchy)
  double log_zoom = 0;    // scale of the zoom
  double smooth_px = 0;   // scale of the distance to `expected`, px in the picture; 0: none
  HandheldView expected;  // by the neighbours in time
};

struct AlignedView {
  HandheldView view;
  double gain = 1, bias = 0;  // picture = gain * mosaic + bias
  double overlap = 0;         // share of the background pixels whose place in the mosaic is known
  double inliers = 0;         // share of these that agree with it
  double residual = 0;        // rms of gain * mosaic + bias - picture, each counted as 30 at most; 0..255
  double sigma_px = 0;        // standard deviation of where the background is, by what its texture tells
  double misfit_px = -1;  // by how much parts of the picture lie elsewhere, judged by how much they differ:
                          // median of the parts whose texture can tell; -1 where there are too few
  int parts = 0;          // with texture enough to be found by themselves
};

// How far parts of a background may lie off where the model of the camera puts them, as a share of the
// picture's longer side: 2 px at 480. A swaying hand, a distorting lens, a rolling shutter and a codec stay
// below half of it; a camera that travels is far beyond.
inline constexpr double kMisfitLimit = 0.004;
inline double misfit_limit_px(const Intrinsics& reference) {
  return kMisfitLimit * std::max(reference.width, reference.height);
}

// A picture of which fewer parts have texture tells nothing.
inline constexpr int kPartsToTell = 4;

// reference: intrinsics of the picture's level 0 at zoom 1. Levels from `coarsest` down to `finest` (0).
AlignedView align_view(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                       const ViewTarget& target, const AlignedView& start, const ViewPrior& prior,
                       int coarsest, int finest);

// Measures `overlap` and what follows it at the view given.
void measure_view(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                  const ViewTarget& target, const ViewPrior& prior, AlignedView& aligned);

// Standard deviation of what is known of a picture.
double grey_contrast(const GreyPicture& grey);

// How far the target as a view sees it differs from the picture, at a level.
struct ViewDifferences {
  int background = 0;  // px of the picture
  int placed = 0;      // of these with a place in the target
  double squares = 0;  // sum over the placed of the squared difference in grey values, each `cap` at most
};
ViewDifferences view_differences(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                                 const ViewTarget& target, const AlignedView& aligned, int level, double cap);

// How badly a view explains the picture at a level, 0 (not at all badly) .. 1: differences, truncated at half
// the picture's contrast, and what has no place in the mosaic counted as nearly the worst.
double view_badness(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                    const ViewTarget& target, const AlignedView& aligned, int level);

// The pan and tilt, whatever they be, at which the coarsest level correlates best with the mosaic as `start`
// sees it; nullopt where nothing correlates. Catches quick shakes, of up to a third of the picture.
std::optional<HandheldView> search_view(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                                        const ViewTarget& target, const HandheldView& start);

// What a view would show of a target's level 0 at the size of its reference; NaN where nothing is known.
GreyPicture seen_from(const ViewTarget& target, const Intrinsics& reference, const HandheldView& view,
                      int level = 0);

}  // namespace likeness
