// See choose_shots.h.
#include "core/capture/choose_shots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>

#include "core/base/quantile.h"
#include "core/capture/find_cuts.h"
#include "core/capture/picture_cells.h"
#include "core/capture/place_picture.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

constexpr double kShotFaceShare = 0.3;  // of a shot's looks
constexpr double kShortest_s = 0.3;     // a shorter shot tells a track nothing that a longer one does not
constexpr int kShortest = 5;            // frames, and
constexpr std::size_t kViews = 15;      // frames that a median is taken of
constexpr std::size_t kEnds = 3;        // frames before and after a cut
constexpr double kOften = 0.3;          // of the looks at a shot: where nobody is for longer is background
// -- Whether two backgrounds are one. px of the sketch, 96 across.
constexpr double kDisplaced = 8;                  // by which a hand wanders, or somebody nudges a tripod
constexpr double kSameScale = 0.03;               // a punch-in begins at a twentieth
constexpr double kAlike = 0.6, kMostCells = 0.6;  // correlation; share of what is to be seen
constexpr double kMostOfPerson = 0.4;             // of head and clothes, which move
constexpr std::size_t kPartOfCell = 16;           // px of a cell that are free: fewer say nothing
constexpr double kTexture = 15;  // levels, summed over cells: with less there is nothing to compare
constexpr double kFree = 0.03;   // of the picture: the least that says anything
constexpr double kSameLevel = 12, kSameFace = 1.15;  // levels, and ratio of the faces, before a plain wall

struct Background {
  Image8 luma;
  std::vector<std::uint8_t> free;  // a pixel: 1 where nobody is
  double face = 0;                 // width, px of the source; 0: none
};

struct SketchedFilm {
  std::span<const FrameSketch> frames;
  const std::vector<FaceSample>& samples;
  int width, height;

  std::span<const FrameSketch> of(const FrameSpan& span) const {
    const auto from = std::ranges::lower_bound(frames, span.first, {}, &FrameSketch::frame),
               to = std::ranges::upper_bound(frames, span.last, {}, &FrameSketch::frame);
    return {from, to};
  }
};

// The median of some frames of a stretch, and where nobody is in any of them.
Background background_of(const SketchedFilm& film, std::span<const FrameSketch> stretch,
                         const FrameSpan& shot, std::size_t views) {
  Background background;
  const std::size_t n = std::min(views, stretch.size());
  background.luma = Image8(stretch[0].luma.width, stretch[0].luma.height, 1);
  std::vector<float> values(n);
  for (std::size_t p = 0; p < background.luma.data.size(); ++p) {
    for (std::size_t k = 0; k < n; ++k)
      values[k] = stretch[(2 * k + 1) * stretch.size() / (2 * n)].luma.data[p];
    background.luma.data[p] = std::uint8_t(std::lround(median(values)));
  }
  const std::size_t pixels = background.luma.data.size();
  std::vector<int> covered(pixels, 0);
  std::vector<double> widths;
  for (const FaceSample& sample : film.samples) {
    if (!sample.face || sample.frame < shot.first || sample.frame > shot.last) continue;
    widths.push_back(sample.face->width);
    const PersonFigure person = person_figure(*sample.face, film.width, film.height);
    const int w = background.luma.width, h = background.luma.height;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        covered[std::size_t(y) * w + x] += person.holds((x + 0.5) / w, (y + 0.5) / h);
  }
  background.free.resize(pixels);
  for (std::size_t p = 0; p < pixels; ++p)
    background.free[p] = double(covered[p]) <= kOften * double(widths.size());
  background.face = median(std::move(widths));
  return background;
}

// What two pictures, which are one but for brightness and contrast, share in the free pixels.
struct Likeness {
  double shown = 0, alike = 0;  // levels, summed over the cells: of all, and of those that correlate
};

// Of one cell's free pixels.
void add_cell(const Image8& a, const Image8& b, const std::vector<std::uint8_t>& free, int left, int top,
              Likeness& likeness) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int y = top; y < top + kSketchCell; ++y)
    for (int x = left; x < left + kSketchCell; ++x) {
      if (!free[std::size_t(y) * std::size_t(a.width) + std::size_t(x)]) continue;
      const double u = *a.at(x, y), v = *b.at(x, y);
      n += 1, sa += u, sb += v, saa += u * u, sbb += v * v, sab += u * v;
    }
  if (n < double(kPartOfCell)) return;
  const double va = std::max(0.0, saa / n - sa / n * (sa / n)),
               vb = std::max(0.0, sbb / n - sb / n * (sb / n)), together = sab / n - sa / n * (sb / n);
  // Of flat cells the correlation is that of noise.
  const double shown = std::clamp(std::sqrt(std::max(va, vb)) - 2, 0.0, 22.0);
  likeness.shown += shown;
  if (together > kAlike * std::sqrt((va + 4) * (vb + 4))) likeness.alike += shown;
}

Likeness likeness_of(const Image8& a, const Image8& b, const std::vector<std::uint8_t>& free) {
  Likeness likeness;
  for (int top = 0; top < a.height; top += kSketchCell)
    for (int left = 0; left < a.width; left += kSketchCell) add_cell(a, b, free, left, top, likeness);
  return likeness;
}

enum class Same { no, yes, unknown };

// Whether both show the same in the free pixels, but for what a hand does.
Same same_picture(const Background& a, const Background& b, const std::vector<std::uint8_t>& free,
                  double share) {
  const Placed at = place_in(a.luma, b.luma, free);
  const Likeness likeness = likeness_of(placed_picture(a.luma, at), b.luma, free);
  if (likeness.shown < kTexture) return Same::unknown;
  const bool placed = std::hypot(at.x, at.y) <= kDisplaced && std::abs(at.scale) <= kSameScale;
  return placed && likeness.alike > share * likeness.shown ? Same::yes : Same::no;
}

Same same_background(const Background& a, const Background& b) {
  std::vector<std::uint8_t> free(a.free);
  double count = 0, level = 0;
  for (std::size_t p = 0; p < free.size(); ++p) {
    free[p] &= b.free[p];
    if (free[p]) level += double(a.luma.data[p]) - b.luma.data[p], ++count;
  }
  if (count < kFree * double(free.size())) return Same::unknown;
  const Same same = same_picture(a, b, free, kMostCells);
  return same == Same::unknown && std::abs(level / count) > kSameLevel ? Same::no : same;
}

// A plain wall, or a face that fills the picture, says nothing: then the face keeps its size, and head and
// clothes look as they did.
bool same_place(const Background& a, const Background& b) {
  const Same same = same_background(a, b);
  if (same != Same::unknown) return same == Same::yes;
  if (a.face <= 0 || b.face <= 0 || std::max(a.face, b.face) > kSameFace * std::min(a.face, b.face))
    return false;
  return same_picture(a, b, std::vector<std::uint8_t>(a.luma.data.size(), 1), kMostOfPerson) != Same::no;
}

// What the looks at a shot say of its faces.
struct Seen {
  int looks = 0, faces = 0;
  double share() const { return looks > 0 ? double(faces) / looks : 0; }
};

Seen seen_in(const std::vector<FaceSample>& samples, const FrameSpan& shot) {
  Seen seen;
  for (const FaceSample& sample : samples) {
    if (sample.frame < shot.first || sample.frame > shot.last) continue;
    ++seen.looks;
    seen.faces += sample.face.has_value();
  }
  return seen;
}

// The shots by the place they were filmed from, those that are unfit left out. Two are of one place where
// they look alike, as a whole or where they meet - a camera that wanders is where it was at a cut, and
// nowhere else.
std::vector<std::vector<std::size_t>> places_of(const SketchedFilm& film, const std::vector<FrameSpan>& shots,
                                                const std::vector<std::uint8_t>& fit) {
  std::vector<Background> whole(shots.size());
  for (std::size_t i = 0; i < shots.size(); ++i)
    if (fit[i]) whole[i] = background_of(film, film.of(shots[i]), shots[i], kViews);
  const auto meet = [&](std::size_t i, std::size_t j) {
    const auto before = film.of(shots[i]), after = film.of(shots[j]);
    return same_place(background_of(film, before.last(std::min(kEnds, before.size())), shots[i], kEnds),
                      background_of(film, after.first(std::min(kEnds, after.size())), shots[j], kEnds));
  };
  std::vector<std::uint8_t> open = fit;
  std::vector<std::vector<std::size_t>> places;
  for (std::size_t first = 0; first < shots.size(); ++first) {
    if (!open[first]) continue;
    std::vector<std::size_t>& place = places.emplace_back(1, first);
    open[first] = 0;
    for (std::size_t k = 0; k < place.size(); ++k)
      for (std::size_t j = 0; j < shots.size(); ++j) {
        const std::size_t i = place[k];
        if (!open[j] || film.of(shots[i]).front().shape != film.of(shots[j]).front().shape) continue;
        const bool neighbours = j == i + 1 || i == j + 1;
        if (!same_place(whole[i], whole[j]) && !(neighbours && meet(std::min(i, j), std::max(i, j))))
          continue;
        open[j] = 0;
        place.push_back(j);
      }
  }
  return places;
}

}  // namespace

std::vector<ClipShot> choose_shots(std::span<const FrameSketch> frames,
                                   const std::vector<FaceSample>& samples,
                                   const std::vector<FrameSpan>& shots, int width, int height) {
  const SketchedFilm film{frames, samples, width, height};
  std::vector<ClipShot> out;
  std::vector<std::uint8_t> fit(shots.size(), 0);
  std::vector<double> seconds(shots.size(), 0);  // with a face
  const double rate = frames.size() > 1 && frames.back().time_s > frames.front().time_s
                          ? double(frames.size() - 1) / (frames.back().time_s - frames.front().time_s)
                          : 25;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const auto own = film.of(shots[i]);
    ClipShot& shot = out.emplace_back();
    shot.used = false, shot.first = shots[i].first, shot.last = shots[i].last;
    shot.from_s = own.front().time_s, shot.to_s = own.back().time_s + 1 / rate;
    const Seen seen = seen_in(samples, shots[i]);
    seconds[i] = seen.share() * (shot.to_s - shot.from_s);
    const bool brief = own.size() < kShortest || shot.to_s - shot.from_s < kShortest_s;
    fit[i] = !brief && seen.share() >= kShotFaceShare;
    shot.reason = brief                           ? fmt::format("it has only {} frames", own.size())
                  : seen.share() < kShotFaceShare ? "no face"
                                                  : "another place, angle or crop";
  }
  const auto with_face = [&](const std::vector<std::size_t>& place) {
    double sum = 0;
    for (const std::size_t i : place) sum += seconds[i];
    return sum;
  };
  std::vector<std::vector<std::size_t>> places;
  if (shots.size() > 1) places = places_of(film, shots, fit);
  const auto most = std::ranges::max_element(places, {}, with_face);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].used = most == places.end() || std::ranges::find(*most, i) != most->end();
    if (out[i].used) out[i].reason.clear();
  }
  return out;
}

std::vector<ClipShot> shots_of(const ClipScan& scan, const PixelRect& film, bool photographs) {
  std::vector<FrameSpan> found;
  if (!photographs) found = find_shots(scan.film);
  if (found.size() > 1) {
    std::vector<FaceSample> samples = scan.samples;  // in the film, as the sketches are
    for (FaceSample& sample : samples)
      if (sample.face) sample.face->x -= film.x, sample.face->y -= film.y;
    return choose_shots(scan.film, samples, found, scan.info.width, scan.info.height);
  }
  std::vector<ClipShot> one;
  if (scan.frames.empty()) return one;
  const double rate = std::max(1.0, scan.info.frames_per_second);
  FrameSpan all{scan.frames.front().frame, scan.frames.back().frame};
  if (found.size() == 1) all = found[0];  // a fade at its begin or end is not in it
  const auto time_of = [&](int frame) {
    return std::ranges::lower_bound(scan.frames, frame, {}, &CaptureFrame::frame)->time_s;
  };
  one.push_back({all.first, all.last, time_of(all.first), time_of(all.last) + 1 / rate, true, ""});
  return one;
}

std::vector<FrameSpan> every_shot(const ClipScan& scan) {
  std::vector<FrameSpan> shots = find_shots(scan.film);
  if (shots.size() < 2) return {};
  // Frames that the scan passed over, before the first cut and after the last look, are tracked, too.
  shots.back().last += sampling_stride(scan.info);
  return shots;
}

std::string span_words(double from_s, double to_s) {
  const auto clock = [](double s) {
    const int whole = int(std::lround(s));
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
  };
  return clock(from_s) + "-" + clock(to_s);
}

std::string serving_words(const std::vector<ClipShot>& shots) {
  // Cuts in place are of no concern here.
  std::vector<std::pair<double, double>> stretches;
  bool before = false;
  for (const ClipShot& shot : shots) {
    if (shot.used && before)
      stretches.back().second = shot.to_s;
    else if (shot.used)
      stretches.emplace_back(shot.from_s, shot.to_s);
    before = shot.used;
  }
  std::string words;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    if (i > 0) words += i + 1 == stretches.size() ? " and " : ", ";
    words += span_words(stretches[i].first, stretches[i].second);
  }
  return words;
}

std::string counted_words(const std::vector<ClipShot>& shots) {
  double left_out = 0;
  for (const ClipShot& shot : shots)
    if (!shot.used) left_out += shot.to_s - shot.from_s;
  if (left_out <= 0) return "";
  return fmt::format(
      "The clip is cut: of it {} serves; the other {:.1f} s show another place, angle or crop, or no face.",
      serving_words(shots), left_out);
}

}  // namespace likeness
