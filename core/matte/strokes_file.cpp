// corrections/NNNNNN.json: the strokes of one frame.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/matte/strokes_text.h"

namespace likeness {

namespace {

using nlohmann::json;

constexpr int kStrokesVersion = 1;
constexpr std::array<std::string_view, 3> kMarks{"person", "background", "erase"};
// Far outside any picture; larger values were never painted.
constexpr double kFarthest_px = 1e6;

bool is_place(double px) { return std::isfinite(px) && std::abs(px) <= kFarthest_px; }

// Throws json::exception if something is absent or of another type; empty points: not a stroke.
Stroke stroke_from_json(const json& j) {
  Stroke stroke;
  const auto mark = std::ranges::find(kMarks, j.at("mark").get<std::string>());
  stroke.radius = j.at("radius").get<double>();
  if (mark == kMarks.end() || !is_place(stroke.radius) || stroke.radius <= 0) return {};
  stroke.mark = StrokeMark(mark - kMarks.begin());
  for (const json& point : j.at("points")) {
    if (point.size() != 2) return {};
    const Vec2d at(point.at(0).get<double>(), point.at(1).get<double>());
    if (!is_place(at.x()) || !is_place(at.y())) return {};
    stroke.points.push_back(at);
  }
  return stroke;
}

}  // namespace

std::string strokes_text(std::span<const Stroke> strokes) {
  std::string text = "[";
  for (std::size_t s = 0; s < strokes.size(); ++s) {
    const Stroke& stroke = strokes[s];
    text += fmt::format("{}\n{{\"mark\":\"{}\",\"radius\":{},\"points\":[", s ? "," : "",
                        kMarks[std::size_t(stroke.mark)], stroke.radius);
    for (std::size_t i = 0; i < stroke.points.size(); ++i)
      text += fmt::format("{}[{},{}]", i ? "," : "", stroke.points[i].x(), stroke.points[i].y());
    text += "]}";
  }
  return text + "]";
}

std::optional<ReadStrokes> strokes_of_text(const std::string& text) {
  try {
    ReadStrokes read;
    const json list = parse_json(text);
    if (!list.is_array()) return std::nullopt;
    for (const json& entry : list) {
      Stroke stroke = stroke_from_json(entry);
      if (stroke.points.empty()) {
        read.damaged = read.strokes.size() + 1;
        return read;
      }
      read.strokes.push_back(std::move(stroke));
    }
    return read;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

Result<void> write_strokes(const std::filesystem::path& path, std::span<const Stroke> strokes) {
  return write_text(path,
                    fmt::format("{{\n\"format\":\"likeness-strokes\",\"version\":{},\"unit\":\"px of the "
                                "source\",\n\"strokes\":{}\n}}\n",
                                kStrokesVersion, strokes_text(strokes)));
}

Result<Strokes> read_strokes(const std::filesystem::path& path) {
  const auto text = read_text(path);
  if (!text) return text.error();
  const auto refused = [&](const std::string& why) {
    return Error{ErrorCode::bad_input,
                 fmt::format("The mask's strokes in {} cannot be read: {}.", path.string(), why),
                 "Restore a good copy of this file; or set it aside, in the Cameras step under Masks and "
                 "background or by renaming it, and paint the frame again.",
                 path.string()};
  };
  try {
    const json j = parse_json(*text);
    if (j.at("format").get<std::string>() != "likeness-strokes") return refused("it holds something else");
    const int version = whole_number_in(j.at("version"));
    if (version > kStrokesVersion) return refused("it was made by a newer Likeness");
    if (version < 1) return refused("it is damaged");
    auto read = strokes_of_text(json_text(j.at("strokes")));
    if (!read) return refused("it is damaged");
    if (read->damaged > 0) return refused(fmt::format("stroke {} is damaged", read->damaged));
    return std::move(read->strokes);
  } catch (const json::exception&) {
    return refused("it is damaged");
  }
}

}  // namespace likeness
