// See sketch_film.h.
#include "core/capture/sketch_film.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/capture/place_picture.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

constexpr double kLongerSide = 96;            // px
constexpr int kHeadSide = 48, kHeadCell = 6;  // px
constexpr double kBesideHead = 0.35, kAboveHead = 0.5,
                 kBelowHead = 0.35;  // of the face's width: head and hair
constexpr double kMostWhole = 2;     // px: a cell that moved further has no place in a shake of the camera
// A shake of the camera moves everything: it explains the picture, or there was none.
constexpr int kShakes = 6;                             // px of the sketch in 1/25 s
constexpr double kExplains = 0.95, kWorthALook = 0.5;  // of the motion; levels

int whole_cells(double px) { return std::max(2, int(std::lround(px / kSketchCell))) * kSketchCell; }

struct Shift {
  double x = 0, y = 0;  // px
};

// Mean difference of what is not the person, the picture before moved by (dx, dy), apart from brightness.
class Difference {
 public:
  Difference(const Image8& before, const Image8& after, const std::optional<PersonFigure>& person)
      : before_(before), after_(after) {
    for (int y = 0; y < after.height; y += 2)
      for (int x = 0; x < after.width; x += 2)
        if (!person || !person->holds((x + 0.5) / after.width, (y + 0.5) / after.height))
          places_.emplace_back(x, y);
  }
  bool enough() const { return places_.size() > 100; }

  double at(int dx, int dy) const {
    double sum = 0, own = 0;
    int count = 0;
    const auto each = [&](const auto& take) {
      for (const auto& [x, y] : places_) {
        const int u = x - dx, v = y - dy;
        if (u < 0 || v < 0 || u >= before_.width || v >= before_.height) continue;
        take(double(*after_.at(x, y)) - double(*before_.at(u, v)));
      }
    };
    each([&](double d) { own += d, ++count; });
    if (count == 0) return 1e9;
    own /= count;
    each([&](double d) { sum += std::abs(d - own); });
    return sum / count;
  }

 private:
  const Image8 &before_, &after_;
  std::vector<std::pair<int, int>> places_;
};

double lowest_between(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend > 1e-9 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

// How the background moved between two sketches, if it did.
Shift shake(const Image8& before, const Image8& after, const std::optional<PersonFigure>& person) {
  const Difference difference(before, after, person);
  if (!difference.enough()) return {};
  const double still = difference.at(0, 0);
  if (still < kWorthALook) return {};
  double least = still;
  int x = 0, y = 0;
  for (int dy = -kShakes; dy <= kShakes; ++dy)
    for (int dx = -kShakes; dx <= kShakes; ++dx)
      if (const double d = difference.at(dx, dy); d < least) least = d, x = dx, y = dy;
  return {x + lowest_between(difference.at(x - 1, y), least, difference.at(x + 1, y)),
          y + lowest_between(difference.at(x, y - 1), least, difference.at(x, y + 1))};
}

// Head and hair of a face, source px.
PixelRect head_part(const FaceBox& face) {
  const double w = face.width;
  return {int(std::lround(face.x - kBesideHead * w)), int(std::lround(face.y - kAboveHead * w)),
          std::max(8, int(std::lround((1 + 2 * kBesideHead) * w))),
          std::max(8, int(std::lround(face.height + (kAboveHead + kBelowHead) * w)))};
}

// How the head in that part of a frame moved since the one before, apart from the camera's shake (source px),
// to the part of a pixel: of a small picture, half a pixel is a jump.
CellChange head_change(const Image8& before, const Image8& after, const PixelRect& part, const Shift& shift) {
  PixelRect earlier = part;
  earlier.x -= int(std::lround(shift.x)), earlier.y -= int(std::lround(shift.y));
  const Image8 now = resize(crop(after, part), kHeadSide, kHeadSide),
               then = resize(crop(before, earlier), kHeadSide, kHeadSide);
  if (shift.x == 0 && shift.y == 0) return compare_cells(then, now, kHeadCell);
  const double across = double(kHeadSide) / part.width, down = double(kHeadSide) / part.height;
  const Placed rest{(shift.x - std::round(shift.x)) * across, (shift.y - std::round(shift.y)) * down};
  return compare_cells(placed_picture(then, rest), now, kHeadCell);
}

}  // namespace

PersonFigure person_figure(const FaceBox& face, int width, int height) {
  constexpr double kHeadroom = 0.6, kHair = 0.4, kShoulders = 1;  // of the face's width, beside it
  const double w = face.width;
  return {
      {(face.x - kHair * w) / width, (face.x + (1 + kHair) * w) / width, (face.y - kHeadroom * w) / height},
      {(face.x - kShoulders * w) / width, (face.x + (1 + kShoulders) * w) / width,
       (face.y + face.height) / height}};
}

FilmSketcher::FilmSketcher(const VideoInfo& info) {
  const double scale = kLongerSide / std::max({1, info.width, info.height});
  width_ = whole_cells(info.width * scale), height_ = whole_cells(info.height * scale);
}

void FilmSketcher::add(const VideoFrame& frame, const std::optional<FaceBox>& face) {
  FrameSketch sketch{frame.index, frame.time_s, resize(frame.rgb, width_, height_)};
  sketch.shape = frame.shape;
  const bool follows =
      !before_.empty() && before_.width == frame.rgb.width && before_.height == frame.rgb.height;
  if (face) {
    const double across = double(width_) / frame.rgb.width, down = double(height_) / frame.rgb.height;
    sketch.face = FaceBox{face->x * across, face->y * down, face->width * across, face->height * down, 0};
  }
  if (follows) {
    const Image8& before = sketches_.back().luma;
    std::optional<PersonFigure> person;
    if (face) person = person_figure(*face, frame.rgb.width, frame.rgb.height);
    Shift shift = shake(before, sketch.luma, person);
    sketch.whole = compare_cells(before, sketch.luma, kSketchCell);
    if (shift.x != 0 || shift.y != 0) {
      CellChange steadied =
          compare_cells(placed_picture(before, {shift.x, shift.y}), sketch.luma, kSketchCell);
      if (mean_motion(steadied, kMostWhole) < kExplains * mean_motion(sketch.whole, kMostWhole))
        sketch.whole = std::move(steadied);
      else
        shift = {};
    }
    if (face) {
      const double scale = double(frame.rgb.width) / width_, down = double(frame.rgb.height) / height_;
      sketch.head = head_change(before_, frame.rgb, head_part(*face), {shift.x * scale, shift.y * down});
    }
  }
  before_ = frame.rgb;
  sketches_.push_back(std::move(sketch));
}

std::vector<FrameSketch> FilmSketcher::take() {
  before_ = {};
  return std::move(sketches_);
}

}  // namespace likeness
