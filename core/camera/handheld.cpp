// Frame by frame along the clip, then all at once.
#include "core/camera/handheld.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/mean_rotation.h"
#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/camera/align_view.h"
#include "core/camera/grey_mosaic.h"
#include "core/camera/mosaic_geometry.h"
#include "core/camera/view_pairs.h"

namespace likeness {
namespace {

constexpr double kLeastBackground = 0.02;  // share of the picture that must be background to align by
// A frame is found where so much of its background has a place in the mosaic, and so much of this agrees.
constexpr double kFoundOverlap = 0.3, kFoundInliers = 0.6;

// A frame on its way to a camera.
struct Solving {
  const HandheldFrame* given = nullptr;
  AlignedView aligned;
  bool placed = false;  // by its own picture
  double background = 0;
};

struct Solver {
  Intrinsics reference;
  HandheldOptions options;
  int levels = 1;
  bool shifts = false;  // the principal point moves, too
  double focal_sigma = 0;
  std::vector<Solving> frames;
  std::vector<std::size_t> training;  // ascending; into frames
  std::stop_token stop;               // whoever passes frames over for it returns what is of no use

  std::vector<GreyPicture> pyramid(const Solving& frame) const {
    return grey_pyramid(grey_picture(*frame.given->grey, frame.given->person, kSpoiltRim), levels);
  }
  ViewPrior prior() const {
    ViewPrior prior;
    prior.shifts = shifts;
    prior.shift_px = options.shift_scale * reference.width;
    prior.log_zoom = options.zoom_scale;
    return prior;
  }
};

bool is_found(const AlignedView& view) {
  return view.overlap >= kFoundOverlap && view.inliers >= kFoundInliers;
}

// From `from` by the share of the step that leads from there to `to`.
HandheldView part_of_way(const HandheldView& from, const HandheldView& to, double share) {
  return stepped(from, share * view_step(from, to));
}

// The last views of the frames aligned so far, and how well they fitted.
struct Trail {
  std::optional<AlignedView> last, before;
  std::vector<double> badness;

  std::vector<AlignedView> starts() const {
    std::vector<AlignedView> starts;
    if (!last) return starts;
    starts.push_back(*last);
    if (before) {
      AlignedView ahead = *last;
      ahead.view = stepped(last->view, view_step(before->view, last->view));
      starts.push_back(ahead);
    }
    return starts;
  }
  double usual_badness() const {
    constexpr std::size_t kRecent = 15;
    const std::size_t count = std::min(kRecent, badness.size());
    return count ? median(std::vector<double>(badness.end() - long(count), badness.end())) : 0.1;
  }
  void follow(const AlignedView& view, double bad) {
    before = last;
    last = view;
    badness.push_back(bad);
  }
};

// From several starts at the coarsest level, and by a search where none of them leads anywhere; then down to
// the finest.
AlignedView find_view(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                      const ViewTarget& target, const ViewPrior& prior,
                      const std::vector<AlignedView>& starts, double usual, double& badness) {
  const int coarsest = int(picture.size()) - 1;
  std::optional<AlignedView> best;
  badness = 1;
  const auto attempt = [&](const AlignedView& start) {
    const AlignedView view = align_view(picture, reference, target, start, prior, coarsest, coarsest);
    const double bad = view_badness(picture, reference, target, view, coarsest);
    if (!best || bad < badness) best = view, badness = bad;
  };
  for (const AlignedView& start : starts) attempt(start);
  // A search costs more than all of the rest: only where the picture is much less like the mosaic than usual.
  if (badness > 1.5 * usual + 0.02)
    for (const AlignedView& start : std::vector<AlignedView>{starts.front(), *best})
      if (const auto place = search_view(picture, reference, target, start.view)) {
        AlignedView from = start;
        from.view = *place;
        attempt(from);
      }
  return align_view(picture, reference, target, *best, prior, std::max(0, coarsest - 1), 0);
}

// Picks the training frame to begin with: of the middle third, the one with most contrast in its background.
std::size_t first_frame(const Solver& solver) {
  const std::size_t count = solver.training.size(), begin = count / 3,
                    end = std::max(begin + 1, 2 * count / 3);
  std::size_t best = begin;
  double most = -1;
  for (std::size_t i = begin; i < end; i += std::max<std::size_t>(1, (end - begin) / 12)) {
    const GreyPicture coarse = solver.pyramid(solver.frames[solver.training[i]]).back();
    double energy = 0;
    for (int y = 0; y + 1 < coarse.height; ++y)
      for (int x = 0; x + 1 < coarse.width; ++x) {
        const double a = *coarse.at(x, y), dx = *coarse.at(x + 1, y) - a, dy = *coarse.at(x, y + 1) - a;
        if (dx == dx && dy == dy) energy += std::min(400.0, dx * dx + dy * dy);  // an edge more is no better
      }
    if (energy > most) most = energy, best = i;
  }
  return best;
}

// Aligns the training frames one after the other to a mosaic that grows with them.
Result<void> place_along(Solver& solver, const Progress& progress) {
  GrowingMosaic mosaic(solver.reference, solver.levels);
  const std::size_t count = solver.training.size(), first = first_frame(solver);
  std::size_t done = 0;
  const auto begin = [&](std::size_t i) {
    Solving& frame = solver.frames[solver.training[i]];
    frame.placed = true;
    mosaic.add(solver.pyramid(frame)[0], frame.aligned);
    return frame.aligned;
  };
  const AlignedView origin = begin(first);
  constexpr double kApart = 1;       // px: a frame this far from the last adds something
  constexpr std::size_t kEvery = 4;  // frames: and one in so many, for noise
  for (const bool ahead : {true, false}) {
    Trail trail;
    trail.last = origin;
    HandheldView added = origin.view;
    std::size_t waiting = 0;
    for (std::size_t i = first; ahead ? ++i < count : i-- > 0;) {
      if (solver.stop.stop_requested()) return cancelled_error();
      Solving& frame = solver.frames[solver.training[i]];
      if (frame.background < kLeastBackground) continue;
      const auto picture = solver.pyramid(frame);
      ViewPrior prior = solver.prior();
      double badness = 1;
      AlignedView view = find_view(picture, solver.reference, mosaic.target(), prior, trail.starts(),
                                   trail.usual_badness(), badness);
      measure_view(picture, solver.reference, mosaic.target(), prior, view);
      frame.placed = is_found(view);
      frame.aligned = frame.placed ? view : *trail.last;
      if (frame.placed) {
        trail.follow(view, badness);
        const ViewStep step = view_step(added, view.view);
        const double px = solver.reference.fx * step.head<3>().norm() + step.tail<2>().norm() +
                          solver.reference.width / 2.0 * std::abs(step[3]);
        if (px > kApart || ++waiting >= kEvery) {
          mosaic.add(picture[0], view);
          added = view.view;
          waiting = 0;
        }
      }
      progress.report(double(++done) / double(count), fmt::format("frame {}", frame.given->frame));
    }
  }
  return {};
}

// Turns the world so that the placed training frames look straight ahead on average, and scales zooms so that
// their median is 1. The mosaic is rebuilt and all realigned thereafter, so that neither need be exact.
void centre_views(Solver& solver) {
  std::vector<Mat3d> turns;
  std::vector<double> zooms, gains, biases;
  for (const std::size_t i : solver.training) {
    const Solving& frame = solver.frames[i];
    if (!frame.placed) continue;
    turns.push_back(frame.aligned.view.turn);
    zooms.push_back(frame.aligned.view.log_zoom);
    gains.push_back(frame.aligned.gain);
    biases.push_back(frame.aligned.bias);
  }
  if (turns.empty()) return;
  const Mat3d straight = mean_rotation(turns).transpose();
  const double zoom = median(std::move(zooms)), gain = median(std::move(gains)),
               bias = median(std::move(biases));
  for (Solving& frame : solver.frames) {
    // A longer lens needs a smaller turn to move the picture as far.
    Vec3d turn = vector_from_turn(frame.aligned.view.turn * straight);
    turn.head<2>() *= std::exp(zoom);
    frame.aligned.view.turn = turn_from_vector(turn);
    frame.aligned.view.log_zoom -= zoom;
    // A mosaic of gain * values + bias.
    frame.aligned.bias -= bias * frame.aligned.gain / gain;
    frame.aligned.gain /= gain;
  }
}

ViewTarget rebuild_mosaic(const Solver& solver) {
  std::vector<std::size_t> placed;
  std::vector<HandheldView> views;
  for (const std::size_t i : solver.training)
    if (solver.frames[i].placed) placed.push_back(i), views.push_back(solver.frames[i].aligned.view);
  const auto chosen = covering_views(solver.reference, views, solver.options.median_of);
  std::vector<GreyPicture> pictures(chosen.size());
  std::vector<AlignedFrame> frames(chosen.size());
  parallel_for(chosen.size(), [&](std::size_t i) {
    const Solving& frame = solver.frames[placed[chosen[i]]];
    pictures[i] = grey_picture(*frame.given->grey, frame.given->person, kSpoiltRim);
    frames[i] = {&pictures[i], frame.aligned};
  });
  return median_mosaic(frames, solver.reference, solver.levels);
}

// Where the neighbours in time, as they are, let a training frame be expected; nullopt at a lone one.
std::optional<HandheldView> expected_view(const Solver& solver, std::size_t at) {
  const auto time = [&](std::size_t i) { return solver.frames[solver.training[i]].given->time_s; };
  const auto placed = [&](std::size_t i) { return solver.frames[solver.training[i]].placed; };
  const auto view = [&](std::size_t i) { return solver.frames[solver.training[i]].aligned.view; };
  const auto shot = [&](std::size_t i) { return solver.frames[solver.training[i]].given->shot; };
  std::size_t before = at, after = at + 1;
  while (before > 0 && !placed(before - 1)) --before;
  while (after < solver.training.size() && !placed(after)) ++after;
  const bool has_before = before > 0 && shot(before - 1) == shot(at),
             has_after = after < solver.training.size() && shot(after) == shot(at);
  if (has_before && has_after) {
    const double whole = time(after) - time(before - 1);
    const double share = whole > 0 ? (time(at) - time(before - 1)) / whole : 0.5;
    return part_of_way(view(before - 1), view(after), std::clamp(share, 0.0, 1.0));
  }
  if (has_before) return view(before - 1);
  if (has_after) return view(after);
  return std::nullopt;
}

// Realigns every training frame to one mosaic, all at once; the largest movement of all but the worst 5 %,
// px.
double realign(Solver& solver, const ViewTarget& target) {
  std::vector<AlignedView> next(solver.training.size());
  std::vector<char> found(next.size(), 0);
  std::vector<double> moved(next.size(), 0);
  parallel_for(next.size(), [&](std::size_t i) {
    const Solving& frame = solver.frames[solver.training[i]];
    next[i] = frame.aligned;
    if (solver.stop.stop_requested()) return;
    if (frame.background < kLeastBackground) return;
    const auto picture = solver.pyramid(frame);
    ViewPrior prior = solver.prior();
    const auto expected = expected_view(solver, i);
    if (expected) {
      prior.expected = *expected;
      prior.smooth_px = solver.options.smooth_px;
    }
    if (frame.placed) {
      next[i] = align_view(picture, solver.reference, target, frame.aligned, prior,
                           std::min(2, solver.levels - 1), 0);
    } else {
      AlignedView start = frame.aligned;
      if (expected) start.view = *expected;
      double badness = 1;
      ViewPrior free = prior;
      free.smooth_px = 0;
      next[i] = find_view(picture, solver.reference, target, free, {start}, 0, badness);
    }
    measure_view(picture, solver.reference, target, prior, next[i]);
    found[i] = is_found(next[i]);
    const ViewStep step = view_step(frame.aligned.view, next[i].view);
    moved[i] = std::hypot(step[1] * solver.reference.fx + step[4], step[5] - step[0] * solver.reference.fx);
  });
  for (std::size_t i = 0; i < next.size(); ++i) {
    Solving& frame = solver.frames[solver.training[i]];
    if (frame.background < kLeastBackground) continue;
    frame.placed = found[i];
    frame.aligned = next[i];
  }
  return quantile(std::move(moved), 0.95);
}

// A guess for frames that were not found: between their neighbours.
void fill_gaps(Solver& solver) {
  std::vector<std::pair<std::size_t, HandheldView>> guesses;
  for (std::size_t i = 0; i < solver.training.size(); ++i)
    if (!solver.frames[solver.training[i]].placed)
      if (const auto expected = expected_view(solver, i)) guesses.emplace_back(solver.training[i], *expected);
  for (const auto& [i, view] : guesses) solver.frames[i].aligned.view = view;
}

// Each frame held out, by its own picture and the finished mosaic alone. The nearest training frames and the
// frame held out before it only say where to begin.
void place_held_out(Solver& solver, const ViewTarget& target) {
  std::vector<std::pair<std::size_t, std::size_t>> stretches;  // consecutive frames held out
  for (std::size_t i = 0; i < solver.frames.size(); ++i) {
    if (!solver.frames[i].given->held_out) continue;
    if (stretches.empty() || stretches.back().second != i) stretches.emplace_back(i, i);
    stretches.back().second = i + 1;
  }
  parallel_for(stretches.size(), [&](std::size_t s) {
    const auto [begin, end] = stretches[s];
    const Solving* before = begin > 0 ? &solver.frames[begin - 1] : nullptr;
    const Solving* after = end < solver.frames.size() ? &solver.frames[end] : nullptr;
    const AlignedView from = before ? before->aligned : after->aligned,
                      to = after ? after->aligned : before->aligned;
    Trail trail;
    trail.last = from;
    for (std::size_t i = begin; i < end && !solver.stop.stop_requested(); ++i) {
      Solving& frame = solver.frames[i];
      auto starts = trail.starts();
      AlignedView between = from;
      between.view = part_of_way(from.view, to.view, double(i - begin + 1) / double(end - begin + 1));
      starts.push_back(between);
      frame.aligned = between;
      if (frame.background < kLeastBackground) continue;
      const auto picture = solver.pyramid(frame);
      double badness = 1;
      AlignedView view = find_view(picture, solver.reference, target, solver.prior(), starts,
                                   trail.usual_badness(), badness);
      measure_view(picture, solver.reference, target, solver.prior(), view);
      frame.placed = is_found(view);
      if (!frame.placed) continue;
      frame.aligned = view;
      trail.follow(view, badness);
    }
  });
}

// The frames placed, as pairs see them.
struct PlacedPairs {
  std::vector<HandheldView> views;
  std::vector<ViewPair> pairs;
  PairPictures pictures;  // of `views`
};
PlacedPairs placed_pairs(const Solver& solver) {
  PlacedPairs placed;
  std::vector<std::size_t> frames;
  for (const std::size_t i : solver.training)
    if (solver.frames[i].placed) frames.push_back(i), placed.views.push_back(solver.frames[i].aligned.view);
  placed.pairs = distant_pairs(solver.reference, placed.views);
  placed.pictures.reference = solver.reference;
  placed.pictures.views = placed.views;
  placed.pictures.pyramids.resize(frames.size());
  for (const ViewPair& pair : placed.pairs)
    for (const std::size_t i : {pair.first, pair.second})
      if (placed.pictures.pyramids[i].empty())
        placed.pictures.pyramids[i] = solver.pyramid(solver.frames[frames[i]]);
  return placed;
}

// By how much the second model explains a pair better than the first: median of the differences, nats.
double median_gain(const PairFits& first, const PairFits& second) {
  std::vector<double> gains;
  for (std::size_t i = 0; i < first.nats.size(); ++i) gains.push_back(first.nats[i] - second.nats[i]);
  return median(std::move(gains));
}

// What a lens and a turn explain needs no shift.
struct ChosenModel {
  bool shifts = false;
  double focal = 1;        // of the reference's
  double focal_sigma = 0;  // 0: not found
};
ChosenModel choose_model(const Solver& solver) {
  // Far more than two unknowns fit of noise, or a distorting lens feigns.
  constexpr double kShiftGain = 50;  // nats a pair; one that is needed brings hundreds
  constexpr double kLensSigma = 0.02;
  ChosenModel chosen;
  const PlacedPairs placed = placed_pairs(solver);
  if (placed.pairs.empty()) return chosen;
  const auto fits = [&](double focal, bool shifts) {
    return fit_pairs(placed.pictures, placed.pairs, {focal, shifts}, solver.stop);
  };
  const PairFits as_is = fits(1, false);
  PairLens lens;
  if (solver.options.lens_sigma > 0)
    lens = lens_of_pairs(placed.pictures, placed.pairs, solver.options.lens_sigma, solver.stop);
  PairFits turning = as_is;
  if (lens.sigma < kLensSigma) {
    turning = fits(lens.focal, false);
    // Of a camera that travels, near and far bend the pictures.
    if (median(turning.misfit_px) < misfit_limit_px(solver.reference))
      chosen.focal = lens.focal, chosen.focal_sigma = lens.sigma;
    else
      turning = as_is;
  }
  const PairFits shifting = fits(1, true);
  chosen.shifts = median_gain(turning, shifting) > kShiftGain &&
                  median(shifting.misfit_px) < misfit_limit_px(solver.reference);
  // A turn is told from a shift by the lens; a clip does not tell the lens as well.
  if (chosen.shifts) chosen.focal = 1, chosen.focal_sigma = 0;
  return chosen;
}

HandheldCamera camera_of(const Solving& frame) {
  const AlignedView& at = frame.aligned;
  HandheldCamera camera;
  camera.frame = frame.given->frame;
  camera.rotation = vector_from_turn(at.view.turn);
  camera.zoom = std::exp(at.view.log_zoom);
  camera.shift_px = at.view.shift;
  camera.gain = at.gain, camera.bias = at.bias;
  camera.held_out = frame.given->held_out;
  camera.found = frame.placed;
  if (!frame.placed) return camera;
  camera.residual = at.residual;
  camera.overlap = at.overlap;
  camera.certainty = at.inliers;
  camera.sigma_px = at.sigma_px;
  camera.parts = at.parts;
  return camera;
}

// 95th percentile of how far the background is from its usual place, in 1/1000 of the width: the mean over
// nine places of the picture. Of the frames that can tell: on a blank wall a view wanders with the noise.
double strayed(const HandheldSolve& solve) {
  constexpr int kSide = 3;
  std::array<std::vector<double>, kSide * kSide> us, vs;
  for (const HandheldCamera& camera : solve.cameras) {
    if (!camera.found || camera.parts < kPartsToTell) continue;
    const auto map = view_map<double>(solve.reference, solve.reference, handheld_view(camera));
    for (int i = 0; i < kSide * kSide; ++i) {
      const auto place = view_place(map, solve.reference.width * (0.5 + i % kSide) / kSide,
                                    solve.reference.height * (0.5 + i / kSide) / kSide);
      us[std::size_t(i)].push_back(place.u), vs[std::size_t(i)].push_back(place.v);
    }
  }
  if (us[0].empty()) return 0;
  std::vector<double> strays(us[0].size(), 0);
  for (std::size_t p = 0; p < us.size(); ++p) {
    const double u = median(us[p]), v = median(vs[p]);
    for (std::size_t i = 0; i < strays.size(); ++i)
      strays[i] += std::hypot(us[p][i] - u, vs[p][i] - v) / double(us.size());
  }
  return 1000 * quantile(std::move(strays), 0.95) / solve.reference.width;
}

std::string evidence_of(const HandheldSolve& solve) {
  std::string text = fmt::format(
      "The background strays by {:.1f} thousandths of the picture's width, zoom {:.3f} to {:.3f}{}. One "
      "mosaic explains {:.0f} % of {} frames to {:.1f} grey values (noise {:.1f}); in pairs of frames far "
      "apart parts of it lie {:.2f} px off the model (limit {:.2f}), and its texture places it to {:.3f} px.",
      solve.motion, solve.zoom_low, solve.zoom_high, solve.shifts ? ", and the picture's middle shifts" : "",
      100 * solve.explained, solve.cameras.size(), solve.residual, solve.noise, solve.misfit_px,
      misfit_limit_px(solve.reference), solve.sigma_px);
  if (solve.focal_sigma > 0)
    text += fmt::format(" Its turns tell a focal length of {:.3f} of the picture's width (to {:.1f} %).",
                        solve.reference.fx / solve.reference.width, 100 * solve.focal_sigma);
  return text;
}

HandheldSolve summarised(const Solver& solver) {
  HandheldSolve solve;
  solve.reference = solver.reference;
  solve.shifts = solver.shifts;
  solve.focal_sigma = solver.focal_sigma;
  std::vector<HandheldView> views;
  std::vector<double> residuals, zooms, sigmas, misfits, noises;
  std::size_t found = 0, told = 0, misfitting = 0;
  for (const Solving& frame : solver.frames) {
    solve.cameras.push_back(camera_of(frame));
    const HandheldCamera& camera = solve.cameras.back();
    if (!camera.found) continue;
    ++found;
    views.push_back(frame.aligned.view);
    residuals.push_back(camera.residual);
    zooms.push_back(camera.zoom);
    sigmas.push_back(camera.sigma_px);
    told += camera.parts >= kPartsToTell;
  }
  const PlacedPairs placed = placed_pairs(solver);
  const PairFits fits = fit_pairs(placed.pictures, placed.pairs, {1, solver.shifts}, solver.stop);
  for (const double misfit : fits.misfit_px) {
    if (misfit < 0) continue;
    misfits.push_back(misfit);
    misfitting += misfit > misfit_limit_px(solver.reference);
  }
  constexpr std::size_t kNoiseFrames = 12;
  for (std::size_t i = 0; i < solver.frames.size(); i += solver.frames.size() / kNoiseFrames + 1)
    noises.push_back(
        pixel_noise(grey_picture(*solver.frames[i].given->grey, solver.frames[i].given->person, kSpoiltRim)));
  solve.extent = mosaic_extent(solver.reference, views);
  solve.noise = median(std::move(noises));
  solve.residual = median(std::move(residuals));
  solve.explained = double(found) / double(solver.frames.size());
  solve.zoom_low = found ? quantile(zooms, 0.02) : 1;
  solve.zoom_high = found ? quantile(zooms, 0.98) : 1;
  solve.sigma_px = quantile(std::move(sigmas), 0.75);
  solve.judged = found ? double(told) / double(found) : 0;
  solve.misfitting = misfits.empty() ? 0 : double(misfitting) / double(misfits.size());
  solve.misfit_px = median(std::move(misfits));
  solve.motion = strayed(solve);
  solve.evidence = evidence_of(solve);
  return solve;
}

Result<Solver> prepared(std::span<const HandheldFrame> given, const Intrinsics& reference,
                        const HandheldOptions& options) {
  const auto refuse = [](std::string what) {
    return Error{ErrorCode::bad_input, std::move(what),
                 "Film the person in front of a background that shows.", "camera"};
  };
  Solver solver;
  solver.options = options;
  bool any = false;
  for (const HandheldFrame& frame : given) {
    if (!frame.grey || frame.grey->channels != 1 || frame.grey->width != given[0].grey->width ||
        frame.grey->height != given[0].grey->height || std::min(frame.grey->width, frame.grey->height) < 32)
      return refuse(fmt::format("Frame {} has no grey picture of the first one's size.", frame.frame));
    Solving solving;
    solving.given = &frame;
    const GreyPicture picture = grey_picture(*frame.grey, frame.person, kSpoiltRim);
    std::size_t known = 0;
    for (const float value : picture.data) known += value == value;
    solving.background = double(known) / double(picture.pixels());
    if (!frame.held_out) {
      solver.training.push_back(solver.frames.size());
      any |= solving.background >= kLeastBackground;
    }
    solver.frames.push_back(solving);
  }
  if (!any) return refuse("No training frame shows any background beside the person.");
  const int width = given[0].grey->width, height = given[0].grey->height;
  solver.reference = resized({0, reference}, width).intrinsics;
  solver.reference.height = height;  // a reduced picture's is rounded
  solver.reference.k1 = solver.reference.k2 = solver.reference.p1 = solver.reference.p2 = 0;
  solver.levels = pyramid_levels(width, height);
  return solver;
}

}  // namespace

// Rebuilds the mosaic and aligns to it, until nothing moves more.
Result<void> close_rounds(Solver& solver, const Progress& progress) {
  for (int round = 0; round < solver.options.rounds; ++round) {
    centre_views(solver);
    const ViewTarget target = rebuild_mosaic(solver);
    const double moved = realign(solver, target);
    if (solver.stop.stop_requested()) return cancelled_error();
    progress.report(double(round + 1) / solver.options.rounds, fmt::format("round {}", round + 1));
    constexpr double kStill = 0.03;  // px
    if (moved < kStill) break;
  }
  return {};
}

// Every training frame's view, from nothing.
Result<void> settle(Solver& solver, const Progress& progress) {
  if (auto placed = place_along(solver, progress.stage(0, 0.6, "background")); !placed) return placed.error();
  return close_rounds(solver, progress.stage(0.6, 1, "background"));
}

Result<HandheldSolve> solve_handheld(std::span<const HandheldFrame> frames, const Intrinsics& reference,
                                     const HandheldOptions& options, const Progress& progress,
                                     std::stop_token stop) {
  auto prepared_solver = prepared(frames, reference, options);
  if (!prepared_solver) return prepared_solver.error();
  Solver& solver = *prepared_solver;
  solver.stop = stop;
  if (auto placed = settle(solver, progress.stage(0, 0.45, "background")); !placed) return placed.error();
  progress.report(0.45, "lens");
  const ChosenModel model = choose_model(solver);
  if (stop.stop_requested()) return cancelled_error();
  const Progress again = progress.stage(0.5, 0.9, "camera's turns");
  if (model.shifts) {
    solver.shifts = true;
    for (Solving& frame : solver.frames) frame.aligned = {}, frame.placed = false;
    if (auto placed = settle(solver, again); !placed) return placed.error();
  } else if (model.focal != 1) {
    solver.reference.fx *= model.focal, solver.reference.fy *= model.focal;
    solver.focal_sigma = model.focal_sigma;
    for (Solving& frame : solver.frames)
      frame.aligned.view = with_longer_lens(frame.aligned.view, model.focal);
    if (auto closed = close_rounds(solver, again); !closed) return closed.error();
  }
  progress.report(0.9, "held-out frames");
  fill_gaps(solver);
  place_held_out(solver, rebuild_mosaic(solver));
  HandheldSolve solve = summarised(solver);
  if (stop.stop_requested()) return cancelled_error();
  progress.report(1);
  return solve;
}

}  // namespace likeness
