// Cameras of frames between solved keyframes: the keyframes' 3-D points followed into them by optical flow,
// then perspective-n-point with a residual gate. About 70 ms a frame; a tenth of the error of interpolated
// poses.
#pragma once

#include <filesystem>
#include <set>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/camera/colmap_model.h"
#include "core/image/image.h"
#include "core/image/pixel_rect.h"

namespace likeness {

// A solved keyframe: what it sees of the 3-D points. Pixels are of the reduced picture that colmap saw.
struct SolvedKeyframe {
  int frame = 0;
  Pose cam_from_world = Pose::Identity();
  std::vector<Vec2d> pixels;
  std::vector<Vec3d> points;  // same count
};
// Ascending frame; names of the model's pictures are frame numbers ("000123.png").
std::vector<SolvedKeyframe> keyframes_of(const ColmapModel& model);

// A frame as its points are followed: reduced, then grey. (height, width, 1)
Image8 followed_picture(const Image8& rgb, int width, int height);

// Poses of the `wanted` frames, those that pass the gate, ascending. small: intrinsics of the reduced
// pictures. kept: where those pictures may be (core/video/grey_pictures.h, under the video's hash), or empty;
// the video is decoded where they are not. film: the part of its pictures that `small` is about; empty: all.
Result<std::vector<Camera>> resect_frames(const std::filesystem::path& video, const PixelRect& film,
                                          const std::vector<SolvedKeyframe>& keyframes,
                                          const Intrinsics& small, const std::set<int>& wanted,
                                          const std::filesystem::path& kept, const Progress& progress,
                                          std::stop_token stop);

// One pose for several noisy ones of a camera at rest: mean centre and mean rotation of the inner majority.
Pose mean_pose(const std::vector<Pose>& poses);

}  // namespace likeness
