// Positions and faces of a Wavefront .obj in one pass over the bytes: see ict_folder.h.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include "core/base/number_text.h"
#include "core/head/ict_folder.h"

namespace likeness {
namespace {

class ObjReader {
 public:
  ObjReader(std::string_view text, std::string where) : text_(text), where_(std::move(where)) {}

  Result<ObjMesh> read(bool with_faces) {
    while (at_ < text_.size() && !error_) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      const std::string_view line = text_.substr(at_, end - at_);
      if (line.size() > 1 && (line[1] == ' ' || line[1] == '\t')) {
        if (line[0] == 'v') read_vertex(line.substr(2));
        if (line[0] == 'f' && with_faces) read_face(line.substr(2));
      }
      if (!error_) at_ = end + 1;
    }
    if (!error_ && largest_ >= std::int64_t(mesh_.vertices.size())) {
      at_ = largest_at_;
      fail(fmt::format("refers to vertex {} of {}", largest_ + 1, mesh_.vertices.size()));
    }
    if (error_) return *error_;
    return std::move(mesh_);
  }

 private:
  void fail(const std::string& what) {
    if (error_) return;
    const auto line =
        1 + std::count(text_.begin(), text_.begin() + std::ptrdiff_t(std::min(at_, text_.size())), '\n');
    error_ = Error{ErrorCode::bad_input, fmt::format("Line {} of {} {}.", line, where_, what),
                   "The file is damaged or of another kind; get a fresh copy of it.", where_};
  }
  static void skip_blanks(std::string_view& line) {
    const std::size_t from = line.find_first_not_of(" \t\r");
    line.remove_prefix(std::min(from, line.size()));
  }
  static bool take_index(std::string_view& line, std::int64_t& value) {
    const auto parsed = std::from_chars(line.data(), line.data() + line.size(), value);
    if (parsed.ec != std::errc()) return false;
    line.remove_prefix(std::size_t(parsed.ptr - line.data()));
    return true;
  }

  void read_vertex(std::string_view line) {
    Vec3f vertex = Vec3f::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      skip_blanks(line);
      double value = 0;  // values too small for a float become zero
      if (!take_number(line, value) || !(std::abs(value) < 1e9))
        return fail("does not hold three coordinates");
      vertex[axis] = float(value);
    }
    mesh_.vertices.push_back(vertex);
  }

  // Corners "7", "7/1", "7/1/3", "7//3"; negative numbers count back from the last vertex.
  void read_face(std::string_view line) {
    std::int64_t first = -1, last = -1;
    int corners = 0;
    for (skip_blanks(line); !line.empty(); skip_blanks(line)) {
      std::int64_t index = 0;
      if (!take_index(line, index)) return fail("holds a corner that is not a number");
      const std::size_t rest = line.find_first_of(" \t\r");
      line.remove_prefix(std::min(rest, line.size()));  // texture coordinate and normal
      if (index < 0) index += std::int64_t(mesh_.vertices.size()) + 1;
      if (index < 1 || index > std::numeric_limits<int>::max()) return fail("refers to an impossible vertex");
      --index;
      if (index > largest_) largest_ = index, largest_at_ = at_;
      if (++corners == 1)
        first = index;
      else if (corners > 2)
        mesh_.triangles.emplace_back(int(first), int(last), int(index));
      last = index;
    }
    if (corners < 3) fail("has a face of fewer than three corners");
  }

  std::string_view text_;
  std::string where_;
  std::size_t at_ = 0, largest_at_ = 0;
  std::int64_t largest_ = -1;
  ObjMesh mesh_;
  std::optional<Error> error_;
};

}  // namespace

Result<ObjMesh> parse_obj(std::span<const std::byte> file, const std::string& where, bool with_faces) {
  return ObjReader({reinterpret_cast<const char*>(file.data()), file.size()}, where).read(with_faces);
}

}  // namespace likeness
