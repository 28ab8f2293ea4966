// Reading, checking and projecting maps of heights: see detail_maps.h.
#include "core/head/detail_maps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/npz.h"
#include "core/head/expression_detail.h"
#include "core/head/texture_corners.h"
#include "core/image/read_numbers.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kSmallestMap = 16, kLargestMap = 4096;  // px
constexpr float kZeroCount = 32768, kMmPerCount = 0.001f;
constexpr float kMmPerMetre = 1000;
constexpr const char* kExtensions[] = {".npy", ".png", ".exr", ".tif", ".tiff"};

const char* const kNeeded =
    "Give heights in millimetres along the normal, one file per frame, named after the frame's number in the "
    "clip: 000360.npy, .exr or .tif of floats, or a 16-bit .png in which 32768 is zero and a step is a "
    "micrometre.";

Error wrong(const fs::path& path, std::string what, std::string fix = kNeeded) {
  return {ErrorCode::bad_input, std::move(what), std::move(fix), path.string()};
}

// The number a file is named by; nullopt: it is no map.
std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return extension;
}

std::optional<int> frame_of(const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (std::ranges::find(kExtensions, extension) == std::end(kExtensions)) return std::nullopt;
  const std::string stem = path.stem().string();
  int frame = 0;
  const auto [end, failure] = std::from_chars(stem.data(), stem.data() + stem.size(), frame);
  if (stem.empty() || failure != std::errc{} || end != stem.data() + stem.size() || frame < 0)
    return std::nullopt;
  return frame;
}

struct MapFiles {
  std::map<int, fs::path> maps;  // by frame
  std::vector<fs::path> meshes;  // .obj, by name
};

Result<MapFiles> list_files(const fs::path& folder) {
  std::error_code failure;
  if (!fs::is_directory(folder, failure))
    return Error{ErrorCode::not_found, fmt::format("There is no folder {}.", folder.string()),
                 fmt::format("Check the name. {}", kNeeded), folder.string()};
  MapFiles files;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure)) {
    if (lower_extension(it->path()) == ".obj") files.meshes.push_back(it->path());
    const auto frame = frame_of(it->path());
    if (!frame) continue;
    const auto [other, added] = files.maps.emplace(*frame, it->path());
    if (!added)
      return wrong(folder,
                   fmt::format("{} and {} are both of frame {}.", other->second.filename().string(),
                               it->path().filename().string(), *frame),
                   "Remove one of them.");
  }
  if (failure) return file_error(folder, "read", failure.value());
  if (files.maps.empty())
    return wrong(folder, fmt::format("No file in {} is named after a frame.", folder.string()));
  std::ranges::sort(files.meshes);
  return files;
}

struct Heights {
  int width = 0, height = 0;
  std::vector<float> mm;
};

Result<Heights> read_npy(const fs::path& path) {
  const std::string name = path.filename().string();
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto array = parse_npy(*bytes, name);
  if (!array) return array.error();
  std::vector<std::size_t> shape = array->shape;
  if (shape.size() == 3 && shape.back() == 1) shape.pop_back();
  if (shape.size() == 3 && shape.front() == 1) shape.erase(shape.begin());
  if (array->kind != 'f' || shape.size() != 2 || shape[0] > kLargestMap || shape[1] > kLargestMap)
    return wrong(path, fmt::format("{} holds an array of kind '{}' and shape ({}), which is not a map.", name,
                                   array->kind, fmt::join(array->shape, ", ")));
  return Heights{int(shape[1]), int(shape[0]), array->as_float()};
}

Result<Heights> read_picture(const fs::path& path) {
  const std::string name = path.filename().string();
  auto numbers = read_numbers(path);
  if (!numbers) return numbers.error();
  if (numbers->whole && numbers->bits != 16)
    return wrong(path, fmt::format("{} has {} bits per pixel, too few for heights.", name, numbers->bits));
  if (numbers->whole)
    for (float& value : numbers->values) value = (value - kZeroCount) * kMmPerCount;
  return Heights{numbers->width, numbers->height, std::move(numbers->values)};
}

Result<Heights> read_heights(const fs::path& path) {
  auto map = lower_extension(path) == ".npy" ? read_npy(path) : read_picture(path);
  if (!map) return map;
  const std::string name = path.filename().string();
  if (std::min(map->width, map->height) < kSmallestMap || std::max(map->width, map->height) > kLargestMap)
    return wrong(path, fmt::format("{} is {} x {}; maps have {} to {} texels a side.", name, map->width,
                                   map->height, kSmallestMap, kLargestMap));
  for (std::size_t i = 0; i < map->mm.size(); ++i) {
    const float mm = map->mm[i];
    const std::size_t x = i % std::size_t(map->width), y = i / std::size_t(map->width);
    if (!std::isfinite(mm))
      return wrong(path, fmt::format("{} holds a value that is not finite, at ({}, {}).", name, x, y),
                   fmt::format("Make it again, or remove it: frames may be missing. {}", kNeeded));
    if (std::abs(mm) > kMmPerMetre * kHighestDetail)
      return wrong(path, fmt::format("{} is {:.4g} mm high at ({}, {}); no crease of a face is above {:g}.",
                                     name, mm, x, y, kMmPerMetre * kHighestDetail));
  }
  return map;
}

Result<TextureCorners> corners_of(const fs::path& folder, const MapFiles& files, const HeadModel& model) {
  if (!model.uvs.empty()) return own_corners(model);
  if (!files.meshes.empty()) return read_corners(files.meshes.front(), model);
  return wrong(folder, fmt::format("The {} head has no texture coordinates for maps to lie on.", model.name),
               fmt::format("Put an .obj of this head model with texture coordinates into {}, e.g. FLAME's "
                           "head_template.obj.",
                           folder.string()));
}

bool takes_detail(const HeadModel& model, int vertex) {
  if (model.parts.empty()) return true;
  const HeadPart part = model.parts[std::size_t(vertex)];
  return part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::unknown;
}

}  // namespace

MapToVertices::MapToVertices(const HeadModel& model, const TextureCorners& corners, int width, int height)
    : vertices_(model.vertex_count()) {
  std::vector<double> sum(std::size_t(vertices_), 0.0);
  std::vector<std::optional<std::uint32_t>> nearest(std::size_t(vertices_), std::nullopt);  // texel
  const auto texel_at = [&](const Vec2f& place) {
    const int x = std::clamp(int(place.x()), 0, width - 1), y = std::clamp(int(place.y()), 0, height - 1);
    return std::uint32_t(y) * std::uint32_t(width) + std::uint32_t(x);
  };
  for (std::size_t f = 0; f < corners.size(); ++f) {
    const Triangle& t = model.triangles[f];
    if (!takes_detail(model, t[0]) || !takes_detail(model, t[1]) || !takes_detail(model, t[2])) continue;
    Vec2f at[3];  // texels, row 0 at the top
    for (int c = 0; c < 3; ++c) {
      const Vec2f& uv = corners[f][std::size_t(c)];
      at[c] = {uv.x() * float(width), (1 - uv.y()) * float(height)};
      nearest[std::size_t(t[c])] = texel_at(at[c]);
    }
    const Vec2f a = at[1] - at[0], b = at[2] - at[0];
    const float area = a.x() * b.y() - a.y() * b.x();
    if (std::abs(area) < 1e-12f) continue;
    const Vec2f low = at[0].cwiseMin(at[1]).cwiseMin(at[2]), high = at[0].cwiseMax(at[1]).cwiseMax(at[2]);
    for (int y = std::max(0, int(low.y())); y < std::min(height, int(high.y()) + 1); ++y)
      for (int x = std::max(0, int(low.x())); x < std::min(width, int(high.x()) + 1); ++x) {
        const Vec2f p = Vec2f(float(x) + 0.5f, float(y) + 0.5f) - at[0];
        const float v = (p.x() * b.y() - p.y() * b.x()) / area, w = (a.x() * p.y() - a.y() * p.x()) / area;
        const float weights[3] = {1 - v - w, v, w};
        if (weights[0] < 0 || v < 0 || w < 0) continue;
        for (int c = 0; c < 3; ++c) {
          shares_.push_back({texel_at({float(x), float(y)}), std::uint32_t(t[c]), weights[c]});
          sum[std::size_t(t[c])] += double(weights[c]);
        }
      }
  }
  // With coarse maps a vertex may have no texel of its own.
  constexpr double kNone = 1e-3;
  std::erase_if(shares_, [&](const Share& s) { return sum[s.vertex] < kNone; });
  for (Share& s : shares_) s.weight = float(double(s.weight) / sum[s.vertex]);
  for (std::size_t v = 0; v < sum.size(); ++v)
    if (sum[v] < kNone && nearest[v]) shares_.push_back({*nearest[v], std::uint32_t(v), 1});
}

Eigen::VectorXf MapToVertices::operator()(const std::vector<float>& map) const {
  Eigen::VectorXf height = Eigen::VectorXf::Zero(vertices_);
  for (const Share& s : shares_) height[Eigen::Index(s.vertex)] += s.weight * map[s.texel];
  return height;
}

Result<std::vector<DetailMap>> read_detail_maps(const fs::path& folder, const HeadModel& model) {
  const auto files = list_files(folder);
  if (!files) return files.error();
  const auto corners = corners_of(folder, *files, model);
  if (!corners) return corners.error();
  std::vector<DetailMap> maps;
  std::optional<MapToVertices> to_vertices;
  int width = 0, height = 0;
  for (const auto& [frame, path] : files->maps) {
    const auto map = read_heights(path);
    if (!map) return map.error();
    if (!to_vertices) {
      to_vertices.emplace(model, *corners, map->width, map->height);
      width = map->width, height = map->height;
    }
    if (map->width != width || map->height != height)
      return wrong(path,
                   fmt::format("{} is {} x {}, and {} is {} x {}.", path.filename().string(), map->width,
                               map->height, files->maps.begin()->second.filename().string(), width, height),
                   "Make all maps in one size.");
    maps.push_back({frame, (*to_vertices)(map->mm) / kMmPerMetre});
  }
  return maps;
}

Result<std::string> detail_maps_hash(const fs::path& folder) {
  const auto files = list_files(folder);
  if (!files) return files.error();
  std::string text;
  const auto add = [&](const fs::path& path) -> Result<void> {
    const auto hash = hash_file(path);
    if (!hash) return hash.error();
    text += path.filename().string() + " " + *hash + "\n";
    return {};
  };
  for (const auto& [frame, path] : files->maps)
    if (const auto added = add(path); !added) return added.error();
  for (const fs::path& path : files->meshes)
    if (const auto added = add(path); !added) return added.error();
  return hash_text(text);
}

}  // namespace likeness
