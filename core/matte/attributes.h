// What somebody painted to make an attribute (core/render/attribute.h): on a few frames where it is, and how
// much of it they show. Regions are strokes (strokes.h), of which `person` paints and the others take away.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/matte/strokes.h"

namespace likeness {

struct AttributeAnnotation {
  int frame = 0;     // number in the source
  double value = 0;  // -1..1, 0: as the person mostly is
  Strokes region;    // may be empty: the frame only says how much of it there is

  bool operator==(const AttributeAnnotation&) const = default;
};

struct PaintedAttribute {
  std::string name;
  std::vector<AttributeAnnotation> annotations;  // ascending by frame, one a frame

  bool operator==(const PaintedAttribute&) const = default;
};
using PaintedAttributes = std::vector<PaintedAttribute>;

// A name that can be typed behind `--action`: letters, digits, spaces, - and _, 1 to 40 of them.
Result<void> check_attribute_name(std::string_view name);

// Sets a frame's annotation; makes the attribute where there is none of that name.
void annotate(PaintedAttributes& attributes, std::string_view name, AttributeAnnotation annotation);
// Takes a frame's annotation back, the attribute with its last one; frame -1: all of it. Whether there was
// one.
bool take_back(PaintedAttributes& attributes, std::string_view name, int frame = -1);

// The annotation of a frame, or null.
const AttributeAnnotation* find_annotation(const PaintedAttributes& attributes, std::string_view name,
                                           int frame);

// `theirs` with what `mine` changed since `base`, annotation by annotation; where both changed one, mine. In
// my order, what only they have last.
PaintedAttributes merge_attributes(const PaintedAttributes& base, const PaintedAttributes& mine,
                                   PaintedAttributes theirs);

// Strokes that cover what a mask does: one channel in the source's pixels, of which those over 127 count. A
// rim of about a pixel is rounded off.
Strokes strokes_of_mask(const Image8& mask);
// Strokes that fill a box: x0, y0, x1, y1 in the source's pixels, half open.
Strokes strokes_of_box(const Vec2d& low, const Vec2d& high);

// attributes.json: written whole or not at all. A file that is none, damaged or newer is refused with a
// remedy; it stays as it is.
Result<void> write_attributes(const std::filesystem::path& path, const PaintedAttributes& attributes);
Result<PaintedAttributes> read_attributes(const std::filesystem::path& path);

}  // namespace likeness
