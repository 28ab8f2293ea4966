// Cameras of a clip: one static camera where nothing outside the person moves, otherwise structure from
// motion by the `colmap` program on person-masked frames.
#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/image/image.h"

namespace likeness {

// Where the person is, coarsely, in source pixels; the caller (core/matte) knows faces, this library does
// not. Given a frame number and its picture: one channel, 255 = ignore.
using PersonMask = std::function<Image8(int frame, const Image8& rgb)>;

struct AlignOptions {
  double static_motion_px_per_1000 = 1.5;  // median background motion, in px per 1000 px of picture width
  bool resting = false;                    // the user's word that the camera rests: nothing is measured
  double lens_mm = 0;             // and on its lens, as film_intrinsics takes it; 0: as the clip says
  int keyframes = 80;             // at most this many go through colmap
  int colmap_width = 540;         // px the keyframes are reduced to; raising it costs quadratically
  int colmap_features = 2000;     // per keyframe
  std::string colmap = "colmap";  // the program: a name looked up in PATH, or a path
  int seed = 0;
  // Where import kept what its decoding showed for this (core/camera/kept_path.h); empty: nowhere. Changes no
  // result.
  std::filesystem::path kept{};
  std::string mask_inputs{};  // names what the person mask is made with: kept motion under another is not it
};

// How far the background may stray in a rest, as measure_background_motion takes it.
inline double rest_limit(const AlignOptions& options) { return options.static_motion_px_per_1000 / 2; }

struct AlignResult {
  CameraSet cameras;
  std::string evidence;  // why the camera was taken as static or moving, in words with numbers
  int frames = 0, registered = 0;
  std::vector<std::string> warnings;
  std::vector<std::string> photos;  // align_photos: file name of photograph `frame` = 0, 1, ...
};

// work: folder for colmap's database and images; kept, so that an interrupted solve continues.
Result<AlignResult> align_clip(const std::filesystem::path& video, const PersonMask& person,
                               const std::filesystem::path& work, const AlignOptions& options,
                               const Progress& progress, std::stop_token stop);

// The same for a folder of photographs with no masking beyond what `person` says.
Result<AlignResult> align_photos(const std::filesystem::path& folder, const PersonMask& person,
                                 const std::filesystem::path& work, const AlignOptions& options,
                                 const Progress& progress, std::stop_token stop);

}  // namespace likeness
