// A project's background - the plate of a resting camera, or the room of a moving one - measured against the
// true one of the demo it was made from, where the project says that it knows it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/image/image.h"
#include "core/project/project.h"

namespace likeness {

struct WallErrors {
  double known_share = 0;  // of the picture
  // Where it is known; nullopt where nothing is. The second after one factor for each channel of linear
  // light, which exposure and white balance decide.
  std::optional<double> psnr_db, psnr_own_light_db;
};
// RGB of one size; known: one channel, not 0 where the background is known, or empty: everywhere.
WallErrors compare_walls(const Image8& found, const Image8& known, const Image8& truth);

// The background as a project shows it behind a frame, at the size of its pictures. Empty `rgb`: it knows
// none.
struct FoundWall {
  Image8 rgb, known;  // known: as compare_walls takes it
};
using WallBehind = std::function<FoundWall(int frame)>;

struct WallRow {
  std::string part;  // "whole picture"; "behind the person" of that frame, which no frame alone shows
  int pictures = 0;  // of wall_truth; without those for which the project has no background
  double known_share = 0;
  std::optional<double> psnr_db, psnr_own_light_db;  // means over pictures
};
// demo: the folder that `likeness demo` wrote with a --camera and whose clip the project imported.
Result<std::vector<WallRow>> study_walls(const Project& project, const std::filesystem::path& demo,
                                         const Progress& progress, std::stop_token stop);

}  // namespace likeness
