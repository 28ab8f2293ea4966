// Camera look-up, the inverse of the distortion model, and intrinsics of a crop.
#include "core/camera/camera.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/camera/lens_math.h"

namespace likeness {

const char* camera_kind_name(CameraKind kind) {
  switch (kind) {
    case CameraKind::resting:
      return "resting";
    case CameraKind::handheld:
      return "handheld";
    case CameraKind::walking:
      return "walking";
  }
  return "";
}

std::optional<CameraKind> camera_kind_named(std::string_view name) {
  for (const CameraKind kind : {CameraKind::resting, CameraKind::handheld, CameraKind::walking})
    if (name == camera_kind_name(kind)) return kind;
  return std::nullopt;
}

const Camera* find_camera(const CameraSet& set, int frame) {
  if (set.rests()) return set.cameras.empty() ? nullptr : &set.cameras.front();
  const auto it = std::lower_bound(set.cameras.begin(), set.cameras.end(), frame,
                                   [](const Camera& camera, int number) { return camera.frame < number; });
  return it != set.cameras.end() && it->frame == frame ? &*it : nullptr;
}

Vec3d ray_direction(const Intrinsics& k, const Vec2d& pixel) {
  Vec3d direction(0, 0, 1);
  undistorted({k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2}, pixel.x(), pixel.y(), direction.x(),
              direction.y());
  return direction;
}

Intrinsics crop_intrinsics(const Intrinsics& k, double x, double y, double side, int size) {
  LIKENESS_CHECK(side > 0 && size > 0, "crop of side %g to %d px", side, size);
  const double scale = size / side;
  Intrinsics result = k;
  result.width = result.height = size;
  result.fx = k.fx * scale;
  result.fy = k.fy * scale;
  result.cx = (k.cx - x) * scale;
  result.cy = (k.cy - y) * scale;
  return result;
}

Camera view_of_part(Camera camera, const PixelRect& part) {
  if (part.empty()) return camera;
  Intrinsics& k = camera.intrinsics;
  k.cx -= part.x, k.cy -= part.y;
  k.width = part.width, k.height = part.height;
  return camera;
}

Mat3d pinhole_matrix(const Intrinsics& k) {
  Mat3d m;
  m << k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1;
  return m;
}

Mat3d inverse_pinhole_matrix(const Intrinsics& k) {
  Mat3d m;
  m << 1 / k.fx, 0, -k.cx / k.fx, 0, 1 / k.fy, -k.cy / k.fy, 0, 0, 1;
  return m;
}

Intrinsics in_whole_picture(Intrinsics k, const PixelRect& part, int width, int height) {
  if (part.empty()) return k;
  k.cx += part.x, k.cy += part.y;
  k.width = width, k.height = height;
  return k;
}

Camera resized(Camera camera, int width) {
  Intrinsics& k = camera.intrinsics;
  const double scale = double(width) / std::max(1, k.width);
  k.fx *= scale, k.fy *= scale, k.cx *= scale, k.cy *= scale;
  k.height = int(std::lround(k.height * scale));
  k.width = width;
  return camera;
}

}  // namespace likeness
