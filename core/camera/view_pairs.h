// What two pictures far apart in a clip say of the camera. A mosaic is blended from all frames, so that what
// no view of it can explain - parallax, another lens than the one assumed - hides in its blur. One picture
// laid over another hides nothing.
//
// Two pictures of a camera that turns differ by the homography K2 R inverse(K1): how it bends the picture
// tells the focal length, the more the wider the turn (Hartley 1994, "Self-calibration from multiple views
// with a rotating camera"). A moved crop, which bends nothing, is told from a turn by the same.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/camera/grey_pyramid.h"
#include "core/camera/handheld_view.h"

namespace likeness {

struct ViewPair {
  std::size_t first = 0, second = 0;  // into the views
  bool wide = false;                  // of all that overlap enough, the pair with the widest turn
};

// For some `anchors` of the views, evenly spread over time, the one that looks elsewhere most and one far
// away in time, of those that show 60 % of the same at least. None where no two views overlap.
std::vector<ViewPair> distant_pairs(const Intrinsics& reference, std::span<const HandheldView> views,
                                    std::size_t anchors = 20);

// The views that the pairs are of, and their pictures.
struct PairPictures {
  Intrinsics reference;  // of the pictures' level 0
  std::span<const HandheldView> views;
  std::vector<std::vector<GreyPicture>> pyramids;  // one for each view; empty where no pair has it
};

// What is assumed of all pairs.
struct PairModel {
  double focal = 1;     // the reference's focal lengths are these times as long
  bool shifts = false;  // the principal point moves, too
};

struct PairFits {
  // Minus the logarithm of the likelihood of each pair's pictures, up to a constant of its own.
  std::vector<double> nats;
  std::vector<double> shift_px;   // by which the principal point moves, px; 0 without shifts
  std::vector<double> misfit_px;  // by how much parts of the picture lie elsewhere than the model says, as in
                                  // AlignedView
};
// Once a stop is requested, the pairs that are left are passed over: the fits are then of no use.
PairFits fit_pairs(const PairPictures& pictures, std::span<const ViewPair> pairs, const PairModel& model,
                   std::stop_token stop = {});

// The focal length, in units of the reference's, that explains the wide pairs best.
struct PairLens {
  double focal = 1;
  double sigma = 1;  // standard deviation of its logarithm, by the pictures alone
};
// {1, 1} where no pair turns by a degree, and once a stop is requested. prior_sigma: of the logarithm of the
// true focal length over the reference's.
PairLens lens_of_pairs(const PairPictures& pictures, std::span<const ViewPair> pairs, double prior_sigma,
                       std::stop_token stop = {});

// The view of another reference, `focal` times as long, that maps the middle of a picture as `view` does.
HandheldView with_longer_lens(const HandheldView& view, double focal);

}  // namespace likeness
