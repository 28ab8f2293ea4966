// What can be said of a track where nobody knows the truth: does it predict measurements it has not seen, and
// does it hold still where the head does?
#pragma once

#include <array>
#include <filesystem>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/scene/track.h"
#include "core/track/clip/track_clip.h"

namespace likeness {

// px of a picture of the tracked region with a longer side of `working_size`, as the tracker sees it.
struct FreshLandmarks {
  int frames = 0;
  double mean_px = 0;  // landmarks 17..67 found anew against the fitted model's, mean over points and frames
  // The same without what stays: each landmark's usual offset in the upright face. The predictor and the head
  // model draw a point of their own each, and that difference is no error of a track.
  double moving_px = 0;
  // That usual offset, found minus fitted, in distances between the outer corners of the eyes: x from
  // landmark 36 to 45, y down the picture. Zero for landmarks 0..16. What core/head/drawn_landmarks was made
  // from.
  std::array<Vec2d, kLandmarkCount> usual_offset;
};

struct Stillness {
  int frames = 0;        // middle frames of three that all rest
  double jitter_px = 0;  // RMS second difference of the projected nose tip
};

// The fitted model's landmarks in px of the working picture, one entry a frame of the track.
struct ProjectedLandmarks {
  bool known = false;  // camera known and frame not lost
  std::array<Vec2d, kLandmarkCount> points;
  double pitch = 0;  // of the face against the camera's axis, rad
};
std::vector<ProjectedLandmarks> project_track(const Track& track, const HeadModel& model,
                                              const CameraSet& cameras, const TrackRegion& region,
                                              int working_size);

// found: one entry for each of `fitted`. At least a few dozen frames, or the usual offsets are the frames'
// own.
FreshLandmarks compare_fresh(const std::vector<std::array<Vec2d, kLandmarkCount>>& found,
                             const std::vector<ProjectedLandmarks>& fitted);

// The head rests in a frame when over the 5 frames around it the nose tip stays within 1.5 px by 1.5 px, and
// its path, averaged over 9 frames, moves less than 0.3 px a frame. The averaging keeps a trembling track
// from hiding its own still stretches (a tremble of 0.4 px stays far below the 1.5 px); the extent keeps the
// turning points of a nodding head out, where the path's mean rests and the head does not.
Stillness measure_stillness(const std::vector<ProjectedLandmarks>& projected);

// A detection of its own in up to 200 frames with less than 20 degrees of pitch (below a bowed head the
// detector itself is the larger error): other seeds and shaken boxes than the tracker's, no hint.
Result<FreshLandmarks> find_fresh_landmarks(const std::filesystem::path& video, const Track& track,
                                            const std::vector<ProjectedLandmarks>& projected,
                                            const TrackRegion& region, const TrackOptions& options,
                                            const Progress& progress, std::stop_token stop);

}  // namespace likeness
