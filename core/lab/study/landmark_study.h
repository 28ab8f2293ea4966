// Whether what the landmark loss measures (core/train/landmark_patches.h) is where landmarks are: offsets by
// its maps on held-out frames, beside those by dlib, which knows nothing of the maps, and beside the truth
// where a picture was shifted by a known way. A map is worth learning from if it agrees by kMinCorrelation
// on shifted renders, too, not only on the made-up patches it was learnt on.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/project/project.h"

namespace likeness {

// Two measurements of offsets, over frames, shifts and both axes.
struct OffsetAgreement {
  double both = 0, one = 0, other = 0;  // sums of products, (interocular distance)^2
  void add(const OffsetAgreement& more);
  double correlation() const;  // NaN of nothing
};

struct LandmarkRow {
  int landmark = 0;
  double learnt_correlation = 0, spread = 0;  // LandmarkMap
  bool accepted = false;
  // Of the true picture shifted: map and dlib, map and shift, dlib and shift. Of the render shifted, which is
  // off by its own errors beside: map and dlib; what the shift changed of the map's, and the shift. Of the
  // render as it is: map and dlib.
  OffsetAgreement truth, truth_map, truth_dlib, shifted, shifted_map, render;
};

struct LandmarkStudy {
  int frames = 0, stride = 0;
  double interocular_px = 0;
  std::vector<LandmarkRow> rows;  // landmarks that are learnt
};

// frames: of the held-out ones, evenly; 0: all. The project has a trained avatar.
Result<LandmarkStudy> study_landmarks(const Project& project, int frames, const Progress& progress,
                                      std::stop_token stop);

}  // namespace likeness
