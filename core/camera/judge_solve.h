// Whether a camera path from structure from motion may be used. A solve that explains its pictures need not
// be true: where the camera hardly travelled, a distorted or absurdly long lens explains them as well.
#pragma once

#include <string>
#include <vector>

#include "core/camera/colmap_model.h"

namespace likeness {

struct SolveLimits {
  // Of the longer side, degrees. Phones' and cameras' lenses for people have 25 (85 mm on 35 mm film, cropped
  // somewhat) to 110 (ultra-wide); less is a telephoto lens, with which nobody films a head from near.
  double narrowest = 25, widest = 120;
  double lens_apart = 0.3;  // share of the focal length by which the file's lens tag may differ:
                            // stabilisation crops by 10 to 20 %
  // Median over the points of the angle between the rays that place them, degrees. colmap itself drops points
  // below 1.5. Half a walk round a head gives 15 and more; where 4 are not reached the camera swayed in a
  // hand, and its path and lens make up for each other.
  double parallax = 4;
  double reprojection = 0.003;  // mean, as a share of the width; good solves have a third of it
  double placed = 0.6;          // share of the keyframes
  // Least scale of the picture's border, along the radius, as a share of the middle's. At 0 the lens folds:
  // two directions share a pixel. Phones correct their lenses; even an action camera's has 0.4.
  double squeeze = 0.2;
};

struct SolveJudgement {
  double view_deg = 0;               // field of view across the longer side, distortion left aside
  double parallax_deg = 0;           // median
  double reprojection = 0;           // mean, share of the width
  double placed = 0;                 // share of the keyframes
  double squeeze = 1;                // least over the picture
  std::vector<std::string> reasons;  // why it must not be used, a plain sentence each
  bool usable() const { return reasons.empty(); }
};

// keyframes: pictures that went in. focal_35mm: of the file's lens tag, 0 where it has none; ignored for
// pictures of a shape that no camera films, which are cut out of larger ones (core/camera/assumed_lens.h).
SolveJudgement judge_solve(const ColmapModel& model, int keyframes, double focal_35mm,
                           const SolveLimits& limits = {});

// The least change of the distorted radius along the undistorted one, over all radii the picture shows: 1
// without distortion, 0 or less where it folds.
double least_squeeze(const Intrinsics& k);

}  // namespace likeness
