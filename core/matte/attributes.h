// What the user painted to make an attribute (core/render/attribute.h): on a few frames its region, and how
// much of it they show. Regions are strokes (strokes.h), of which `person` adds and the others remove.
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
  Strokes region;    // may be empty: the frame then only gives an amount

  bool operator==(const AttributeAnnotation&) const = default;
};

struct PaintedAttribute {
  std::string name;
  std::vector<AttributeAnnotation> annotations;  // ascending by frame, one per frame

  bool operator==(const PaintedAttribute&) const = default;
};
using PaintedAttributes = std::vector<PaintedAttribute>;

// A name that can be typed after `--action`: letters, digits, spaces, - and _, 1 to 40 of them.
Result<void> check_attribute_name(std::string_view name);

// Sets a frame's annotation; creates the attribute if there is none of that name.
void annotate(PaintedAttributes& attributes, std::string_view name, AttributeAnnotation annotation);
// Removes a frame's annotation, and the attribute with its last one; frame -1: all of it. Returns whether
// there was one.
bool take_back(PaintedAttributes& attributes, std::string_view name, int frame = -1);

// The annotation of a frame, or null.
const AttributeAnnotation* find_annotation(const PaintedAttributes& attributes, std::string_view name,
                                           int frame);

// `theirs` with what `mine` changed since `base`, annotation by annotation; where both changed one, `mine`
// wins. In `mine`'s order, followed by what only `theirs` has.
PaintedAttributes merge_attributes(const PaintedAttributes& base, const PaintedAttributes& mine,
                                   PaintedAttributes theirs);

// Strokes that cover the same as a mask: one channel in the source's pixels, of which those over 127 count. A
// rim of about a pixel is rounded off.
Strokes strokes_of_mask(const Image8& mask);
// Strokes that fill a box: x0, y0, x1, y1 in the source's pixels, half open.
Strokes strokes_of_box(const Vec2d& low, const Vec2d& high);

// attributes.json: written whole or not at all. A file of another kind, damaged or newer is refused with a
// remedy and left unchanged.
Result<void> write_attributes(const std::filesystem::path& path, const PaintedAttributes& attributes);
Result<PaintedAttributes> read_attributes(const std::filesystem::path& path);

}  // namespace likeness
