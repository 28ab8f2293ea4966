// Choice of the square crop: see choose_crop.h. Proportions are of the detector's box, which runs from the
// brows to the chin.
#include "core/capture/choose_crop.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/quantile.h"

namespace likeness {
namespace {

constexpr double kAbove = 0.6, kBelow = 1.1, kBeside = 1.0;               // head and shoulders
constexpr double kHeadAbove = 0.5, kHeadBelow = 0.2, kHeadBeside = 0.25;  // the head alone
constexpr double kBelowChin = 0.08;   // what a head must have below it before a crop leaves the film
constexpr double kNearlyWhole = 0.9;  // of the picture's shorter side: from there on the crop takes all of it

struct Extent {
  double left = 1e30, top = 1e30, right = -1e30, bottom = -1e30;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
};

Extent extent_of(const std::vector<FaceBox>& faces, double beside, double above, double below) {
  Extent e;
  for (const FaceBox& f : faces) {
    e.left = std::min(e.left, f.x - beside * f.width);
    e.right = std::max(e.right, f.x + (1 + beside) * f.width);
    e.top = std::min(e.top, f.y - above * f.height);
    e.bottom = std::max(e.bottom, f.y + (1 + below) * f.height);
  }
  return e;
}

// A box of half or double the usual size, or one that appears alone far from all others, is a mistake.
std::vector<FaceBox> plausible(const std::vector<FaceBox>& faces) {
  std::vector<double> widths;
  for (const FaceBox& f : faces) widths.push_back(f.width);
  const double usual = median(widths);
  const auto near = [&](const FaceBox& a, const FaceBox& b) {
    return std::hypot(a.x + a.width / 2 - b.x - b.width / 2, a.y + a.height / 2 - b.y - b.height / 2) <
           1.2 * usual;
  };
  std::vector<FaceBox> kept;
  for (const FaceBox& f : faces) {
    const auto company =
        std::count_if(faces.begin(), faces.end(), [&](const FaceBox& g) { return near(f, g); });
    const bool alone =
        faces.size() >= 10 && company < std::max<std::ptrdiff_t>(2, std::ptrdiff_t(faces.size() / 50));
    if (f.width > 0.55 * usual && f.width < 1.8 * usual && !alone) kept.push_back(f);
  }
  return kept.empty() ? faces : kept;
}

// The detector's boxes jump by a step of its scales from look to look while the head is at rest: each is
// replaced by the medians of five looks, a second, about it.
std::vector<FaceBox> steadied(const std::vector<FaceBox>& faces) {
  constexpr std::size_t kReach = 2;  // looks to either side
  std::vector<FaceBox> steady;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    std::vector<double> x, y, width, height;
    const std::size_t window = std::min(faces.size(), 2 * kReach + 1),
                      first = std::min(i - std::min(i, kReach), faces.size() - window);
    for (std::size_t j = first; j < first + window; ++j) {
      x.push_back(faces[j].x + faces[j].width / 2), y.push_back(faces[j].y + faces[j].height / 2);
      width.push_back(faces[j].width), height.push_back(faces[j].height);
    }
    const double w = median(width), h = median(height);
    steady.push_back({median(x) - w / 2, median(y) - h / 2, w, h, faces[i].score});
  }
  return steady;
}

// What the camera did not see needs no room.
Extent filmed(Extent e, double width, double height) {
  return {std::max(e.left, 0.0), std::max(e.top, 0.0), std::min(e.right, width), std::min(e.bottom, height)};
}

// Start of an interval of length `side` that covers [begin, end], moved into [0, limit] as far as it can be.
int place(double start, double side, int limit) {
  const double last = limit - side;
  return int(std::lround(last >= 0 ? std::clamp(start, 0.0, last) : last / 2));
}

// faces: px of a picture of width x height, all of which was filmed.
SquareCrop crop_within(const std::vector<FaceBox>& faces, int width, int height) {
  const Extent bust = extent_of(faces, kBeside, kAbove, kBelow);
  Extent head = filmed(extent_of(faces, kHeadBeside, kHeadAbove, kHeadBelow), width, height);
  const double shorter = std::min(width, height);
  double side = std::max(bust.width(), bust.height());
  if (side >= kNearlyWhole * shorter) {
    side = std::max({shorter, head.width(), head.height()});
    if (side > shorter) {
      const std::vector<FaceBox> steady = steadied(faces);
      head = filmed(extent_of(steady, kHeadBeside, kHeadAbove, kHeadBelow), width, height);
      const Extent least = filmed(extent_of(steady, kHeadBeside, kHeadAbove, kBelowChin), width, height);
      side = std::max({shorter, least.width(), least.height()});
    }
  }
  side = std::ceil(side);

  // Sideways the heads are centred. Downwards the top of the head counts, and what is lost is chest; but no
  // chin, if the room above the hair can do without.
  const double x = (bust.left + bust.right) / 2 - side / 2;
  double y = bust.height() <= side ? (bust.top + bust.bottom) / 2 - side / 2 : bust.top;
  if (y + side < head.bottom) y = std::min(head.top, head.bottom - side);
  return {place(x, side, width), place(y, side, height), int(side)};
}

}  // namespace

CropChoice choose_crop(const std::vector<FaceBox>& all_faces, const PixelRect& film) {
  LIKENESS_CHECK(!all_faces.empty() && !film.empty(), "crop of %zu faces in %d x %d", all_faces.size(),
                 film.width, film.height);
  std::vector<FaceBox> faces = plausible(all_faces);
  for (FaceBox& face : faces) face.x -= film.x, face.y -= film.y;
  CropChoice choice;
  choice.crop = crop_within(faces, film.width, film.height);
  choice.crop.x += film.x, choice.crop.y += film.y;
  const auto cut =
      std::count_if(faces.begin(), faces.end(), [](const FaceBox& f) { return f.y - 0.35 * f.height < 0; });
  choice.head_cut_share = double(cut) / double(faces.size());
  return choice;
}

}  // namespace likeness
