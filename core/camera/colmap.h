// Structure from motion by the `colmap` program on a folder of pictures and masks, resumable step by step.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/colmap_model.h"

namespace likeness {

// Share of the pictures that a solve must place to be taken without another try.
inline constexpr double kEnoughPlaced = 0.6;

struct ColmapOptions {
  std::string program = "colmap";
  int features = 2000;      // per picture; raising it costs matching time quadratically
  int overlap = 7;          // sequential: pairs with +1..+(overlap-1) and +2^0..+2^(overlap-1)
  bool exhaustive = false;  // every pair instead
  int threads = 0;          // 0: the current limit
  int seed = 0;
};

// What the database holds; the exit codes hardly tell why a solve failed.
struct ColmapCounts {
  int pictures = 0;        // in the folder
  int described = 0;       // with more than 50 features
  int verified_pairs = 0;  // with at least 15 geometrically verified matches
  int flat_pairs = 0;      // of these, what a turn on the spot, or a flat wall, explains as well
};
Result<ColmapCounts> count_database(const std::filesystem::path& database);

// work/images/NAME and work/masks/NAME.png (0 = ignored) must be there; database, sparse/ and refined/
// (all_sparse/ and all_refined/ where every pair is matched) are written beside them. A step whose marker
// file (work/NAME.done) exists is not repeated. The model is that of the bundle adjustment with distortion
// and principal point free, of the best reconstruction: the most pictures placed, and of about as many the
// least reprojection error.
Result<ColmapModel> solve_colmap(const std::filesystem::path& work, const ColmapOptions& options,
                                 const Progress& progress, std::stop_token stop);

}  // namespace likeness
