// glTF 2.0 in its binary container: a header, a JSON chunk, a chunk of arrays. See head_mesh.h.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/export/head_mesh.h"

namespace likeness {

using nlohmann::json;

namespace {

static_assert(std::endian::native == std::endian::little, "glTF's arrays are little endian");

// Numbers of the specification.
constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125, kVertexBuffer = 34962, kIndexBuffer = 34963;

// The arrays of a file: bytes, and what the JSON says of them. One view per accessor.
class Arrays {
 public:
  // Row-major values of `columns` a row; returns the accessor's index. target 0: neither vertices nor
  // indices.
  int add(const float* values, std::size_t rows, int columns, bool bounds, int target) {
    constexpr const char* kTypes[] = {"", "SCALAR", "VEC2", "VEC3"};
    json accessor = place(values, rows * std::size_t(columns) * sizeof(float), target);
    accessor.update({{"componentType", kFloat}, {"count", rows}, {"type", kTypes[columns]}});
    if (bounds) {
      std::vector<float> low(values, values + columns), high = low;
      for (std::size_t i = 0; i < rows * std::size_t(columns); ++i) {
        float &l = low[i % std::size_t(columns)], &h = high[i % std::size_t(columns)];
        l = std::min(l, values[i]), h = std::max(h, values[i]);
      }
      accessor["min"] = low, accessor["max"] = high;
    }
    return append(std::move(accessor));
  }
  int add(const std::vector<Vec3f>& rows, bool bounds) {
    return add(rows.data()->data(), rows.size(), 3, bounds, kVertexBuffer);
  }
  int add(const std::vector<Triangle>& triangles) {
    json accessor = place(triangles.data(), triangles.size() * sizeof(Triangle), kIndexBuffer);
    accessor.update({{"componentType", kUnsignedInt}, {"count", 3 * triangles.size()}, {"type", "SCALAR"}});
    return append(std::move(accessor));
  }

  std::vector<std::byte> bytes;
  json views = json::array(), accessors = json::array();

 private:
  json place(const void* data, std::size_t size, int target) {
    json view = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    views.push_back(std::move(view));
    const auto* begin = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), begin, begin + size);  // all elements have four bytes, so all stay aligned
    return {{"bufferView", views.size() - 1}};
  }
  int append(json accessor) {
    accessors.push_back(std::move(accessor));
    return int(accessors.size()) - 1;
  }
};

std::vector<Vec3f> difference(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  std::vector<Vec3f> out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] - b[i];
  return out;
}

// Frame i shows target i - 1 alone, frame 0 none.
json animation(Arrays& arrays, std::size_t frames, std::span<const double> times_s) {
  std::vector<float> times, weights(frames * (frames - 1), 0.0f);
  for (std::size_t i = 0; i < frames; ++i) {
    times.push_back(float(times_s[i]));
    if (i > 0) weights[i * (frames - 1) + i - 1] = 1;
  }
  const int input = arrays.add(times.data(), times.size(), 1, true, 0);
  const int output = arrays.add(weights.data(), weights.size(), 1, false, 0);
  return {{"name", "performance"},
          {"samplers", {{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}}}},
          {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}};
}

void append_chunk(std::vector<std::byte>& file, std::uint32_t type, std::span<const std::byte> body,
                  std::byte padding) {
  const auto append_number = [&](std::uint32_t number) {
    const auto bytes = std::bit_cast<std::array<std::byte, 4>>(number);
    file.insert(file.end(), bytes.begin(), bytes.end());
  };
  append_number(std::uint32_t((body.size() + 3) / 4 * 4));
  append_number(type);
  file.insert(file.end(), body.begin(), body.end());
  file.resize((file.size() + 3) / 4 * 4, padding);
}

}  // namespace

Result<void> write_glb(const std::filesystem::path& path, std::span<const HeadMesh> frames,
                       std::span<const double> times_s, const Provenance& provenance) {
  LIKENESS_CHECK(!frames.empty() && times_s.size() >= frames.size(), "%d frames with %d times",
                 int(frames.size()), int(times_s.size()));
  const HeadMesh& first = frames.front();
  Arrays arrays;
  json attributes = {{"POSITION", arrays.add(first.positions, true)},
                     {"NORMAL", arrays.add(first.normals, false)}};
  if (!first.uvs.empty()) {
    std::vector<Vec2f> uvs;  // glTF's origin is at the top
    for (const Vec2f& uv : first.uvs) uvs.emplace_back(uv.x(), 1 - uv.y());
    attributes["TEXCOORD_0"] = arrays.add(uvs.data()->data(), uvs.size(), 2, false, kVertexBuffer);
  }
  json primitive = {
      {"attributes", std::move(attributes)}, {"indices", arrays.add(first.triangles)}, {"material", 0}};
  json mesh = {{"name", "head"}};
  json file = {{"asset",
                {{"version", "2.0"},
                 {"generator", provenance.program},
                 {"extras", parse_json(provenance_json(provenance))}}},
               {"scene", 0},
               {"scenes", {{{"nodes", {0}}}}},
               {"nodes", {{{"name", provenance.project}, {"mesh", 0}}}},
               {"materials",
                {{{"name", "skin"},
                  {"pbrMetallicRoughness",
                   {{"baseColorFactor", {0.8, 0.6, 0.52, 1.0}},
                    {"metallicFactor", 0.0},
                    {"roughnessFactor", 0.6}}}}}}};
  if (frames.size() > 1) {
    for (const HeadMesh& frame : frames.subspan(1)) {
      LIKENESS_CHECK(frame.positions.size() == first.positions.size(), "%d vertices after %d",
                     int(frame.positions.size()), int(first.positions.size()));
      primitive["targets"].push_back(
          {{"POSITION", arrays.add(difference(frame.positions, first.positions), true)},
           {"NORMAL", arrays.add(difference(frame.normals, first.normals), false)}});
    }
    mesh["weights"] = std::vector<float>(frames.size() - 1, 0.0f);
    file["animations"] = json::array({animation(arrays, frames.size(), times_s)});
  }
  mesh["primitives"] = json::array({std::move(primitive)});
  file["meshes"] = json::array({std::move(mesh)});
  file["buffers"] = json::array({{{"byteLength", arrays.bytes.size()}}});
  file["bufferViews"] = std::move(arrays.views), file["accessors"] = std::move(arrays.accessors);

  const std::string text = json_text(file);
  std::vector<std::byte> glb(12);
  append_chunk(glb, kJsonChunk, std::as_bytes(std::span(text)), std::byte(' '));
  append_chunk(glb, kBinChunk, arrays.bytes, std::byte(0));
  const std::uint32_t header[] = {kMagic, 2, std::uint32_t(glb.size())};
  std::memcpy(glb.data(), header, sizeof header);
  return write_file(path, glb);
}

}  // namespace likeness
