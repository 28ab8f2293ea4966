// Where a landmark lies, read from a patch of the picture: for each landmark a linear map from the difference
// of two patches to the landmark's offset between them, one step of supervised descent (Xiong & De la Torre,
// CVPR 2013), learnt only on the person's own training views. It makes the landmark loss of Kwak & Ko 2024
// differentiable:
//
//   L = L_rec + lambda L_lmk,   L_lmk = mean over the step's patches of  w | R (g - t) |_1
//
//   g, t (P^2)   grey values in [0, 1], sRGB-encoded, of the rendered and the true patch around the landmark
//   R (2, P^2)   the landmark's map; its results are interocular distances (outer corners of the eyes), as in
//                the paper's normalised landmark errors, so that lambda does not depend on the picture's size
//   w            visibility in the view times 1 / (1 + (spread / kUsualSpread)^2) of the landmark
//
// The maps are ridge regressions. They learn from patches of the training views that were shifted, sheared
// and warped as the other views' expressions would move the landmarks about, and made softer and brighter, to
// which they must be invariant. A landmark whose held-out offsets are not predicted with a correlation of
// kMinCorrelation is left out.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/head/pose_head.h"
#include "core/train/train.h"

namespace likeness {

inline constexpr int kPatchSide = 11;  // P, samples: 7 and 9 find fewer landmarks
inline constexpr int kPatchRays = kPatchSide * kPatchSide;
inline constexpr int kFirstPatchLandmark = 17;  // brows, nose, eyes and mouth: the jaw line has no corners
inline constexpr double kMinCorrelation = 0.9;
inline constexpr double kUsualSpread = 0.02;  // interocular distances

struct LandmarkMap {
  std::vector<float> map;  // (2, P^2) interocular distances per grey level; empty: never seen
  // Of predicted and true offsets of held-out training views, both axes together.
  double correlation = 0;
  double spread = 0;  // rms of their difference along an axis, interocular distances
  float weight = 0;   // 0: not accepted
};

// A patch's middle, a pixel; its samples lie at pixels, `stride` apart.
struct PatchPlace {
  int landmark = 0, x = 0, y = 0;
  float visibility = 0;  // (0, 1]
};

struct LandmarkPatches {
  int stride = 1;             // px
  double interocular_px = 0;  // the views' median
  std::array<LandmarkMap, kLandmarkCount> maps;
  std::vector<std::vector<PatchPlace>> places;  // (own views) of accepted landmarks that are seen whole
  std::vector<std::size_t> views;               // those with a place
  int accepted() const;
};

// From the first clip's views; further clips have another light. Takes seconds. An error if no landmark can
// be measured.
Result<LandmarkPatches> learn_landmark_patches(const TrainingSet& set, const HeadShape& shape,
                                               std::uint64_t seed);

// Places of the patches of a view's landmarks: those that are visible and whose whole patch lies in the
// picture and is trained on.
std::vector<PatchPlace> patch_places(const HeadModel& model, const HeadShape& shape, const TrainingView& view,
                                     int stride);

// The pixel of a patch's sample i of [0, P^2), row by row.
struct PatchPixel {
  int x = 0, y = 0;
};
PatchPixel patch_pixel(const PatchPlace& place, int stride, int i);

// The landmark's offset in `rendered` against `truth`, pictures of one size, in interocular distances.
Vec2f landmark_offset(const LandmarkMap& map, const PatchPlace& place, int stride, const Image8& rendered,
                      const Image8& truth);

}  // namespace likeness
