// The line in the middle of a lock of hair, and the surfaces on which such lines grow and lie.
#pragma once

#include <array>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"
#include "core/scene/mesh_scene.h"

namespace likeness {

// Of the rest head: vertices, and the triangles of the parts face and scalp_neck only.
struct Scalp {
  const std::vector<Vec3f>& vertices;
  const std::vector<Triangle>& triangles;
  const std::array<Vec3f, kLandmarkCount>& landmarks;
};
struct Cloth {  // in the rest head frame
  const std::vector<Vec3f>& vertices;
  const std::vector<Triangle>& triangles;
};

struct HairGuide {
  explicit HairGuide(int count)
      : points(std::size_t(count)), normals(points), lift(points.size(), 0.0f), open(points.size()) {}
  std::vector<Vec3f> points, normals;  // m, rest head frame; outward
  std::vector<float> lift;             // m, how far the guide lies above the skin there
  std::vector<Eigen::Vector4f> open;   // HairMesh::open
  std::vector<float> follow;           // HairMesh::follow, or empty
  Vec3f root = Vec3f::Zero();
  int anchor = -1;
  int count() const { return int(points.size()); }
};

struct HeadProportions {
  float brow_y, unit;  // unit: 1 for a head as wide as usual at the temples
  float chin_y;
};

// The surface on which the guides grow.
struct Skull {
  const MeshScene& scene;
  const std::vector<Vec3f>& normals;  // of its vertices

  // The nearest point of the skin and its normal; false if there is none within 5 cm.
  bool settle(const Vec3f& wanted, Vec3f& at, Vec3f& n) const {
    const auto next = scene.closest(wanted, 0.05f);
    if (!next) return false;
    const Triangle& t = scene.triangles()[std::size_t(next->triangle)];
    at = next->position;
    n = (normals[std::size_t(t[0])] * next->barycentric[0] +
         normals[std::size_t(t[1])] * next->barycentric[1] +
         normals[std::size_t(t[2])] * next->barycentric[2])
            .normalized();
    return true;
  }
};

}  // namespace likeness
