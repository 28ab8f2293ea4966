// What the user painted on a frame's picture to correct its matte: strokes as data, their file, and which
// pixels they cover.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/image/image.h"

namespace likeness {

// What a stroke says about the pixels under it; erase: cancels the strokes before it there.
enum class StrokeMark { person, background, erase };

// A round brush moved along a polyline; a single point is a dab. In the source's pixels, so that neither the
// pictures' size nor their crop changes their meaning.
struct Stroke {
  StrokeMark mark = StrokeMark::person;
  double radius = 1;          // px of the source, > 0
  std::vector<Vec2d> points;  // px of the source, pixel centres at one half; at least one

  bool operator==(const Stroke&) const = default;
};
using Strokes = std::vector<Stroke>;          // of one frame, in the order they were painted
using FrameStrokes = std::map<int, Strokes>;  // by the frame's number in the source
inline constexpr double kSurelyCovered =
    0.5;  // of a cover: from this value on the stroke is a hard constraint

// How far strokes cover each pixel of a picture: 1 inside, falling to 0 over the brush's soft rim.
struct StrokeCover {
  Image person, background;  // (size, size, 1), 0..1, together at most 1
  bool empty() const { return person.empty(); }
};

// The strokes on the crop's picture of size x size px. No strokes: an empty cover. What lies outside the crop
// is left out. Cost: the area of each segment's surroundings.
StrokeCover cover_strokes(std::span<const Stroke> strokes, const SquareCrop& crop, int size);

// Adds a segment of a brush to a cover (h, w, 1) of its own stroke. from, to, radius: px of the cover.
void cover_segment(Image& cover, const Vec2d& from, const Vec2d& to, double radius);

// The alpha that the strokes require: 255 under the person's, 0 under the background's, mixed on their rims.
// alpha: one channel, of the cover's size. An empty cover changes nothing.
void apply_strokes(const StrokeCover& cover, Image8& alpha);

// A frame's strokes as JSON, written whole or not at all. A file of another kind, damaged or newer is refused
// with a remedy and left unchanged.
Result<void> write_strokes(const std::filesystem::path& path, std::span<const Stroke> strokes);
Result<Strokes> read_strokes(const std::filesystem::path& path);

}  // namespace likeness
