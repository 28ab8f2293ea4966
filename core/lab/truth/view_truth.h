// Cameras measured by where they look and how wide: for those that a hand turns, that zoom, or whose crop
// slides, and whose path, if there is one, is no solve's business.
//
// A solve does not know how the world is turned: one rotation, for every place of the film one, is taken out
// first. What is left, and the relative focal length, decide whether a background fits together.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera/camera.h"
#include "core/synth/demo_truth.h"

namespace likeness {

struct ViewErrors {
  int wanted = 0, found = 0;  // frames with a true camera; those among them with a found one
  double turn_median_deg = 0, turn_max_deg = 0;
  double zoom_median_percent = 0,
         zoom_max_percent = 0;  // of the focal length relative to the film's usual one
  double focal_percent = 0;     // median, found over true - 1
  // Where a pixel of what is far away lies in the first frame of its place, found beside true; in true
  // pixels. It depends on neither rotation nor scale of the world, and holds what a turn and a moved centre
  // do together.
  double mapping_median_px = 0, mapping_p95_px = 0;
};
// shots: of the film, or empty. nullopt where fewer than two frames are in both, unless both cameras rest.
std::optional<ViewErrors> compare_views(const CameraSet& found, const CameraSet& truth,
                                        const std::vector<TrueShot>& shots);

}  // namespace likeness
