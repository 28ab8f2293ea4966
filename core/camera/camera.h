// Pinhole cameras with Brown-Conrady distortion. OpenCV axes: x right, y down, z forward. Pixel (0,0) is the
// centre of the top-left pixel minus half a pixel: the picture covers [0, width] x [0, height], pixel centres
// at +0.5.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/image/pixel_rect.h"

namespace likeness {

struct Intrinsics {
  int width = 0, height = 0;              // px
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;  // radial and tangential distortion, OpenCV's order
};

struct Camera {
  int frame = 0;  // number of the frame in the source video
  Intrinsics intrinsics;
  Pose cam_from_world = Pose::Identity();
};

enum class CameraScale { arbitrary, metric };

// What the camera does. A hand-held one turns and zooms about one place: what it sees behind the person is a
// wall without parallax. A walking one shows the room from several places.
enum class CameraKind { resting, handheld, walking };

// "resting", "handheld", "walking"
const char* camera_kind_name(CameraKind kind);
std::optional<CameraKind> camera_kind_named(std::string_view name);

// A stretch of a clip between two cuts.
struct CameraShot {
  double from_s = 0, to_s = 0;
  CameraKind camera = CameraKind::resting;
};

// Cameras of a clip, on whole uncropped frames (rotation tag already applied).
struct CameraSet {
  CameraKind kind = CameraKind::resting;
  CameraScale scale = CameraScale::metric;
  double reprojection_px = 0;  // mean, of a structure-from-motion solve
  // Resting: exactly one, frame = -1, and the world is its frame. Otherwise ascending frame, frames may be
  // missing; hand-held ones are all at the world's origin, each with its own zoom.
  std::vector<Camera> cameras;
  std::vector<CameraShot> shots{};  // in order; empty: the whole clip is one

  bool rests() const { return kind == CameraKind::resting; }
};

// Camera of a source frame; nullptr where the solve has none.
const Camera* find_camera(const CameraSet& set, int frame);

// Pixel of a point in the camera frame (z > 0), distortion applied. Scalar may be double or a Ceres Jet.
template <class T>
Eigen::Matrix<T, 2, 1> project(const Intrinsics& k, const Eigen::Matrix<T, 3, 1>& point_in_cam) {
  const T x = point_in_cam.x() / point_in_cam.z(), y = point_in_cam.y() / point_in_cam.z();
  const T r2 = x * x + y * y, radial = T(1) + r2 * (T(k.k1) + r2 * T(k.k2));
  const T xd = x * radial + T(2 * k.p1) * x * y + T(k.p2) * (r2 + T(2) * x * x);
  const T yd = y * radial + T(k.p1) * (r2 + T(2) * y * y) + T(2 * k.p2) * x * y;
  return {T(k.fx) * xd + T(k.cx), T(k.fy) * yd + T(k.cy)};
}

// Of a pinhole without distortion, (3, 3): takes directions in the camera frame to homogeneous pixels, and
// back.
Mat3d pinhole_matrix(const Intrinsics& k);
Mat3d inverse_pinhole_matrix(const Intrinsics& k);

// Direction (not normalised, z = 1) in the camera frame of the ray through a pixel; inverts the distortion.
Vec3d ray_direction(const Intrinsics& k, const Vec2d& pixel);

// Intrinsics of the square [x, x+side) x [y, y+side) of the picture, resampled to size x size pixels.
Intrinsics crop_intrinsics(const Intrinsics& k, double x, double y, double side, int size);

// The same view of a part of its picture; an empty one: of all of it.
Camera view_of_part(Camera camera, const PixelRect& part);

// Intrinsics of a part of a picture, for the whole one, which is `width` by `height`. part empty: the whole.
Intrinsics in_whole_picture(Intrinsics k, const PixelRect& part, int width, int height);

// The same view at another picture width.
Camera resized(Camera camera, int width);

// cameras.json of the command-line contract: versioned, with units; poses are row-major 3x4.
Result<void> write_cameras(const std::filesystem::path& path, const CameraSet& set);
Result<CameraSet> read_cameras(const std::filesystem::path& path);

}  // namespace likeness
