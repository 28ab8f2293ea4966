// See find_cuts.h.
#include "core/capture/find_cuts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>

#include "core/base/parallel.h"
#include "core/capture/place_picture.h"

namespace likeness {
namespace {

// -- A cut that all of the picture shows.
constexpr std::size_t kAround = 5;  // frames to either side that it is compared with
constexpr double kAnyTime_s = 1e9;
constexpr double kStill = 0.33;  // px that a cell may move unheeded: noise, breath, a coder's key frame
constexpr double kLeast = 0.05;  // of a share: a cell that rests says no more than one that hardly moves
constexpr double kBlank = 0.1;   // levels per px, on the mean: less shows nothing
// -- A cut in place, where the wall rests and the head jumps: cells of the head move many times as far as
// they do in the tenths of a second around, and further than nearly all of what they do in the seconds
// around.
constexpr double kNear_s = 0.4, kFar_s = 2;  // to either side
constexpr double kSeldom = 1.0 / 30;         // of the frames in these seconds move further
constexpr std::size_t kEdge = 3;             // frames of a film that must lie before and behind
constexpr double kStillHead = 0.05;          // px of the picture of the head, 48 across
constexpr double kJump = 2;                  // times as far; of frames that are 1/25 s apart
constexpr double kRepeat = 0.02;             // px: the frame before was shown once more, so this is two steps
constexpr std::size_t kMostRepeats = 2;
constexpr double kHeadJump = 0.065;  // mean of the logarithms of the excess; a blink is half of it at most
// -- A flash.
constexpr double kMost = 2;        // px: beyond, a cell shows something else
constexpr std::size_t kFlash = 4;  // frames within which a picture returns after a flash
constexpr double kReturned = 0.5;  // of its way
// -- Gradual transitions.
constexpr std::array<int, 9> kLengths{4,  6,  8,  12, 16,
                                      24, 32, 48, 64};  // frames from a picture to the one after
constexpr double kUnlike = 0.5, kShown = 3;  // correlation below which a cell shows something else; levels
constexpr double kChanged = 0.2;             // of the picture must
constexpr double kAsUsual = 0.5;             // of that, just before or after
constexpr double kUnmixed = 0.25;      // of the difference between both pictures that a mixture may leave
constexpr double kBack = 0.06;         // of the way a mixture may go back
constexpr double kMoved = 0.4;         // of that difference, which a motion of the camera leaves
constexpr double kBare = 0.04;         // of the other picture: none of it is seen
constexpr std::size_t kLooks = 12;     // frames between the two that are looked at
constexpr std::size_t kLeastLook = 4;  // frames before or after that say how the film moves

using Sketches = std::span<const FrameSketch>;

// The changes within a time of frame i, its own left out, of those that are like its own.
std::vector<const CellChange*> changes_around(Sketches film, std::size_t i, CellChange FrameSketch::*part,
                                              double reach_s) {
  const std::size_t cells = (film[i].*part).moved.size();
  std::vector<const CellChange*> around;
  const auto take = [&](const FrameSketch& frame) {
    if ((frame.*part).moved.size() == cells) around.push_back(&(frame.*part));
  };
  for (std::size_t j = i; j-- > 0 && film[i].time_s - film[j].time_s <= reach_s;) take(film[j]);
  for (std::size_t j = i + 1; j < film.size() && film[j].time_s - film[i].time_s <= reach_s; ++j)
    take(film[j]);
  return around;
}

// What a cell moves in the frames around, px: the n-th farthest, counted from 0. The farthest of all may
// begin or end a shot, too.
double moved_around(const std::vector<const CellChange*>& around, std::size_t cell, std::size_t n,
                    std::vector<float>& moved) {
  moved.clear();
  for (const CellChange* other : around) moved.push_back(other->moved[cell]);
  const auto at = moved.begin() + std::ptrdiff_t(std::min(n, moved.size() - 1));
  std::ranges::nth_element(moved, at, std::ranges::greater());
  return double(*at);
}

bool shows_something(const CellChange& change) {
  double weight = 0;
  for (const float gradient : change.gradient) weight += double(gradient);
  return weight > kBlank * double(change.gradient.size());
}

// The usual share by which the cells of the picture move further than in the frames around: their geometric
// mean. 0 where nothing is known.
double whole_stands_out(Sketches film, std::size_t i) {
  const CellChange& own = film[i].whole;
  const std::size_t from = i - std::min(i, kAround);
  const Sketches near = film.subspan(from, std::min(film.size() - from, i - from + kAround + 1));
  const auto around = changes_around(near, i - from, &FrameSketch::whole, kAnyTime_s);
  if (own.moved.empty() || around.size() < 2 || !shows_something(own)) return 0;
  double sum = 0, weight = 0;
  std::vector<float> moved;
  for (std::size_t c = 0; c < own.moved.size(); ++c) {
    const double share = double(own.moved[c]) / (moved_around(around, c, 1, moved) + kStill);
    sum += double(own.gradient[c]) * std::log(std::max(kLeast, share));
    weight += double(own.gradient[c]);
  }
  return std::exp(sum / weight);
}

// How many times as far as before a frame may move because of its distance from the last one that shows
// something new: who starts to move is the faster the longer nobody looks.
double allowed_for_step(Sketches film, std::size_t i) {
  std::size_t last = i - 1;
  for (std::size_t repeats = 0; repeats < kMostRepeats && last > 0; ++repeats, --last)
    if (film[last].head.moved.empty() || mean_motion(film[last].head, kMost) >= kRepeat) break;
  return kJump * std::sqrt(std::max(1.0, 25 * (film[i].time_s - film[last].time_s)));
}

// How far the head moves beyond what it does around, as the mean over its cells of the logarithm.
double head_jump(Sketches film, std::size_t i) {
  const CellChange& own = film[i].head;
  // What begins at the very end of a film is as well the begin of a motion.
  if (own.moved.empty() || !shows_something(own) || i < kEdge || i + kEdge >= film.size()) return 0;
  const auto near = changes_around(film, i, &FrameSketch::head, kNear_s),
             far = changes_around(film, i, &FrameSketch::head, kFar_s);
  if (near.size() < 2) return 0;
  const double allowed = allowed_for_step(film, i);
  const std::size_t seldom =
      std::max<std::size_t>(1, std::size_t(std::lround(kSeldom * double(far.size())))) - 1;
  double excess = 0, weight = 0;
  std::vector<float> moved;
  for (std::size_t c = 0; c < own.moved.size(); ++c) {
    const double usual = std::max(allowed * (moved_around(near, c, 1, moved) + kStillHead),
                                  moved_around(far, c, seldom, moved));
    excess += double(own.gradient[c]) * std::log(std::max(1.0, double(own.moved[c]) / usual));
    weight += double(own.gradient[c]);
  }
  return excess / weight;
}

// Of the two pictures, or of the head in them.
double way_between(const FrameSketch& a, const FrameSketch& b, const std::optional<FaceBox>& head) {
  if (!head) return mean_motion(compare_cells(a.luma, b.luma, kSketchCell), kMost);
  constexpr int kSide = 24, kCell = 6;
  const auto cut_out = [&](const Image8& picture) {
    return resize(
        crop(picture, int(std::lround(head->x)), int(std::lround(head->y)),
             std::max(4, int(std::lround(head->width))), std::max(4, int(std::lround(head->height)))),
        kSide, kSide);
  };
  return mean_motion(compare_cells(cut_out(a.luma), cut_out(b.luma), kCell), kMost);
}

// Shortly afterwards the picture is what it was before, or shortly before what it is now. cuts: as found so
// far. A head that returns jumps twice; one jump alone is no flash, whatever few pixels of a small head say.
bool is_flash(Sketches film, const std::vector<std::uint8_t>& cuts, std::size_t cut) {
  const std::size_t from = cut - std::min(cut, kFlash), to = std::min(film.size(), cut + kFlash + 1);
  const bool of_head = whole_stands_out(film, cut) < 1;
  if (of_head && std::count(cuts.begin() + std::ptrdiff_t(from), cuts.begin() + std::ptrdiff_t(to), 1) < 2)
    return false;
  const auto head = of_head ? film[cut].face : std::nullopt;
  const double way = way_between(film[cut - 1], film[cut], head);
  for (std::size_t k = 1; k <= kFlash; ++k) {
    if (cut + k < film.size() && way_between(film[cut - 1], film[cut + k], head) < kReturned * way)
      return true;
    if (cut > k && way_between(film[cut - 1 - k], film[cut], head) < kReturned * way) return true;
  }
  return false;
}

// Frame by frame: whether it begins a shot.
std::vector<std::uint8_t> sharp_cuts(Sketches film) {
  std::vector<std::uint8_t> found(film.size(), 0);
  parallel_for(film.size(), [&](std::size_t i) { found[i] = stands_out(film, i) >= 1; });
  std::vector<std::uint8_t> cuts = found;
  for (std::size_t i = 1; i < film.size(); ++i)
    if (film[i].shape != film[i - 1].shape)
      cuts[i] = 1;
    else if (found[i] && is_flash(film, found, i))
      cuts[i] = 0;
  return cuts;
}

// The pixels in which a picture and a later one show something else.
struct Changed {
  std::vector<std::size_t> pixels;
  double share = 0;  // of all that the two show
};

Changed changed_between(const FrameSketch& a, const FrameSketch& b) {
  const CellChange change = compare_cells(a.luma, b.luma, kSketchCell);
  const int columns = a.luma.width / kSketchCell;
  Changed changed;
  double all = 1e-9;
  for (std::size_t c = 0; c < change.alike.size(); ++c) {
    if (change.contrast[c] < kShown) continue;
    all += double(change.contrast[c]);
    if (change.alike[c] >= kUnlike) continue;
    changed.share += double(change.contrast[c]);
    const int left = int(c) % columns * kSketchCell, top = int(c) / columns * kSketchCell;
    for (int y = top; y < top + kSketchCell; ++y)
      for (int x = left; x < left + kSketchCell; ++x)
        changed.pixels.push_back(std::size_t(y) * std::size_t(a.luma.width) + std::size_t(x));
  }
  changed.share /= all;
  return changed;
}

// Of a picture that may be a mixture: how much of the later one is in it, and what it leaves unexplained.
struct Mixture {
  double share = 0, left_over = 0;  // left_over: of the difference between the two
};

Mixture unmix(const Changed& changed, const Image8& a, const Image8& b, const Image8& between) {
  double along = 0, way = 1e-9, off = 0;
  for (const std::size_t p : changed.pixels) {
    const double d = double(b.data[p]) - a.data[p], e = double(between.data[p]) - a.data[p];
    along += d * e, way += d * d, off += e * e;
  }
  const double share = along / way;
  return {share, std::sqrt(std::max(0.0, off - share * along) / way)};
}

// Whether the frames between these two, which show something else where they changed, lead from the one to
// the other by mixing.
bool leads_by_mixing(Sketches film, std::size_t from, std::size_t to, const Changed& changed) {
  const Image8 &a = film[from].luma, &b = film[to].luma;
  const std::size_t step = std::max<std::size_t>(1, (to - from - 1) / kLooks);
  double last = 0;
  bool halfway = false;
  for (std::size_t t = from + 1; t < to; t += step) {
    const Mixture m = unmix(changed, a, b, film[t].luma);
    if (m.left_over > kUnmixed || m.share < last - kBack || m.share > 1 + kBack) return false;
    last = std::max(last, m.share);
    halfway |= m.share > 0.25 && m.share < 0.75;
  }
  return halfway;
}

// Whether the camera swayed, panned or zoomed from the one to the other: of a smooth wall, such as one out of
// focus, the pictures on the way look like mixtures.
bool leads_by_motion(Sketches film, std::size_t from, std::size_t to, const Changed& changed) {
  const Image8 &a = film[from].luma, &b = film[to].luma;
  std::vector<std::uint8_t> free(b.data.size(), 0);
  for (const std::size_t p : changed.pixels) free[p] = 1;
  const Image8 moved = placed_picture(a, place_in(a, b, free));
  double way = 1e-9, left = 0;
  for (const std::size_t p : changed.pixels) {
    const double before = double(b.data[p]) - a.data[p], after = double(b.data[p]) - moved.data[p];
    way += before * before, left += after * after;
  }
  return left < kMoved * kMoved * way;
}

// Marks the frames between these two that are mixtures of both.
void mark_mixed(Sketches film, std::size_t from, std::size_t to, std::vector<std::uint8_t>& mixed) {
  const Changed changed = changed_between(film[from], film[to]);
  if (changed.share < kChanged || !leads_by_mixing(film, from, to, changed)) return;
  // Where as much changes in the same way before or after, it is how the film moves.
  const std::size_t length = to - from;
  const auto as_usual = [&](std::size_t first, std::size_t last) {
    if (last < first + kLeastLook) return false;
    const Changed there = changed_between(film[first], film[last]);
    return there.share * double(length) > kAsUsual * changed.share * double(last - first) &&
           leads_by_mixing(film, first, last, there);
  };
  if (as_usual(from - std::min(from, length), from) || as_usual(to, std::min(to + length, film.size() - 1)))
    return;
  if (leads_by_motion(film, from, to, changed)) return;
  for (std::size_t t = from + 1; t < to; ++t) {
    const double share = unmix(changed, film[from].luma, film[to].luma, film[t].luma).share;
    if (share > kBare && share < 1 - kBare) mixed[t] = 1;
  }
}

std::vector<std::uint8_t> mixed_frames(Sketches film) {
  std::vector<std::vector<std::uint8_t>> found(kLengths.size());
  parallel_for(kLengths.size(), [&](std::size_t k) {
    found[k].assign(film.size(), 0);
    const std::size_t length = std::size_t(kLengths[k]), step = std::max<std::size_t>(1, length / 8);
    for (std::size_t from = 0; from + length < film.size(); from += step)
      mark_mixed(film, from, from + length, found[k]);
  });
  std::vector<std::uint8_t> mixed(film.size(), 0);
  for (const auto& marks : found)
    for (std::size_t i = 0; i < mixed.size(); ++i) mixed[i] |= marks[i];
  return mixed;
}

}  // namespace

double stands_out(Sketches film, std::size_t i) {
  return i == 0 ? 0 : std::max(whole_stands_out(film, i), head_jump(film, i) / kHeadJump);
}

std::vector<FrameSpan> find_shots(Sketches film) {
  std::vector<FrameSpan> shots;
  const std::vector<std::uint8_t> cuts = sharp_cuts(film), mixed = mixed_frames(film);
  bool begins = true;
  for (std::size_t i = 0; i < film.size(); ++i) {
    if (mixed[i]) {
      begins = true;
      continue;
    }
    // Frames that were not looked at go with the shot before them.
    if (!begins && cuts[i]) shots.back().last = film[i].frame - 1;
    if (begins || cuts[i]) shots.push_back({film[i].frame, film[i].frame});
    shots.back().last = film[i].frame;
    begins = false;
  }
  return shots;
}

}  // namespace likeness
