// See find_cuts.h.
#include "core/capture/find_cuts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/parallel.h"

namespace likeness {
namespace {

constexpr std::ptrdiff_t kAround = 5;  // frames to either side that a cut is compared with
constexpr double kStill = 0.33;        // px that a cell may move unheeded: noise, breath, a coder's key frame
constexpr double kLeast = 0.05;    // of a share: a cell that rests says no more than one that hardly moves
constexpr double kMost = 2;        // px: beyond, a cell shows something else
constexpr int kFlash = 4;          // frames within which a picture returns after a flash
constexpr double kReturned = 0.5;  // of its way
// -- Gradual transitions.
constexpr std::array<int, 9> kLengths{4,  6,  8,  12, 16,
                                      24, 32, 48, 64};  // frames from a picture to the one after
constexpr double kUnlike = 0.5, kShown = 3;  // correlation below which a cell shows something else; levels
constexpr double kChanged = 0.2;             // of the picture must
constexpr double kUnmixed = 0.25;   // of the difference between both pictures that a mixture may leave
constexpr double kBack = 0.06;      // of the way a mixture may go back
constexpr double kBare = 0.04;      // of the other picture: none of it is seen
constexpr std::size_t kLooks = 12;  // frames between the two that are looked at

using Sketches = std::span<const FrameSketch>;

constexpr double kClearly = 1.3;  // times as far as in the frames around: a cell that stands out by itself
constexpr double kOfHead = 0.3;  // of what is to be seen in the picture of the head; the wall beside it rests

// The usual share by which the cells move further than in the frames around; 0 where nothing is known. The
// frame around in which a cell moves most does not count: it may begin or end a shot, too.
struct StandingOut {
  double usual = 0;    // geometric mean over the cells
  double clearly = 0;  // share of the cells that stand out by themselves
};

StandingOut share_of(Sketches film, std::size_t i, CellChange FrameSketch::*part) {
  const CellChange& own = film[i].*part;
  std::vector<const CellChange*> around;
  for (std::ptrdiff_t step = -kAround; step <= kAround; ++step) {
    const std::ptrdiff_t j = std::ptrdiff_t(i) + step;
    if (step == 0 || j < 0 || j >= std::ptrdiff_t(film.size())) continue;
    const CellChange& other = film[std::size_t(j)].*part;
    if (other.moved.size() == own.moved.size()) around.push_back(&other);
  }
  if (own.moved.empty() || around.size() < 2) return {};
  double sum = 0, weight = 0, clear = 0;
  for (std::size_t c = 0; c < own.moved.size(); ++c) {
    float most = 0, second = 0;
    for (const CellChange* other : around) {
      const float moved = other->moved[c];
      if (moved > most)
        second = most, most = moved;
      else
        second = std::max(second, moved);
    }
    const double share = own.moved[c] / (second + kStill);
    sum += own.gradient[c] * std::log(std::max(kLeast, share));
    weight += own.gradient[c];
    if (share > kClearly) clear += own.gradient[c];
  }
  if (weight <= 0.1 * double(own.moved.size())) return {};  // nothing is to be seen
  return {std::exp(sum / weight), clear / weight};
}

double way_between(const FrameSketch& a, const FrameSketch& b) {
  return mean_motion(compare_cells(a.luma, b.luma, kSketchCell), kMost);
}

// Shortly afterwards the picture is what it was before, or shortly before what it is now.
bool is_flash(Sketches film, std::size_t cut) {
  const double way = way_between(film[cut - 1], film[cut]);
  for (std::size_t k = 1; k <= std::size_t(kFlash); ++k) {
    if (cut + k < film.size() && way_between(film[cut - 1], film[cut + k]) < kReturned * way) return true;
    if (cut > k && way_between(film[cut - 1 - k], film[cut]) < kReturned * way) return true;
  }
  return false;
}

// Frame by frame: whether it begins a shot.
std::vector<std::uint8_t> sharp_cuts(Sketches film) {
  std::vector<std::uint8_t> cuts(film.size(), 0);
  parallel_for(film.size(), [&](std::size_t i) { cuts[i] = stands_out(film, i) >= 1; });
  for (std::size_t i = 1; i < film.size(); ++i)
    if (cuts[i] && is_flash(film, i)) cuts[i] = 0;
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

// Whether the frames between these two lead from the one to the other by mixing; then those that are mixed
// are marked.
void mark_mixed(Sketches film, std::size_t from, std::size_t to, std::vector<std::uint8_t>& mixed) {
  const Changed changed = changed_between(film[from], film[to]);
  if (changed.share < kChanged) return;
  const Image8 &a = film[from].luma, &b = film[to].luma;
  const std::size_t step = std::max<std::size_t>(1, (to - from - 1) / kLooks);
  double last = 0;
  bool halfway = false;
  for (std::size_t t = from + 1; t < to; t += step) {
    const Mixture m = unmix(changed, a, b, film[t].luma);
    if (m.left_over > kUnmixed || m.share < last - kBack || m.share > 1 + kBack) return;
    last = std::max(last, m.share);
    halfway |= m.share > 0.25 && m.share < 0.75;
  }
  if (!halfway) return;
  for (std::size_t t = from + 1; t < to; ++t) {
    const double share = unmix(changed, a, b, film[t].luma).share;
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
  if (i == 0) return 0;
  const StandingOut whole = share_of(film, i, &FrameSketch::whole),
                    head = share_of(film, i, &FrameSketch::head);
  return std::max({whole.usual, head.usual, head.clearly / kOfHead});
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
