// Structure from motion by the `colmap` program on a folder of pictures and masks, resumable step by step.
#pragma once

#include <filesystem>
#include <optional>
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
  int features = 2000;            // per picture; raising it costs matching time quadratically
  int overlap = 7;                // pairs with +1..+(overlap-1) and +2^0..+2^(overlap-1)
  double enough = kEnoughPlaced;  // share of the pictures to place; below it every pair is matched instead
  int max_for_all_pairs = 35;     // pictures; matching all pairs of more takes minutes
  int threads = 0;                // 0: the current limit
  int seed = 0;
};

// What the database holds; the exit codes hardly tell why a solve failed.
struct ColmapCounts {
  int pictures = 0;        // in the folder
  int described = 0;       // with more than 50 features
  int verified_pairs = 0;  // with at least 15 geometrically verified matches
  int flat_pairs = 0;      // of these, those that a turn on the spot, or a flat wall, explains as well
};
Result<ColmapCounts> count_database(const std::filesystem::path& database);

// work/images/NAME and work/masks/NAME.png (0 = ignored) must be there; database and reconstructions are
// written beside them, the chosen one to solved_model_path(). A step whose marker file (work/NAME.done)
// exists is not repeated. The chosen reconstruction has the least reprojection error among those that place
// nearly the most pictures with nearly the most features; its lens has square pixels, no distortion and the
// principal point in the middle, unless one with all of these free (colmap's OPENCV) fits the pictures better
// by more than noise.
Result<ColmapModel> solve_colmap(const std::filesystem::path& work, const ColmapOptions& options,
                                 const Progress& progress, std::stop_token stop);
std::filesystem::path solved_model_path(const std::filesystem::path& work);

// How far solve_colmap, running on this folder in another thread or program, has come with placing pictures:
// the last complete snapshot, written every few pictures. nullopt before the first of them and after the
// last.
std::optional<ColmapModel> solve_so_far(const std::filesystem::path& work);

}  // namespace likeness
