// Painted attributes: edits, regions from masks and boxes, and their file.
#include "core/matte/attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/matte/strokes_text.h"

namespace likeness {

namespace {

using nlohmann::json;

constexpr int kAttributesVersion = 1;
constexpr std::size_t kLongestName = 40;
constexpr int kMaskRows = 100;  // of strokes into which a mask is turned, approximately

auto named(PaintedAttributes& attributes, std::string_view name) {
  return std::ranges::find_if(attributes, [&](const PaintedAttribute& a) { return a.name == name; });
}

// A brush stroke of this radius along the middle line of a rectangle it may not leave, or a dab in its
// middle.
Stroke band(double x0, double x1, double y, double radius) {
  const double inner = std::max(0.0, 0.5 * (x1 - x0) - radius), middle = 0.5 * (x0 + x1);
  Stroke stroke{StrokeMark::person, radius, {{middle - inner, y}}};
  if (inner > 0) stroke.points.emplace_back(middle + inner, y);
  return stroke;
}

}  // namespace

Result<void> check_attribute_name(std::string_view name) {
  const bool written = std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ' ' ||
           c == '-' || c == '_';
  });
  if (name.ends_with("_L") || name.ends_with("_R"))
    return Error{
        ErrorCode::bad_input, fmt::format("'{}' cannot name an attribute.", name),
        "Names ending in _L and _R are the two sides of one action. Put it differently: \"left cheek\".",
        "attribute"};
  if (written && !name.empty() && name.size() <= kLongestName && name.front() != ' ' && name.back() != ' ')
    return {};
  return Error{
      ErrorCode::bad_input, fmt::format("'{}' cannot name an attribute.", name),
      fmt::format("Use 1 to {} letters, digits, spaces, - and _, such as \"cheek puff\".", kLongestName),
      "attribute"};
}

void annotate(PaintedAttributes& attributes, std::string_view name, AttributeAnnotation annotation) {
  auto found = named(attributes, name);
  if (found == attributes.end()) found = attributes.insert(attributes.end(), {std::string(name), {}});
  auto& list = found->annotations;
  const auto place = std::ranges::lower_bound(list, annotation.frame, {}, &AttributeAnnotation::frame);
  if (place != list.end() && place->frame == annotation.frame)
    *place = std::move(annotation);
  else
    list.insert(place, std::move(annotation));
}

bool take_back(PaintedAttributes& attributes, std::string_view name, int frame) {
  const auto found = named(attributes, name);
  if (found == attributes.end()) return false;
  const auto taken = std::erase_if(found->annotations, [&](const AttributeAnnotation& annotation) {
    return frame < 0 || annotation.frame == frame;
  });
  if (found->annotations.empty()) attributes.erase(found);
  return taken > 0;
}

const AttributeAnnotation* find_annotation(const PaintedAttributes& attributes, std::string_view name,
                                           int frame) {
  const auto own = std::ranges::find(attributes, name, &PaintedAttribute::name);
  if (own == attributes.end()) return nullptr;
  const auto at = std::ranges::find(own->annotations, frame, &AttributeAnnotation::frame);
  return at == own->annotations.end() ? nullptr : &*at;
}

PaintedAttributes merge_attributes(const PaintedAttributes& base, const PaintedAttributes& mine,
                                   PaintedAttributes theirs) {
  for (const PaintedAttribute& attribute : mine)
    for (const AttributeAnnotation& now : attribute.annotations) {
      const AttributeAnnotation* before = find_annotation(base, attribute.name, now.frame);
      if (!before || !(*before == now)) annotate(theirs, attribute.name, now);
    }
  for (const PaintedAttribute& attribute : base)
    for (const AttributeAnnotation& before : attribute.annotations)
      if (!find_annotation(mine, attribute.name, before.frame))
        take_back(theirs, attribute.name, before.frame);
  const auto place = [&](const PaintedAttribute& attribute) {
    return std::ranges::find(mine, attribute.name, &PaintedAttribute::name) - mine.begin();
  };
  std::ranges::stable_sort(theirs, {}, place);
  return theirs;
}

Strokes strokes_of_mask(const Image8& mask) {
  LIKENESS_CHECK(mask.channels == 1, "a mask of %d channels", mask.channels);
  const auto inside = [&](int x, int y) { return *mask.at(x, y) > 127; };
  int first = mask.height, last = -1;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (inside(x, y)) first = std::min(first, y), last = y;
  Strokes strokes;
  const int step = std::max(1, (last - first + 1) / kMaskRows);
  for (int y = first; y <= last; y += step) {
    const auto in_rows = [&](int x) {  // any row of the step: distant marks may be thinner than a step
      for (int row = y; row < std::min(y + step, mask.height); ++row)
        if (inside(x, row)) return true;
      return false;
    };
    for (int x = 0, end = 0; x < mask.width; x = end + 1) {
      for (end = x; end < mask.width && in_rows(end);) ++end;
      if (end > x) strokes.push_back(band(x, end, y + step / 2 + 0.5, std::max(1.0, 0.75 * step)));
    }
  }
  return strokes;
}

Strokes strokes_of_box(const Vec2d& low, const Vec2d& high) {
  const double height = high.y() - low.y(), radius = std::max(0.5, std::min(height, high.x() - low.x()) / 8);
  const int rows = std::max(1, int(std::ceil(height / radius)) - 1);
  Strokes strokes;
  for (int i = 0; i < rows; ++i) {
    const double share = rows == 1 ? 0.5 : double(i) / (rows - 1);
    const double y =
        std::min(low.y() + radius, 0.5 * (low.y() + high.y())) + share * std::max(0.0, height - 2 * radius);
    strokes.push_back(band(low.x(), high.x(), y, radius));
  }
  return strokes;
}

Result<void> write_attributes(const std::filesystem::path& path, const PaintedAttributes& attributes) {
  std::string text = fmt::format(
      "{{\n\"format\":\"likeness-attributes\",\"version\":{},\"unit\":\"px of the "
      "source\",\n\"attributes\":[",
      kAttributesVersion);
  for (std::size_t a = 0; a < attributes.size(); ++a) {
    text +=
        fmt::format("{}\n{{\"name\":{},\"annotations\":[", a ? "," : "", json_text(json(attributes[a].name)));
    for (std::size_t i = 0; i < attributes[a].annotations.size(); ++i) {
      const AttributeAnnotation& annotation = attributes[a].annotations[i];
      text += fmt::format("{}\n{{\"frame\":{},\"value\":{},\"strokes\":{}}}", i ? "," : "", annotation.frame,
                          annotation.value, strokes_text(annotation.region));
    }
    text += "]}";
  }
  return write_text(path, text + "]\n}\n");
}

Result<PaintedAttributes> read_attributes(const std::filesystem::path& path) {
  const auto text = read_text(path);
  if (!text) return text.error();
  const auto refused = [&](const std::string& why) {
    return Error{ErrorCode::bad_input,
                 fmt::format("The painted attributes in {} cannot be read: {}.", path.string(), why),
                 "Restore a good copy of this file; or rename it and paint the attributes again.",
                 path.string()};
  };
  try {
    const json j = parse_json(*text);
    if (j.at("format").get<std::string>() != "likeness-attributes") return refused("it holds something else");
    const int version = whole_number_in(j.at("version"));
    if (version > kAttributesVersion) return refused("it was made by a newer Likeness");
    if (version < 1) return refused("it is damaged");
    PaintedAttributes attributes;
    for (const json& entry : j.at("attributes")) {
      const auto name = entry.at("name").get<std::string>();
      if (!check_attribute_name(name)) return refused("a name is not valid");
      if (named(attributes, name) != attributes.end()) return refused(fmt::format("'{}' occurs twice", name));
      if (entry.at("annotations").empty()) return refused(fmt::format("'{}' has no frames", name));
      for (const json& painted : entry.at("annotations")) {
        AttributeAnnotation annotation{
            whole_number_in(painted.at("frame")), painted.at("value").get<double>(), {}};
        if (annotation.frame < 0 || !(std::abs(annotation.value) <= 1))
          return refused(fmt::format("a frame or value of '{}' is out of range", name));
        auto strokes = strokes_of_text(json_text(painted.at("strokes")));
        if (!strokes || strokes->damaged > 0)
          return refused(fmt::format("a region of '{}' is damaged", name));
        annotation.region = std::move(strokes->strokes);
        annotate(attributes, name, std::move(annotation));
      }
    }
    return attributes;
  } catch (const json::exception&) {
    return refused("it is damaged");
  }
}

}  // namespace likeness
