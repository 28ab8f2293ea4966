// Posing the mesh and choosing its file: see head_mesh.h.
#include "core/export/head_mesh.h"

#include <fmt/format.h>

#include "core/base/rigid.h"
#include "core/head/pose_head.h"

namespace likeness {

HeadMesh head_mesh(const Avatar& avatar, const HeadModel& model, const AvatarPose& pose) {
  HeadMesh mesh;
  mesh.triangles = model.triangles;
  mesh.positions =
      pose_detailed_head(model, shape_head(model, avatar.person), pose.articulation, avatar.detail);
  const Pose typical_from_world = inverse(avatar.world_from_head);
  const Eigen::Isometry3f head = (typical_from_world * pose.world_from_head).cast<float>();
  // How the torso left its typical place, and the model's shoulders with it.
  const Eigen::Isometry3f torso =
      (typical_from_world * pose.world_from_torso * inverse(avatar.world_from_torso) * avatar.world_from_head)
          .cast<float>();
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const float still = model.skinning_weights(Eigen::Index(v), kRoot);
    Vec3f& position = mesh.positions[v];
    position = (1 - still) * (head * position) + still * (torso * position);
  }
  mesh.normals = vertex_normals(mesh.positions, mesh.triangles);
  // A vertex in no triangle has no normal, but the file must have one.
  for (Vec3f& normal : mesh.normals)
    if (!(normal.squaredNorm() > 0.5f)) normal = Vec3f::UnitZ();
  mesh.uvs = model.uvs;
  return mesh;
}

bool is_mesh_name(const std::filesystem::path& path) {
  return path.extension() == ".glb" || path.extension() == ".ply";
}

Result<void> check_head(const std::filesystem::path& out, std::size_t frames) {
  const bool ply = out.extension() == ".ply";
  if (frames <= (ply ? 1 : kMaxMeshFrames)) return {};
  return Error{
      ErrorCode::bad_input, fmt::format("{} frames do not fit into {}.", frames, out.filename().string()),
      ply ? "Name a .glb as --out, or leave out what moves."
          : fmt::format(
                "A .glb holds at most {} frames: give a shorter clip or performance, or fewer --frames.",
                kMaxMeshFrames),
      out.string()};
}

Result<int> write_head(const OpenedAvatar& opened, const Film& film, std::span<const double> times_s,
                       const std::filesystem::path& out, const Provenance& provenance,
                       const Progress& progress, std::stop_token stop) {
  if (const auto fits = check_head(out, film.frames); !fits) return fits.error();
  std::vector<HeadMesh> meshes;
  for (std::size_t i = 0; i < film.frames; ++i) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(i) / double(film.frames), fmt::format("mesh {} of {}", i + 1, film.frames));
    meshes.push_back(head_mesh(opened.avatar, opened.model, film.at(i).pose));
  }
  const auto written = out.extension() == ".ply" ? write_ply(out, meshes.front(), provenance)
                                                 : write_glb(out, meshes, times_s, provenance);
  if (!written) return written.error();
  progress.report(1);
  return int(meshes.size());
}

}  // namespace likeness
