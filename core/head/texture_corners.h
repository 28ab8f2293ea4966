// Where a head model's triangles lie in its texture.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/head/head_model.h"

namespace likeness {

// Texture coordinates of the triangles' corners, origin bottom left. (F, 3)
using TextureCorners = std::vector<std::array<Vec2f, 3>>;

// The model's own texture coordinates, which it must have.
TextureCorners own_corners(const HeadModel& model);

// Those of an .obj of this model, with seams where corners of one vertex lie apart (v/vt). Triangles missing
// from the file have all corners in one point, and so no area. An Error names what is missing: texture
// coordinates, or the model's vertices and faces.
Result<TextureCorners> read_corners(const std::filesystem::path& path, const HeadModel& model);

}  // namespace likeness
