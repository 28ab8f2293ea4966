// A z-buffer rasteriser: exact pixel centres, perspective-correct, clipped in front of the camera.
//
// Inverse depth and barycentric / depth are linear in the picture plane, so both are interpolated with the
// edge functions of the projected triangle. The picture is cut into bands of rows that are filled in
// parallel, each by its own list of triangles in ascending order.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr int kBandRows = 16;
constexpr double kNearOverFar = 1e-3;  // the near plane as a share of the farthest vertex; scale-free

struct Corner {
  Vec3d point;   // camera frame
  Vec3d weight;  // barycentric in the original triangle
};

// A corner in the picture; not valid behind the near plane or where the distortion folds back.
struct PictureCorner {
  Vec2d pixel;
  double inverse_depth = 0;
  bool valid = false;
};

// A triangle or a piece of a clipped one, in the picture.
struct Piece {
  int triangle = -1;
  std::array<Vec2d, 3> pixel;
  std::array<double, 3> inverse_depth;
  double inverse_area = 0;  // 1 / (twice the signed area), px^-2
  int clipped = -1;         // index of its corners' weights; -1: the triangle's own corners
};

struct Pieces {
  std::vector<Piece> list;
  std::vector<std::array<Vec3d, 3>> clipped_weights;
};

// Beyond this radius x^2+y^2 (z = 1) the radial distortion is no longer monotone and would fold back into
// view.
double largest_radius_squared(const Intrinsics& k) {
  // Zero of 1 + 3 k1 s + 5 k2 s^2, s = r^2.
  const double a = 5 * k.k2, b = 3 * k.k1;
  if (a == 0) return b < 0 ? -1 / b : std::numeric_limits<double>::infinity();
  const double discriminant = b * b - 4 * a;
  if (discriminant < 0) return std::numeric_limits<double>::infinity();
  const double root = std::sqrt(discriminant);
  double least = std::numeric_limits<double>::infinity();
  for (const double s : {(-b - root) / (2 * a), (-b + root) / (2 * a)})
    if (s > 0) least = std::min(least, s);
  return least;
}

// Sutherland-Hodgman against z = near; 0, 3 or 4 corners.
int clip_near(const std::array<Corner, 3>& in, double near, std::array<Corner, 4>& out) {
  int count = 0;
  for (int k = 0; k < 3; ++k) {
    const Corner &from = in[k], &to = in[(k + 1) % 3];
    const bool from_inside = from.point.z() >= near, to_inside = to.point.z() >= near;
    if (from_inside) out[count++] = from;
    if (from_inside == to_inside) continue;
    const double t = (near - from.point.z()) / (to.point.z() - from.point.z());
    out[count++] = {from.point + t * (to.point - from.point), from.weight + t * (to.weight - from.weight)};
  }
  return count;
}

double cross(const Vec2d& a, const Vec2d& b) { return a.x() * b.y() - a.y() * b.x(); }

PictureCorner to_picture(const Intrinsics& k, double near, double radius_squared, const Vec3d& point) {
  PictureCorner corner;
  // The comparison allows for the rounding of a corner clipped to the near plane.
  if (!(point.z() >= near * (1 - 1e-9)) || !point.allFinite()) return corner;
  if (point.head<2>().squaredNorm() > radius_squared * point.z() * point.z()) return corner;
  corner.pixel = project<double>(k, point);
  corner.inverse_depth = 1 / point.z();
  corner.valid = corner.pixel.allFinite();
  return corner;
}

bool append_piece(int triangle, const PictureCorner& a, const PictureCorner& b, const PictureCorner& c,
                  Pieces& pieces) {
  const double area = cross(b.pixel - a.pixel, c.pixel - a.pixel);
  if (!a.valid || !b.valid || !c.valid || area == 0) return false;
  pieces.list.push_back(
      {triangle, {a.pixel, b.pixel, c.pixel}, {a.inverse_depth, b.inverse_depth, c.inverse_depth}, 1 / area});
  return true;
}

Pieces project_triangles(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                         const Intrinsics& k, const Pose& cam_from_mesh) {
  std::vector<Vec3d> points(vertices.size());
  double farthest = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    points[v] = cam_from_mesh * vertices[v].cast<double>();
    if (points[v].z() < std::numeric_limits<double>::infinity()) farthest = std::max(farthest, points[v].z());
  }
  Pieces pieces;
  if (!(farthest > 0)) return pieces;  // all behind the camera
  const double near = kNearOverFar * farthest, radius_squared = largest_radius_squared(k);
  std::vector<PictureCorner> corners(points.size());
  for (std::size_t v = 0; v < points.size(); ++v) corners[v] = to_picture(k, near, radius_squared, points[v]);

  pieces.list.reserve(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Triangle& triangle = triangles[t];
    LIKENESS_CHECK(triangle.minCoeff() >= 0 && std::size_t(triangle.maxCoeff()) < points.size(),
                   "triangle (%d, %d, %d) of %d vertices", triangle[0], triangle[1], triangle[2],
                   int(points.size()));
    std::array<Corner, 3> whole;
    bool finite = true, clip = false;
    for (int i = 0; i < 3; ++i) {
      whole[i] = {points[triangle[i]], Vec3d::Unit(i)};
      finite = finite && whole[i].point.allFinite();
      clip = clip || whole[i].point.z() < near;
    }
    if (!finite) continue;
    if (!clip) {
      append_piece(int(t), corners[triangle[0]], corners[triangle[1]], corners[triangle[2]], pieces);
      continue;
    }
    std::array<Corner, 4> part;
    const int count = clip_near(whole, near, part);
    for (int i = 2; i < count; ++i) {
      std::array<PictureCorner, 3> seen;
      const std::array<const Corner*, 3> fan = {&part[0], &part[i - 1], &part[i]};
      for (int c = 0; c < 3; ++c) seen[c] = to_picture(k, near, radius_squared, fan[c]->point);
      if (!append_piece(int(t), seen[0], seen[1], seen[2], pieces)) continue;
      pieces.list.back().clipped = int(pieces.clipped_weights.size());
      pieces.clipped_weights.push_back({fan[0]->weight, fan[1]->weight, fan[2]->weight});
    }
  }
  return pieces;
}

// First pixel whose centre is at or after x, and one past the last whose centre is at or before it, within
// [0, limit].
int first_centre(double x, int limit) { return int(std::clamp(std::ceil(x - 0.5), 0.0, double(limit))); }
int end_centre(double x, int limit) { return int(std::clamp(std::floor(x - 0.5) + 1, 0.0, double(limit))); }

struct RowRange {
  int first = 0, end = 0;
};

RowRange rows_of(const Piece& piece, int height) {
  const auto [low, high] = std::minmax({piece.pixel[0].y(), piece.pixel[1].y(), piece.pixel[2].y()});
  return {first_centre(low, height), end_centre(high, height)};
}

void fill_piece(const Piece& piece, int index, RowRange rows, int width, std::vector<double>& inverse_depth,
                std::vector<int>& seen) {
  const auto [left, right] = std::minmax({piece.pixel[0].x(), piece.pixel[1].x(), piece.pixel[2].x()});
  const int first = first_centre(left, width), end = end_centre(right, width);
  for (int y = rows.first; y < rows.end; ++y) {
    for (int x = first; x < end; ++x) {
      const Vec2d centre(x + 0.5, y + 0.5);
      const double w0 = cross(piece.pixel[1] - centre, piece.pixel[2] - centre) * piece.inverse_area;
      const double w1 = cross(piece.pixel[2] - centre, piece.pixel[0] - centre) * piece.inverse_area;
      const double w2 = 1 - w0 - w1;
      if (w0 < 0 || w1 < 0 || w2 < -1e-12) continue;
      const double depth =
          w0 * piece.inverse_depth[0] + w1 * piece.inverse_depth[1] + w2 * piece.inverse_depth[2];
      const std::size_t pixel = std::size_t(y) * width + x;
      if (depth <= inverse_depth[pixel]) continue;  // the lower triangle wins a tie
      inverse_depth[pixel] = depth;
      seen[pixel] = index;
    }
  }
}

Vec3f weights_at(const Pieces& pieces, const Piece& piece, const Vec2d& centre, double inverse_depth) {
  const double w0 = cross(piece.pixel[1] - centre, piece.pixel[2] - centre) * piece.inverse_area;
  const double w1 = cross(piece.pixel[2] - centre, piece.pixel[0] - centre) * piece.inverse_area;
  Vec3d weight(w0 * piece.inverse_depth[0], w1 * piece.inverse_depth[1],
               (1 - w0 - w1) * piece.inverse_depth[2]);
  if (piece.clipped >= 0) {
    const std::array<Vec3d, 3>& corners = pieces.clipped_weights[piece.clipped];
    weight = (weight[0] * corners[0] + weight[1] * corners[1] + weight[2] * corners[2]).eval();
  }
  return (weight / inverse_depth).cast<float>();
}

}  // namespace

Raster rasterise(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                 const Intrinsics& intrinsics, const Pose& cam_from_mesh) {
  const int width = intrinsics.width, height = intrinsics.height;
  LIKENESS_CHECK(width >= 0 && height >= 0, "picture of %d x %d", width, height);
  const Pieces pieces = project_triangles(vertices, triangles, intrinsics, cam_from_mesh);

  // -- Bands
  const int bands = (height + kBandRows - 1) / kBandRows;
  std::vector<std::vector<int>> band_pieces(static_cast<std::size_t>(bands));
  for (int p = 0; p < int(pieces.list.size()); ++p) {
    const RowRange rows = rows_of(pieces.list[p], height);
    if (rows.first >= rows.end) continue;
    for (int band = rows.first / kBandRows; band <= (rows.end - 1) / kBandRows; ++band)
      band_pieces[band].push_back(p);
  }

  // -- Fill
  const std::size_t count = std::size_t(width) * height;
  Raster raster{width, height, std::vector<int>(count, -1), std::vector<float>(count, 0.0f),
                std::vector<Vec3f>(count, Vec3f::Zero())};
  std::vector<double> inverse_depth(count, 0.0);
  std::vector<int> seen(count, -1);
  parallel_for(std::size_t(bands), [&](std::size_t band) {
    const int top = int(band) * kBandRows, bottom = std::min(height, top + kBandRows);
    for (const int p : band_pieces[band]) {
      const RowRange rows = rows_of(pieces.list[p], height);
      fill_piece(pieces.list[p], p, {std::max(rows.first, top), std::min(rows.end, bottom)}, width,
                 inverse_depth, seen);
    }
    for (std::size_t pixel = std::size_t(top) * width; pixel < std::size_t(bottom) * width; ++pixel) {
      if (seen[pixel] < 0) continue;
      const Piece& piece = pieces.list[seen[pixel]];
      const Vec2d centre(double(pixel % width) + 0.5, double(pixel / width) + 0.5);
      raster.triangle[pixel] = piece.triangle;
      raster.depth[pixel] = float(1 / inverse_depth[pixel]);
      raster.barycentric[pixel] = weights_at(pieces, piece, centre, inverse_depth[pixel]);
    }
  });
  return raster;
}

std::vector<int> rasterise_triangles(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                                     const Intrinsics& intrinsics, const Pose& cam_from_mesh) {
  return rasterise(vertices, triangles, intrinsics, cam_from_mesh).triangle;
}

Image8 silhouette(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                  const Intrinsics& intrinsics, const Pose& cam_from_mesh) {
  const std::vector<int> seen = rasterise_triangles(vertices, triangles, intrinsics, cam_from_mesh);
  Image8 mask(intrinsics.width, intrinsics.height, 1);
  for (std::size_t pixel = 0; pixel < seen.size(); ++pixel) mask.data[pixel] = seen[pixel] >= 0 ? 255 : 0;
  return mask;
}

}  // namespace likeness
