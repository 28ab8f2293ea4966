// See strokes.h.
#include "core/matte/strokes.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr double kRim = 0.25;  // of the radius, over which a brush fades; at least a pixel

// Squared distance of a point to a segment.
double squared_distance(const Vec2d& p, const Vec2d& a, const Vec2d& b) {
  const Vec2d along = b - a, to = p - a;
  const double length = along.squaredNorm();
  const double at = length > 0 ? std::clamp(to.dot(along) / length, 0.0, 1.0) : 0.0;
  return (to - at * along).squaredNorm();
}

// The pixels [first, last) along an axis that a brush between two places can reach.
struct Reach {
  int first = 0, last = 0;
  Reach(double a, double b, double radius, int size)
      : first(int(std::clamp(std::floor(std::min(a, b) - radius), 0.0, double(size)))),
        last(int(std::clamp(std::ceil(std::max(a, b) + radius), 0.0, double(size)))) {}
};

double rim_of(double radius) { return std::max(1.0, kRim * radius); }

// Lays a stroke's cover over what earlier strokes say, and clears the cover for the next one.
void lay_over(StrokeCover& all, Image& stroke, StrokeMark mark) {
  for (std::size_t i = 0; i < stroke.data.size(); ++i) {
    const float c = stroke.data[i];
    if (c == 0) continue;
    stroke.data[i] = 0;
    all.person.data[i] = all.person.data[i] * (1 - c) + (mark == StrokeMark::person ? c : 0);
    all.background.data[i] = all.background.data[i] * (1 - c) + (mark == StrokeMark::background ? c : 0);
  }
}

}  // namespace

void cover_segment(Image& cover, const Vec2d& from, const Vec2d& to, double radius) {
  const double rim = rim_of(radius), far = radius + 0.5 * rim;
  const Reach rows(from.y(), to.y(), far, cover.height), columns(from.x(), to.x(), far, cover.width);
  for (int y = rows.first; y < rows.last; ++y)
    for (int x = columns.first; x < columns.last; ++x) {
      const double squared = squared_distance({x + 0.5, y + 0.5}, from, to);
      if (squared >= far * far) continue;
      const double covered = std::clamp((radius - std::sqrt(squared)) / rim + kSurelyCovered, 0.0, 1.0);
      float& value = *cover.at(x, y);
      value = std::max(value, float(covered));
    }
}

StrokeCover cover_strokes(std::span<const Stroke> strokes, const SquareCrop& crop, int size) {
  LIKENESS_CHECK(size > 0 && crop.side > 0, "a crop of %d px to %d px", crop.side, size);
  if (strokes.empty()) return {};
  const double scale = double(size) / crop.side;
  const Vec2d corner(crop.x, crop.y);
  StrokeCover all{Image(size, size, 1), Image(size, size, 1)};
  Image one(size, size, 1);
  for (const Stroke& stroke : strokes) {
    if (stroke.points.empty()) continue;
    Vec2d before = scale * (stroke.points.front() - corner);
    for (const Vec2d& point : stroke.points) {
      const Vec2d at = scale * (point - corner);
      cover_segment(one, before, at, scale * stroke.radius);
      before = at;
    }
    lay_over(all, one, stroke.mark);
  }
  return all;
}

void apply_strokes(const StrokeCover& cover, Image8& alpha) {
  if (cover.empty()) return;
  LIKENESS_CHECK(alpha.channels == 1 && alpha.data.size() == cover.person.data.size(),
                 "an alpha of %d x %d px under strokes of %d px", alpha.width, alpha.height,
                 cover.person.width);
  for (std::size_t i = 0; i < alpha.data.size(); ++i) {
    const float person = cover.person.data[i], kept = 1 - person - cover.background.data[i];
    const float value = kept * float(alpha.data[i]) + 255 * person;
    alpha.data[i] = std::uint8_t(std::clamp(std::lround(value), 0l, 255l));
  }
}

}  // namespace likeness
