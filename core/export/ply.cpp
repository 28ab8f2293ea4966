// PLY, binary and little endian: see head_mesh.h.
#include <fmt/format.h>

#include <bit>

#include "core/base/files.h"
#include "core/export/head_mesh.h"

namespace likeness {
namespace {

static_assert(std::endian::native == std::endian::little, "the header says so");

template <class T>
void append(std::vector<std::byte>& bytes, const T* values, std::size_t count) {
  const auto raw = std::as_bytes(std::span(values, count));
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

}  // namespace

Result<void> write_ply(const std::filesystem::path& path, const HeadMesh& mesh,
                       const Provenance& provenance) {
  const bool has_uvs = !mesh.uvs.empty();
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  // Both are single lines: a project's name is quoted as in JSON.
  header += fmt::format("comment provenance {}\n", provenance_json(provenance));
  header += fmt::format("comment Synthetic media, not a recording: made by {}\n", provenance.program);
  header += fmt::format("element vertex {}\n", mesh.positions.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    header += fmt::format("property float {}\n", name);
  if (has_uvs) header += "property float s\nproperty float t\n";
  header += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                        mesh.triangles.size());
  std::vector<std::byte> bytes;
  append(bytes, header.data(), header.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    append(bytes, mesh.positions[v].data(), 3);
    append(bytes, mesh.normals[v].data(), 3);
    if (has_uvs) append(bytes, mesh.uvs[v].data(), 2);
  }
  constexpr std::uint8_t kCorners = 3;
  for (const Triangle& triangle : mesh.triangles) {
    append(bytes, &kCorners, 1);
    append(bytes, triangle.data(), 3);
  }
  return write_file(path, bytes);
}

}  // namespace likeness
