// A triangle mesh with queries for ray hits, closest points and silhouettes, through Embree.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/linalg.h"
#include "core/camera/camera.h"
#include "core/image/image.h"

namespace likeness {

struct RayHit {
  float distance = 0;  // along the (not necessarily unit) direction
  int triangle = -1;
  Vec2f barycentric;  // weights of the triangle's vertices 1 and 2
};

struct ClosestPoint {
  Vec3f position;
  float distance = 0;  // m
  int triangle = -1;
  Vec3f barycentric;  // weights of the triangle's three vertices
};

// What to optimise for. Moving 9,000 vertices costs about 4 ms with many_queries (the tree is rebuilt) and
// 0.2 ms with many_moves (refitted); a closest-point query then costs 1.1 and 1.7 us. They break even near
// 8,000 queries a move.
enum class MeshUse { many_queries, many_moves };

class MeshScene {
 public:
  MeshScene(std::vector<Vec3f> vertices, std::vector<Triangle> triangles,
            MeshUse use = MeshUse::many_queries);
  ~MeshScene();
  MeshScene(MeshScene&&) noexcept;
  MeshScene& operator=(MeshScene&&) noexcept;

  std::optional<RayHit> intersect(const Vec3f& origin, const Vec3f& direction, float near = 0,
                                  float far = 1e30f) const;
  bool occluded(const Vec3f& origin, const Vec3f& direction, float near, float far) const;
  // Nearest surface point no further than `radius`; a smaller radius is quicker. Thread-safe, like the
  // queries above.
  std::optional<ClosestPoint> closest(const Vec3f& point, float radius = 1e30f) const;

  const std::vector<Vec3f>& vertices() const;
  const std::vector<Triangle>& triangles() const;
  // New positions, same triangles. Not while queries run.
  void move_vertices(std::span<const Vec3f> vertices);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The visible triangle at every pixel centre: a z-buffer of the mesh under cam_from_mesh, both sides of a
// triangle counting. Distortion is applied to the vertices (exact at them, straight between). Triangles
// reaching behind the camera are clipped; those beyond the angle where the distortion folds back are left
// out. Parallel; the result does not depend on the number of threads.
struct Raster {
  int width = 0, height = 0;
  std::vector<int> triangle;       // (height, width) -1 where none
  std::vector<float> depth;        // (height, width) z in the camera frame, mesh units; 0 where none
  std::vector<Vec3f> barycentric;  // (height, width) weights of the triangle's vertices, perspective-correct
};
Raster rasterise(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                 const Intrinsics& intrinsics, const Pose& cam_from_mesh);

// The triangles only. (height, width), -1 where none.
std::vector<int> rasterise_triangles(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                                     const Intrinsics& intrinsics, const Pose& cam_from_mesh);
// 255 where the mesh is seen. One channel.
Image8 silhouette(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                  const Intrinsics& intrinsics, const Pose& cam_from_mesh);

}  // namespace likeness
