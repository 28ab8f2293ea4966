// Where the 68 iBUG landmarks lie on FLAME. The model files do not say; separate embedding files do:
//   landmark_embedding.npy      DECA's and its successors': 51 inner landmarks, a contour table, often all 68
//   flame_static_embedding.pkl and flame_dynamic_embedding.npy      RingNet's, FLAME_PyTorch's: 51 + the
//   table flame_static_embedding_68.pkl      TF_FLAME's: 68 at once
// Keys: static_/dynamic_/full_lmk_faces_idx and _lmk_bary_coords, or lmk_face_idx and lmk_b_coords.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/head/dynamic_contour.h"
#include "core/head/head_model.h"

namespace likeness {

struct FlameLandmarks {
  std::array<SurfacePoint, kLandmarkCount> points;  // contour: the frontal row
  std::optional<DynamicContour> contour;            // rows by yaw, in the file's sense of direction
};

// One embedding file's content: .npy with a pickled dict, or a pickle of the dict.
struct LandmarkEmbedding {
  std::vector<SurfacePoint> fixed;  // 51, or 68, or none
  std::vector<SurfacePoint> all;    // 68, or none
  std::vector<ContourRow> rows;     // as in the file: 0, 1 .. L, -1 .. -L degrees; or none
};
Result<LandmarkEmbedding> parse_landmark_embedding(std::span<const std::byte> file, const std::string& where);

// Looks beside the model file, then in the folder above. An Error (not_found) says which file to put where.
Result<FlameLandmarks> read_flame_landmarks(const std::filesystem::path& model_file);

// The embedding files that read_flame_landmarks would read; empty if there are none.
std::vector<std::filesystem::path> landmark_files_beside(const std::filesystem::path& model_file);

// Puts the landmarks on the model; every index is checked against its triangles. The table's sense of yaw
// differs between the programs that use it, so it is determined from the mesh: on the side that turns away
// the contour moves forward.
Result<void> attach_landmarks(const FlameLandmarks& landmarks, const std::string& where, HeadModel& model);

}  // namespace likeness
