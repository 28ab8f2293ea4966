// Maps of fine shape as delivered by other programs, one per frame: heights along the normal over a head
// model's texture coordinates (DECA's displacement maps, Feng et al., SIGGRAPH 2021), transferred to its
// vertices.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/head/texture_corners.h"

namespace likeness {

// A folder of files named by their frame's number in the source (000360.png), one per frame, all of one size;
// frames may be missing:
//   .npy            (H, W) or (H, W, 1) floats, mm outwards
//   .exr .tif .tiff floats, mm outwards; or 16 bits as .png
//   .png            16 bits: 32768 is zero, a step is a micrometre
// Row 0 is the top of the texture, whose coordinates have their origin at the bottom left. A head model
// without texture coordinates takes them from an .obj of itself in the same folder (FLAME's
// head_template.obj). Other files are ignored.
//
// A vertex gets the mean of the texels of its triangles, each weighted by its share in the triangle, so that
// detail finer than the mesh does not alias. Eyeballs, teeth and the mouth's inside are left unchanged.
struct DetailMap {
  int frame = 0;
  Eigen::VectorXf height;  // (V) m along the normal
};

// Ascending frames, at least one. An Error names the file and what is needed: wrong size, not numbers, not
// finite, higher than 10 mm, two files of one frame, no texture coordinates.
Result<std::vector<DetailMap>> read_detail_maps(const std::filesystem::path& folder, const HeadModel& model);

// Hash of the names and contents of the files that read_detail_maps reads.
Result<std::string> detail_maps_hash(const std::filesystem::path& folder);

// Transfers maps of one size to the vertices.
class MapToVertices {
 public:
  MapToVertices(const HeadModel& model, const TextureCorners& corners, int width, int height);
  // map: (height, width), row 0 at the top. (V), 0 for vertices without a place in the texture.
  Eigen::VectorXf operator()(const std::vector<float>& map) const;

 private:
  struct Share {
    std::uint32_t texel;
    std::uint32_t vertex;
    float weight;
  };
  int vertices_ = 0;
  std::vector<Share> shares_;  // by vertex they sum to 1
};

}  // namespace likeness
