#include "core/track/points/patch_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/dense_solves.h"
#include "core/image/bilinear.h"

namespace likeness {
namespace {

// 11 px square in the view, at each size: under wider ones the skin is not planar, and errors of the pose
// matter more.
constexpr int kReach = 5, kSide = 2 * kReach + 1;
constexpr int kPixels = kSide * kSide;
constexpr double kMinFacing = 0.5;
constexpr double kMinContrast = 2.0;      // levels, standard deviation
constexpr double kMinCorrelation = 0.80;  // below: hidden, or something else
constexpr double kMaxStretch = 2.5;       // of area between reference and view

using Mat2d = Eigen::Matrix2d;

bool inside(const Image8& picture, const Vec2d& px, double margin) {
  return px.x() >= margin && px.y() >= margin && px.x() <= picture.width - margin &&
         px.y() <= picture.height - margin;
}

// Bilinear; pixel centres at +0.5; the caller stays inside. How a step in the patch's plane (tangents a, b)
// moves its picture, px per m.
Mat2d pixels_from_plane(const PatchView& view, const Vec3d& point, const Vec3d& a, const Vec3d& b) {
  const Vec3d p = view.cam_from_head * point;
  const double z = p.z();
  Eigen::Matrix<double, 2, 3> by_cam;
  by_cam << view.intrinsics.fx / z, 0, -view.intrinsics.fx * p.x() / (z * z), 0, view.intrinsics.fy / z,
      -view.intrinsics.fy * p.y() / (z * z);
  Eigen::Matrix<double, 3, 2> plane;
  plane << a, b;
  return by_cam * view.cam_from_head.linear() * plane;
}

struct Template {
  std::array<double, kPixels> value, by_x, by_y;  // value: zero mean
  double contrast = 0;                            // standard deviation, levels
  Mat2d hessian = Mat2d::Zero();
};

// The reference's values at the offsets of the view's pixels.
Template cut(const Image8& reference, const Vec2d& centre, const Mat2d& reference_from_view) {
  constexpr int kWide = kSide + 2;
  std::array<double, kWide * kWide> wide;
  for (int y = 0; y < kWide; ++y)
    for (int x = 0; x < kWide; ++x) {
      const Vec2d at = centre + reference_from_view * Vec2d(x - kReach - 1, y - kReach - 1);
      wide[y * kWide + x] = bilinear(reference, at.x(), at.y());
    }
  Template t;
  double mean = 0, square = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const int at = (y + 1) * kWide + x + 1, i = y * kSide + x;
      t.value[i] = wide[at];
      t.by_x[i] = 0.5 * (wide[at + 1] - wide[at - 1]);
      t.by_y[i] = 0.5 * (wide[at + kWide] - wide[at - kWide]);
      mean += wide[at];
    }
  mean /= kPixels;
  for (int i = 0; i < kPixels; ++i) {
    t.value[i] -= mean;
    square += t.value[i] * t.value[i];
    const Vec2d g(t.by_x[i], t.by_y[i]);
    t.hessian += g * g.transpose();
  }
  t.contrast = std::sqrt(square / kPixels);
  return t;
}

// Shifts `at` until the picture looks like the template; returns the correlation reached, or nullopt.
std::optional<double> settle(const Template& t, const Image8& picture, double reach, Vec2d* at) {
  const Vec2d start = *at;
  std::array<double, kPixels> value;
  double correlation = 0;
  for (int iteration = 0; iteration < 15; ++iteration) {
    if (!inside(picture, *at, kReach + 1.5) || (*at - start).norm() > reach) return std::nullopt;
    double mean = 0, square = 0, cross = 0;
    for (int y = 0, i = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x, ++i)
        mean += value[i] = bilinear(picture, at->x() + x - kReach, at->y() + y - kReach);
    mean /= kPixels;
    for (int i = 0; i < kPixels; ++i) {
      value[i] -= mean;
      square += value[i] * value[i];
      cross += value[i] * t.value[i];
    }
    const double contrast = std::sqrt(square / kPixels);
    if (contrast < 0.5 * kMinContrast) return std::nullopt;
    correlation = cross / (kPixels * contrast * t.contrast);
    const double gain = t.contrast / contrast;
    Vec2d gradient = Vec2d::Zero();
    for (int i = 0; i < kPixels; ++i) {
      const double off = gain * value[i] - t.value[i];
      gradient += off * Vec2d(t.by_x[i], t.by_y[i]);
    }
    const Vec2d step = solve_symmetric<2>(t.hessian, gradient);
    if (!step.allFinite()) return std::nullopt;
    *at -= step;
    if (step.norm() < 0.01) break;
  }
  if ((*at - start).norm() > reach) return std::nullopt;
  return correlation;
}

}  // namespace

PatchPicture patch_picture(const Image8& grey) {
  PatchPicture picture{&grey, Image8(grey.width / 2, grey.height / 2, 1)};
  for (int y = 0; y < picture.half.height; ++y)
    for (int x = 0; x < picture.half.width; ++x)
      *picture.half.at(x, y) =
          static_cast<std::uint8_t>((*grey.at(2 * x, 2 * y) + *grey.at(2 * x + 1, 2 * y) +
                                     *grey.at(2 * x, 2 * y + 1) + *grey.at(2 * x + 1, 2 * y + 1) + 2) /
                                    4);
  return picture;
}

double patch_facing(const HeadPatch& patch, const Pose& cam_from_head) {
  const Vec3d p = cam_from_head * patch.point;
  return -p.normalized().dot(cam_from_head.linear() * patch.normal);
}

std::optional<PatchMatch> find_patch(const HeadPatch& patch, const PatchView& reference,
                                     const PatchView& view, double reach) {
  if (patch_facing(patch, view.cam_from_head) < kMinFacing) return std::nullopt;
  const Vec3d in_cam = view.cam_from_head * patch.point;
  if (in_cam.z() < 0.05) return std::nullopt;
  const Vec3d a = patch.normal.unitOrthogonal(), b = patch.normal.cross(a);
  const Mat2d there = pixels_from_plane(reference, patch.point, a, b),
              here = pixels_from_plane(view, patch.point, a, b);
  const Mat2d reference_from_view = there * here.inverse();
  const double stretch = std::abs(reference_from_view.determinant());
  if (!reference_from_view.allFinite() || stretch > kMaxStretch || stretch < 1 / kMaxStretch)
    return std::nullopt;
  Vec2d at = project<double>(view.intrinsics, in_cam);
  const Vec2d predicted = at;
  double correlation = 0;
  for (int level = 1; level >= 0; --level) {
    const double size = level == 1 ? 0.5 : 1.0;
    const Image8& from = level == 1 ? reference.picture->half : *reference.picture->whole;
    const Image8& to = level == 1 ? view.picture->half : *view.picture->whole;
    const Vec2d centre = size * patch.pixel;
    const double margin = (kReach + 1.5) * reference_from_view.cwiseAbs().rowwise().sum().maxCoeff();
    if (!inside(from, centre, margin)) return std::nullopt;
    const Template t = cut(from, centre, reference_from_view);
    // A patch whose texture varies in one direction only slides along the other.
    const double trace = t.hessian.trace(), least = t.hessian.determinant() / std::max(1e-9, trace);
    if (t.contrast < kMinContrast || least < 0.05 * trace) return std::nullopt;
    Vec2d scaled = size * at;
    const auto reached = settle(t, to, level == 1 ? size * reach : 0.5 * reach, &scaled);
    if (!reached) return std::nullopt;
    at = scaled / size;
    correlation = *reached;
  }
  if (correlation < kMinCorrelation || (at - predicted).norm() > reach) return std::nullopt;
  return PatchMatch{at, correlation};
}

}  // namespace likeness
