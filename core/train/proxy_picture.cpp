// Every pixel of the part is looked up in the moment's own picture.
#include "core/train/proxy_picture.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/rigid.h"
#include "core/image/bilinear.h"

namespace likeness {
namespace {

constexpr double kHiddenBy = 0.005;            // m
constexpr double kSlant = 0.2, kSquare = 0.5;  // cosines between which the moment's own pixel takes over
constexpr int kOwnMatte = 250, kExplainViews = 8;
constexpr float kForeign = 0.4f;  // from the usual colour, encoded: farther than lips, teeth and glints reach
constexpr float kForeignAtSlant = 0.12f;  // where the place is seen edge-on

// A moment's part, and its own picture laid on it.
class Moment {
 public:
  Moment(const ProxyPart& part, const ProxyPart* before, const TrainingView& view)
      : view_(view),
        surface_(part.pose(view)),
        normals_(vertex_normals(surface_.vertices, part.triangles)),
        cam_from_surface_(view.camera.cam_from_world * surface_.world_from_surface),
        eye_(inverse(cam_from_surface_).translation()),
        seen_(rasterise(surface_.vertices, part.triangles, view.camera.intrinsics, cam_from_surface_)) {
    if (before != nullptr) before_ = see_proxy(*before, view);
  }

  // Of a place on a triangle; `usual`: the part's colour there.
  Vec3f colour(const Triangle& triangle, const Vec3f& weights, const Vec3f& usual) const {
    Vec3f place = Vec3f::Zero(), normal = place;
    for (int c = 0; c < 3; ++c)
      place += weights[c] * surface_.vertices[std::size_t(triangle[c])],
          normal += weights[c] * normals_[std::size_t(triangle[c])];
    const Vec3d p = place.cast<double>(), in_cam = cam_from_surface_ * p;
    const double facing = normal.cast<double>().normalized().dot((eye_ - p).normalized());
    if (!(facing > kSlant) || !(in_cam.z() > 0)) return usual;
    const Vec2d pixel = project<double>(view_.camera.intrinsics, in_cam);
    if (!(pixel.x() >= 1 && pixel.y() >= 1 && pixel.x() < seen_.width - 1 && pixel.y() < seen_.height - 1))
      return usual;
    const int x = int(pixel.x()), y = int(pixel.y());
    const std::size_t i = std::size_t(y) * std::size_t(seen_.width) + std::size_t(x);
    if (seen_.depth[i] == 0 || in_cam.z() > seen_.depth[i] + kHiddenBy) return usual;
    if (before_ && before_->depth[i] > 0 && before_->depth[i] < in_cam.z()) return usual;
    if (view_.alpha.at(x, y) < kOwnMatte || (!view_.teaches.empty() && view_.teaches.at(x, y) == 0))
      return usual;
    const float own = float(std::clamp((facing - kSlant) / (kSquare - kSlant), 0.0, 1.0));
    const Vec3f here = bilinear_colour(view_.rgb, pixel.x(), pixel.y()) / 255.f;
    // A hand, a cup; at a slant, what stands beside the place.
    if ((here - usual).norm() > kForeignAtSlant + (kForeign - kForeignAtSlant) * own) return usual;
    return own * here + (1 - own) * usual;
  }

 private:
  const TrainingView& view_;
  PosedSurface surface_;
  std::vector<Vec3f> normals_;
  Pose cam_from_surface_;
  Vec3d eye_;
  Raster seen_;
  std::optional<Raster> before_;
};

bool faces_away(const std::vector<Vec3f>& posed, const Triangle& triangle, const Vec3f& eye) {
  const Vec3f &a = posed[std::size_t(triangle[0])], &b = posed[std::size_t(triangle[1])],
              &c = posed[std::size_t(triangle[2])];
  return (b - a).cross(c - a).dot(eye - a) < 0;
}

}  // namespace

Raster see_proxy(const ProxyPart& part, const TrainingView& view) {
  const PosedSurface posed = part.pose(view);
  return rasterise(posed.vertices, part.triangles, view.camera.intrinsics,
                   view.camera.cam_from_world * posed.world_from_surface);
}

ProxyPicture draw_proxy(const ProxyPart& part, const ProxyPart* before, const TrainingView& moment,
                        const TrainingView& shown) {
  const Moment own(part, before, moment);
  const PosedSurface posed = part.pose(shown);
  const Pose cam_from_surface = shown.camera.cam_from_world * posed.world_from_surface;
  const Vec3f eye = inverse(cam_from_surface).translation().cast<float>();
  const Intrinsics& k = shown.camera.intrinsics;
  ProxyPicture picture;
  picture.raster = rasterise(posed.vertices, part.triangles, k, cam_from_surface);
  picture.rgb = Image8(k.width, k.height, 3), picture.alpha = Image8(k.width, k.height, 1);
  const std::size_t pixels = picture.raster.triangle.size();
  picture.other.assign(pixels, 0), picture.inner.assign(pixels, 0);
  const std::optional<Raster> hides =
      before != nullptr ? std::optional(see_proxy(*before, shown)) : std::nullopt;
  for (std::size_t i = 0; i < pixels; ++i) {
    picture.other[i] = hides && hides->depth[i] > 0;
    if (picture.raster.triangle[i] < 0) continue;
    if (picture.other[i] && hides->depth[i] < picture.raster.depth[i]) continue;
    const Triangle& triangle = part.triangles[std::size_t(picture.raster.triangle[i])];
    const Vec3f& weights = picture.raster.barycentric[i];
    Vec3f usual = Vec3f::Zero();
    for (int c = 0; c < 3; ++c) usual += weights[c] * part.colours[std::size_t(triangle[c])];
    const Vec3f colour = own.colour(triangle, weights, usual);
    for (int c = 0; c < 3; ++c)
      picture.rgb.data[3 * i + std::size_t(c)] =
          std::uint8_t(std::lround(255 * std::clamp(colour[c], 0.f, 1.f)));
    picture.alpha.data[i] = 255;
    picture.inner[i] = faces_away(posed.vertices, triangle, eye);
  }
  return picture;
}

HalfPicture above_place(const TrainingView& view, const Pose& world_from_part, const Vec3d& place) {
  const Pose cam_from_part = view.camera.cam_from_world * world_from_part;
  return {project<double>(view.camera.intrinsics, Vec3d(cam_from_part * place)),
          (cam_from_part.linear() * Vec3d::UnitY()).head<2>()};
}

HalfPicture other_half(HalfPicture half) {
  half.towards = -half.towards;
  return half;
}

double unexplained(const TrainingSet& set, std::span<const ProxyPart* const> parts,
                   const std::function<std::vector<HalfPicture>(const TrainingView&)>& halves) {
  const std::span<const TrainingView> own = own_views(set);
  std::size_t person = 0, outside = 0;
  for (const std::size_t i : evenly(own.size(), kExplainViews)) {
    const TrainingView& view = own[i];
    if (view.alpha.empty()) continue;
    std::vector<Raster> seen;
    for (const ProxyPart* part : parts) seen.push_back(see_proxy(*part, view));
    const std::vector<HalfPicture> within = halves(view);
    for (int y = 0; y < view.alpha.height; ++y)
      for (int x = 0; x < view.alpha.width; ++x) {
        if (view.alpha.at(x, y) < 128) continue;
        if (!std::ranges::all_of(within, [&](const HalfPicture& half) { return half.at(x, y); })) continue;
        ++person;
        const std::size_t pixel = std::size_t(y) * std::size_t(view.alpha.width) + std::size_t(x);
        outside += std::ranges::none_of(seen, [&](const Raster& part) { return part.triangle[pixel] >= 0; });
      }
  }
  return person > 0 ? double(outside) / double(person) : 1;
}

}  // namespace likeness
