// What a hand does to a camera that does not travel: turn, zoom, and a small shift of the principal point.
// The background lies at infinity, so that a picture of it is a pinhole picture of the same directions
// wherever the camera points, and two pictures differ by a homography (Szeliski & Shum 1997, "Creating full
// view panoramic image mosaics").
#pragma once

#include "core/base/linalg.h"
#include "core/camera/camera.h"

namespace likeness {

struct HandheldView {
  Mat3d turn = Mat3d::Identity();  // cam_from_world; the world is the reference camera's frame
  double log_zoom = 0;             // focal lengths are the reference's times exp(log_zoom)
  Vec2d shift = Vec2d::Zero();     // px that the principal point lies off the reference's
};

// The reference's intrinsics, zoomed and shifted.
Intrinsics view_intrinsics(const Intrinsics& reference, const HandheldView& view);

// Order of a view's parameters in slopes and steps: a small turn (rad) applied after `turn`, log_zoom, shift
// (px).
inline constexpr int kViewParameters = 6;
using ViewStep = Eigen::Matrix<double, kViewParameters, 1>;
HandheldView stepped(const HandheldView& view, const ViewStep& step);
// The step from one view to another: stepped(from, view_step(from, to)) is `to`.
ViewStep view_step(const HandheldView& from, const HandheldView& to);

// From pixels of a view to pixels of a picture that looks straight ahead (a mosaic), in plain numbers.
template <class T>
struct ViewMap {
  T ray_x, ray_y, cx, cy;  // 1 / focal lengths and principal point of the view, px
  T back[9];               // world_from_cam, row-major
  T fx, fy, ox, oy;        // focal lengths and principal point of the mosaic, px
};

template <class T>
ViewMap<T> view_map(const Intrinsics& mosaic, const Intrinsics& reference, const HandheldView& view) {
  const Intrinsics k = view_intrinsics(reference, view);
  ViewMap<T> map{T(1 / k.fx),  T(1 / k.fy),  T(k.cx),      T(k.cy),     {},
                 T(mosaic.fx), T(mosaic.fy), T(mosaic.cx), T(mosaic.cy)};
  for (int i = 0; i < 9; ++i) map.back[i] = T(view.turn(i % 3, i / 3));
  return map;
}

// Where the mosaic shows what the view shows at (x, y). Directions more than about 84 degrees off the
// mosaic's axis have no place: depth is not above 0.1 then.
template <class T>
struct ViewPlace {
  T u, v, depth;
};
template <class T>
inline ViewPlace<T> view_place(const ViewMap<T>& m, T x, T y) {
  const T qx = (x - m.cx) * m.ray_x, qy = (y - m.cy) * m.ray_y;
  const T dx = m.back[0] * qx + m.back[1] * qy + m.back[2], dy = m.back[3] * qx + m.back[4] * qy + m.back[5],
          dz = m.back[6] * qx + m.back[7] * qy + m.back[8];
  return {m.fx * dx / dz + m.ox, m.fy * dy / dz + m.oy, dz};
}

// Slopes along the view's parameters of a mosaic value that is read at view_place(x, y) and has the slope
// (gu, gv) there.
template <class T>
inline void view_slopes(const ViewMap<T>& m, T x, T y, T gu, T gv, T (&slopes)[kViewParameters]) {
  const T qx = (x - m.cx) * m.ray_x, qy = (y - m.cy) * m.ray_y;
  const T dx = m.back[0] * qx + m.back[1] * qy + m.back[2], dy = m.back[3] * qx + m.back[4] * qy + m.back[5],
          dz = m.back[6] * qx + m.back[7] * qy + m.back[8];
  // Along the direction d in the world, then along the ray q in the camera's frame: b.
  const T ax = gu * m.fx / dz, ay = gv * m.fy / dz, az = -(ax * dx + ay * dy) / dz;
  const T bx = ax * m.back[0] + ay * m.back[3] + az * m.back[6],
          by = ax * m.back[1] + ay * m.back[4] + az * m.back[7],
          bz = ax * m.back[2] + ay * m.back[5] + az * m.back[8];
  slopes[0] = by - bz * qy;  // a turn w moves the ray by q cross w
  slopes[1] = bz * qx - bx;
  slopes[2] = bx * qy - by * qx;
  slopes[3] = -(bx * qx + by * qy);
  slopes[4] = -bx * m.ray_x;
  slopes[5] = -by * m.ray_y;
}

}  // namespace likeness
