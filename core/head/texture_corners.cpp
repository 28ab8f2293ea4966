// Corners by vertex, or out of an .obj: see texture_corners.h.
#include "core/head/texture_corners.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "core/base/files.h"
#include "core/base/number_text.h"

namespace likeness {
namespace {

using CornersByFace = std::map<std::array<int, 3>, std::array<Vec2f, 3>>;

// Turned so that the smallest vertex comes first, the corners with it.
void turn_to_smallest(std::array<int, 3>& vertices, std::array<Vec2f, 3>* corners) {
  const auto first = std::ranges::min_element(vertices) - vertices.begin();
  std::rotate(vertices.begin(), vertices.begin() + first, vertices.end());
  if (corners) std::rotate(corners->begin(), corners->begin() + first, corners->end());
}

struct Corner {
  int vertex = 0, place = 0;  // from 0
};

// What an .obj holds besides positions.
struct ObjTexture {
  std::vector<Vec2f> places;
  int vertices = 0;
  CornersByFace faces;

  // "7/3" or "7/3/1" -> 6, 2.
  bool take_corner(std::string_view text, Corner& corner) const {
    const auto number = [&](int& index, int count) {
      const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), index);
      if (failure != std::errc{}) return false;
      text.remove_prefix(std::size_t(end - text.data()));
      index = index < 0 ? count + index : index - 1;
      return index >= 0 && index < count;
    };
    if (!number(corner.vertex, vertices) || text.empty() || text.front() != '/') return false;
    text.remove_prefix(1);
    return number(corner.place, int(places.size()));
  }
  // False where a corner has no texture coordinate. Polygons are cut into fans.
  bool add_face(std::string_view line) {
    std::vector<Corner> corners;
    for (std::size_t from = line.find_first_not_of(" \t\r"); from != std::string_view::npos;
         from = line.find_first_not_of(" \t\r")) {
      line.remove_prefix(from);
      const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
      if (!take_corner(word, corners.emplace_back())) return false;
      line.remove_prefix(word.size());
    }
    for (std::size_t c = 2; c < corners.size(); ++c) {
      std::array<int, 3> face{};
      std::array<Vec2f, 3> at;
      std::size_t i = 0;
      for (const Corner& corner : {corners[0], corners[c - 1], corners[c]})
        face[i] = corner.vertex, at[i++] = places[std::size_t(corner.place)];
      turn_to_smallest(face, &at);
      faces.emplace(face, at);
    }
    return true;
  }
  bool add_place(std::string_view line) {
    Vec2f place;
    for (int axis = 0; axis < 2; ++axis) {
      line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
      double value = 0;
      if (!take_number(line, value) || !(std::abs(value) < 1e9)) return false;
      place[axis] = float(value);
    }
    places.push_back(place);
    return true;
  }
};

Error wrong(const std::filesystem::path& path, std::string what, const HeadModel& model) {
  return {
      ErrorCode::bad_input, std::move(what),
      fmt::format("Put an .obj of the {} head with texture coordinates there, faces as v/vt.", model.name),
      path.string()};
}

}  // namespace

TextureCorners own_corners(const HeadModel& model) {
  TextureCorners corners;
  for (const Triangle& t : model.triangles)
    corners.push_back(
        {model.uvs[std::size_t(t[0])], model.uvs[std::size_t(t[1])], model.uvs[std::size_t(t[2])]});
  return corners;
}

Result<TextureCorners> read_corners(const std::filesystem::path& path, const HeadModel& model) {
  const auto text = read_text(path);
  if (!text) return text.error();
  const std::string name = path.filename().string();
  ObjTexture texture;
  std::string_view rest = *text;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    bool fine = true;
    if (line.starts_with("v ")) ++texture.vertices;
    if (line.starts_with("vt ")) fine = texture.add_place(line.substr(3));
    if (line.starts_with("f ")) fine = texture.add_face(line.substr(2));
    if (!fine)
      return wrong(path, fmt::format("Line {} of {} has no texture coordinate.", number, name), model);
  }
  if (texture.vertices != model.vertex_count())
    return wrong(path,
                 fmt::format("The mesh in {} has {} vertices, and the {} head has {}.", name,
                             texture.vertices, model.name, model.vertex_count()),
                 model);
  TextureCorners corners;
  std::size_t found = 0;
  for (const Triangle& t : model.triangles) {
    std::array<int, 3> face{t[0], t[1], t[2]};
    const auto first = std::ranges::min_element(face) - face.begin();
    turn_to_smallest(face, nullptr);
    std::array<Vec2f, 3>& own = corners.emplace_back();
    own.fill(Vec2f::Zero());
    const auto known = texture.faces.find(face);
    if (known == texture.faces.end()) continue;
    own = known->second;
    std::rotate(own.begin(), own.begin() + (3 - first) % 3, own.end());  // back to the model's order
    ++found;
  }
  // Quads may be split the other way; meshes of another topology share hardly a triangle.
  if (2 * found < model.triangles.size())
    return wrong(path,
                 fmt::format("Of the {} head's {} triangles, {} are in {}.", model.name,
                             model.triangles.size(), found, name),
                 model);
  return corners;
}

}  // namespace likeness
