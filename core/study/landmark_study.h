// Whether what the landmark loss measures (core/train/landmark_patches.h) is where landmarks are: offsets by
// its maps beside those by dlib, which knows nothing of them, on held-out frames. A map is worth learning from
// if the two correlate by kLeastCorrelation on shifted renders, not only on the made-up patches it was learnt on.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/project/project.h"

namespace likeness {

// Offsets of landmarks against the true picture, over frames and shifts and both axes.
struct OffsetAgreement {
  double both = 0, by_map = 0, by_dlib = 0;  // sums of products, (interocular distance)^2
  void add(const OffsetAgreement& other);
  double correlation() const;  // NaN of nothing
  double gain() const;         // offset by the map for one by dlib, least squares
};

struct LandmarkRow {
  int landmark = 0;
  double learnt_correlation = 0, spread = 0;  // LandmarkMap
  bool accepted = false;
  // The true picture shifted; the render shifted; the render as it is, whose offsets are its real errors.
  OffsetAgreement truth, shifted, render;
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
