// ICT-FaceKit's own folder: generic_neutral_mesh.obj, identity000.obj ..., one .obj per expression, as
// https://github.com/ICT-VGL/ICT-FaceKit delivers them in FaceXModel (Li et al., "Learning Formation of
// Physically-Based Face Attributes", CVPR 2020; light version, MIT licence). Centimetres, quads and
// triangles.
//
// Vertices by the table of its README: face 0..9408, head and neck 9409..11247, mouth socket 11248..13293,
// eye sockets left 13294..13677 and right 13678..14061, gums and tongue 14062..17038, teeth 17039..21450,
// eyeballs left 21451..23020 and right 23021..24590; lacrimal fluid, eye blend, eye occlusion and lashes
// after that are left out.
//
// ICT has no skeleton; this one is added:
//   root and neck   fixed places 15.5 and 8.5 cm below its origin, the neck fading into the shoulders
//   eyes            the centres of the eyeballs, which turn with them
//   jaw             near the joints of the real jaw, 0.55 cm below and 1.8 cm before the origin; a turn of
//                   25.33 degrees about x is the shape jawOpen = 1 (measured on the shape): weights are the
//                   share of that turn which jawOpen makes at a vertex, and what a turn cannot make is a pose
//                   corrective on the sine of the angle.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/head/head_model.h"

namespace likeness {

struct ObjMesh {
  std::vector<Vec3f> vertices;      // in the file's unit
  std::vector<Triangle> triangles;  // polygons are cut into fans
};
// The positions and faces of an .obj; the rest is ignored. An Error names the line.
Result<ObjMesh> parse_obj(std::span<const std::byte> file, const std::string& where, bool with_faces = true);

// The folder itself or the one that holds FaceXModel. About three seconds: 154 files of 3 MB.
Result<HeadModel> load_ict_folder(const std::filesystem::path& folder);

// The files that load_ict_folder would read, in a fixed order; those that are absent are left out.
std::vector<std::filesystem::path> ict_folder_files(const std::filesystem::path& folder);

}  // namespace likeness
