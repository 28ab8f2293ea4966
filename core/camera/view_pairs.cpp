// One picture of each pair is the target, the other is aligned to it.
#include "core/camera/view_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/camera/align_view.h"

namespace likeness {
namespace {

// Share of one view's picture that another shows, too.
double shared_view(const Intrinsics& reference, const HandheldView& of, const HandheldView& by) {
  constexpr int kSide = 6;
  const Intrinsics from = view_intrinsics(reference, of), to = view_intrinsics(reference, by);
  const Mat3d turn = by.turn * of.turn.transpose();
  int shared = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double x = from.width * (0.5 + i % kSide) / kSide, y = from.height * (0.5 + i / kSide) / kSide;
    const Vec3d ray = turn * Vec3d((x - from.cx) / from.fx, (y - from.cy) / from.fy, 1);
    if (ray.z() < 0.1) continue;
    const double u = to.fx * ray.x() / ray.z() + to.cx, v = to.fy * ray.y() / ray.z() + to.cy;
    shared += u > 0 && v > 0 && u < to.width && v < to.height;
  }
  return double(shared) / (kSide * kSide);
}

double turn_between(const HandheldView& a, const HandheldView& b) {
  return rotation_angle(a.turn * b.turn.transpose());
}

struct FittedPair {
  AlignedView aligned;
  double nats = 0;
};

// Aligns the first of a pair to the second.
FittedPair fit_pair(const PairPictures& pictures, const ViewPair& pair, const PairModel& model) {
  Intrinsics reference = pictures.reference;
  reference.fx *= model.focal, reference.fy *= model.focal;
  const HandheldView first = with_longer_lens(pictures.views[pair.first], model.focal),
                     second = with_longer_lens(pictures.views[pair.second], model.focal);
  const auto &picture = pictures.pyramids[pair.first], &other = pictures.pyramids[pair.second];
  const ViewTarget target{view_intrinsics(reference, second), other};
  ViewPrior prior;
  prior.shifts = model.shifts;
  AlignedView start;
  start.view = {first.turn * second.turn.transpose(), first.log_zoom, first.shift};
  const int coarsest = int(picture.size()) - 1, finest = std::min(1, coarsest);
  FittedPair fitted;
  fitted.aligned =
      align_view(picture, reference, target, start, prior, std::min(finest + 1, coarsest), finest);
  // Of normal differences of a spread that is not known: half their number times the logarithm of it.
  constexpr double kAlike = 16;  // px of level 0 that count as one: see align_view.cpp
  const double cap = std::max(4.0, 0.5 * grey_contrast(picture[std::size_t(finest)]));
  const ViewDifferences d = view_differences(picture, reference, target, fitted.aligned, finest, cap);
  const double count = d.placed * std::min(1.0, std::ldexp(1.0, 2 * finest) / kAlike);
  constexpr double kLeastSquare = 0.3;  // grey values: of two pictures in eight bits
  fitted.nats = d.placed ? 0.5 * count * std::log(d.squares / d.placed + kLeastSquare) : 0;
  measure_view(picture, reference, target, prior, fitted.aligned);
  return fitted;
}

}  // namespace

HandheldView with_longer_lens(const HandheldView& view, double focal) {
  Vec3d turn = vector_from_turn(view.turn);
  turn.head<2>() /= focal;
  return {turn_from_vector(turn), view.log_zoom, view.shift};
}

std::vector<ViewPair> distant_pairs(const Intrinsics& reference, std::span<const HandheldView> views,
                                    std::size_t anchors) {
  constexpr double kShared = 0.6, kScale = 0.1;
  constexpr std::size_t kCandidates = 48;
  std::vector<ViewPair> pairs;
  const std::size_t count = views.size();
  anchors = std::min(anchors, count);
  for (std::size_t a = 0; a < anchors; ++a) {
    const std::size_t i = (2 * a + 1) * count / (2 * anchors);
    const auto apart = [&](std::size_t j) { return i > j ? i - j : j - i; };
    std::size_t widest = i, farthest = i;
    for (std::size_t c = 0; c < std::min(kCandidates, count); ++c) {
      const std::size_t j = c * count / std::min(kCandidates, count);
      if (j == i || std::abs(views[i].log_zoom - views[j].log_zoom) > kScale ||
          shared_view(reference, views[i], views[j]) < kShared)
        continue;
      if (widest == i || turn_between(views[i], views[j]) > turn_between(views[i], views[widest])) widest = j;
      if (farthest == i || apart(j) > apart(farthest)) farthest = j;
    }
    if (widest != i) pairs.push_back({i, widest, true});
    if (farthest != i && farthest != widest) pairs.push_back({i, farthest, false});
  }
  return pairs;
}

PairFits fit_pairs(const PairPictures& pictures, std::span<const ViewPair> pairs, const PairModel& model,
                   std::stop_token stop) {
  PairFits fits;
  fits.nats.resize(pairs.size());
  fits.shift_px.resize(pairs.size());
  fits.misfit_px.resize(pairs.size());
  parallel_for(pairs.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    const FittedPair fitted = fit_pair(pictures, pairs[i], model);
    const AlignedView& at = fitted.aligned;
    fits.nats[i] = fitted.nats;
    fits.shift_px[i] = (at.view.shift - pictures.views[pairs[i].second].shift).norm();
    fits.misfit_px[i] = at.misfit_px;
  });
  return fits;
}

PairLens lens_of_pairs(const PairPictures& pictures, std::span<const ViewPair> pairs, double prior_sigma,
                       std::stop_token stop) {
  std::vector<ViewPair> wide;
  for (const ViewPair& pair : pairs)
    if (pair.wide) wide.push_back(pair);
  // Two pictures that look the same way tell nothing, however certain their noise seems.
  constexpr double kLeastTurn = 0.02;  // rad
  std::vector<double> turns;
  for (const ViewPair& pair : wide)
    turns.push_back(turn_between(pictures.views[pair.first], pictures.views[pair.second]));
  if (median(turns) < kLeastTurn) return {};
  const auto cost = [&](double log_focal) {
    double sum = 0.5 * log_focal * log_focal / (prior_sigma * prior_sigma);
    for (const double nats : fit_pairs(pictures, wide, {std::exp(log_focal), false}, stop).nats) sum += nats;
    return sum;
  };
  // Three places that a parabola goes through; halved towards the lowest.
  double middle = 0, step = 0.16, at = cost(0), below = cost(-step), above = cost(step), curvature = 0;
  for (int i = 0; i < 12 && step > 0.02; ++i) {
    if (below < at && below <= above) {
      above = at, at = below, middle -= step, below = cost(middle - step);
    } else if (above < at) {
      below = at, at = above, middle += step, above = cost(middle + step);
    } else {
      curvature = (above - 2 * at + below) / (step * step);
      step /= 2;
      if (step > 0.02) below = cost(middle - step), above = cost(middle + step);
    }
    if (stop.stop_requested() || std::abs(middle) > 0.7)
      return {};  // half or twice as long: nothing was found
  }
  if (curvature <= 0) return {};
  const double bend = above - 2 * at + below;
  const double lowest =
      middle + (bend > 0 ? std::clamp(0.5 * (below - above) / bend, -1.0, 1.0) * 2 * step : 0);
  const double own = curvature - 1 / (prior_sigma * prior_sigma);
  return {std::exp(lowest), own > 0 ? 1 / std::sqrt(own) : 1};
}

}  // namespace likeness
