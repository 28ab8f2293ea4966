// What is known of a face in a picture: its box and its 68 landmarks, in pixels, and what a search for them
// is told.
#pragma once

#include <array>

#include "core/base/linalg.h"
#include "core/head/head_model.h"

namespace likeness {

struct FaceBox {
  double x = 0, y = 0, width = 0, height = 0;  // px
  double score = 0;  // of the detector, higher is more certain; below 0 only where a face was a moment ago
};

// Shared area over joint area, 0..1.
double overlap(const FaceBox& a, const FaceBox& b);

struct Landmarks {
  std::array<Vec2d, kLandmarkCount> points;     // px
  std::array<double, kLandmarkCount> spread{};  // px, rms over the cluster: the uncertainty
  double cluster_share = 0;                     // share of the perturbed runs that agree, 0..1
  int runs = 0;                                 // of the predictor
};

// How many perturbed boxes dlib's predictor runs from; each costs about a millisecond. The first runs suffice
// if they agree with each other and with the hint; otherwise the rest are made too. The network looks once
// for every eight of `most`, four times at most; each look costs 4 ms.
struct LandmarkEffort {
  int first = 32, most = 32;  // rounded up to whole rings of 4 scales
};

// Mean spread of the inner points (17..67), px.
double inner_spread(const Landmarks& landmarks);

// Where a tracked head predicts the landmarks; it selects the cluster, not the points' places.
struct LandmarkHint {
  std::array<Vec2d, kLandmarkCount> points;  // px
  double sigma = 4;                          // px, of its rigid points (nose, eye corners)
};

}  // namespace likeness
