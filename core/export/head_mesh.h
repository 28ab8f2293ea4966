// The posed head as a mesh for other programs: glTF 2.0 (.glb) and PLY.
//
// Metres, in the axes of the typical head: x to the subject's left, y up, z out of the face, which are glTF's
// own for something that faces the viewer. It is the fitted head model, without colour and hair: those exist
// only in the radiance field.
#pragma once

#include <filesystem>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/export/provenance.h"
#include "core/export/write_film.h"

namespace likeness {

struct HeadMesh {
  std::vector<Vec3f> positions, normals;  // (V) m; unit
  std::vector<Vec2f> uvs;                 // (V) origin bottom left, or empty where the head model has none
  std::vector<Triangle> triangles;        // counter-clockwise seen from outside
};

// The head goes where it is posed, the shoulders with the torso, the neck between them by the model's
// skinning weights.
HeadMesh head_mesh(const Avatar& avatar, const HeadModel& model, const AvatarPose& pose);

inline constexpr std::size_t kMaxMeshFrames = 500;

// One mesh, or with several the same mesh moving: every frame after the first is a morph target, and an
// animation goes from one to the next, so that a viewer shows exactly these vertices at the frames' times and
// straight lines between them. times_s: of each frame. All have the first one's triangles. About 24 bytes a
// vertex and frame.
Result<void> write_glb(const std::filesystem::path& path, std::span<const HeadMesh> frames,
                       std::span<const double> times_s, const Provenance& provenance);

// Binary, little endian.
Result<void> write_ply(const std::filesystem::path& path, const HeadMesh& mesh, const Provenance& provenance);

// Whether a file name asks for a mesh.
bool is_mesh_name(const std::filesystem::path& path);

// Whether a mesh of so many frames can be written there; cheap, so that it can be reported before long work.
Result<void> check_head(const std::filesystem::path& out, std::size_t frames);

// The poses of an avatar as .glb or, a single one, as .ply. Number of frames written.
Result<int> write_head(const OpenedAvatar& opened, const Film& film, std::span<const double> times_s,
                       const std::filesystem::path& out, const Provenance& provenance,
                       const Progress& progress, std::stop_token stop);

}  // namespace likeness
