// Claims about core/train/attribute_region.h: paint on a posed head's picture finds its vertices and comes
// back as a region of the resting face.
#include "core/train/attribute_region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

const HeadModel& head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

struct Seen {
  Camera camera;
  Pose world_from_head = Pose::Identity();
  std::vector<Vec3f> posed, rest;
};

// Turned a little, its jaw open.
Seen seen() {
  Seen s;
  const HeadShape shape = shape_head(head(), PersonShape{Eigen::VectorXf::Zero(head().identity_count()), {}});
  Articulation face = neutral_articulation(head());
  s.rest = pose_head(head(), shape, face);
  face.jaw.x() = 0.2f;
  s.posed = pose_head(head(), shape, face);
  s.camera.intrinsics = {200, 200, 300, 300, 100, 100};
  s.world_from_head.linear() = Vec3d(1, -1, -1).asDiagonal();
  s.world_from_head.translation() = Vec3d(0, 0, 0.6);
  s.world_from_head.rotate(rotation_about(Vec3d::UnitY(), 0.3));
  return s;
}

// Paints what lies within `radius` of a vertex on the resting face, where the posed one shows it.
Image paint_about(const Seen& s, const Vec3f& middle, float radius) {
  const Raster raster =
      rasterise(s.posed, head().triangles, s.camera.intrinsics, s.camera.cam_from_world * s.world_from_head);
  Image cover(200, 200, 1);
  for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
    if (raster.triangle[i] < 0) continue;
    const Triangle& t = head().triangles[std::size_t(raster.triangle[i])];
    Vec3f at = Vec3f::Zero();
    for (int k = 0; k < 3; ++k) at += raster.barycentric[i][k] * s.rest[std::size_t(t[k])];
    cover.data[i] = (at - middle).norm() < radius ? 1.f : 0.f;
  }
  return cover;
}

// The vertex in the middle of the left cheek.
Vec3f cheek_of(const Seen& s) {
  const auto l = landmark_positions(head(), s.rest);
  const Vec3f about = 0.4f * l[12] + 0.6f * l[54] + Vec3f(0, 0.02f, 0);
  const auto nearest =
      std::ranges::min_element(s.rest, {}, [&](const Vec3f& v) { return (v - about).squaredNorm(); });
  return *nearest;
}

TEST(AttributeRegion, PaintIsCarriedToTheVerticesItWasPaintedOver) {
  const Seen s = seen();
  const Vec3f cheek = cheek_of(s);
  const auto paint = carry_paint(head(), s.posed, s.camera, s.world_from_head, paint_about(s, cheek, 0.02f));
  int right = 0, wrong = 0, unseen = 0;
  for (std::size_t v = 0; v < paint.size(); ++v) {
    const float distance = (s.rest[v] - cheek).norm();
    if (paint[v] > 0.5f) ++(distance < 0.024f ? right : wrong);
    if (distance < 0.015f && head().parts[v] == HeadPart::face) unseen += paint[v] < 0.5f;
  }
  EXPECT_GT(right, 10);
  EXPECT_LE(wrong, right / 20);
  EXPECT_LE(unseen, right / 4);
  // The back of the head lies behind the same pixels.
  for (std::size_t v = 0; v < paint.size(); ++v)
    if (s.rest[v].z() < -0.05f) {
      ASSERT_EQ(paint[v], 0) << v;
    }
}

TEST(AttributeRegion, ItsLatticeIsWholeOnThePaintAndNothingAwayFromIt) {
  const Seen s = seen();
  const Vec3f chin = landmark_positions(head(), s.rest)[8];
  std::vector<float> paint(s.rest.size());
  for (std::size_t v = 0; v < paint.size(); ++v) paint[v] = (s.rest[v] - chin).norm() < 0.02f ? 1.f : 0.f;
  const RegionOptions options;
  const auto distance = distance_to_paint(s.rest, paint), weights = soft_weights(distance, options);
  const AttributeRegion region = make_region("chin", head(), s.rest, weights, options);
  EXPECT_EQ(region.name, "chin");
  double off = 0, within = 0;
  for (std::size_t v = 0; v < paint.size(); ++v) {
    const float w = region_weight(region, s.rest[v]);
    ASSERT_GE(w, 0);
    ASSERT_LE(w, 1);
    if (distance[v] > 2 * options.rim + 2 * region.cell) {
      ASSERT_EQ(w, 0) << v << " " << distance[v];
    }
    if (paint[v] == 1) off += double(std::abs(w - weights[v])), ++within;
  }
  EXPECT_LT(off / within, 0.12) << "of a lattice that is smooth over its cells";
  EXPECT_GT(region_weight(region, chin), 0.9f);
  EXPECT_GT(region_weight(region, chin + Vec3f(0, 0, 0.008f)), 0.8f) << "skin may rise";
  EXPECT_EQ(region_weight(region, chin + Vec3f(0, 0, options.far + 2 * region.cell)), 0);
  EXPECT_EQ(region_weight(region, Vec3f(0, 0, -9)), 0);
  EXPECT_EQ(region_weight(region, Vec3f::Constant(std::numeric_limits<float>::quiet_NaN())), 0);
}

TEST(AttributeRegion, ItsEdgeIsContinuous) {
  const Seen s = seen();
  const Vec3f chin = landmark_positions(head(), s.rest)[8];
  std::vector<float> paint(s.rest.size());
  for (std::size_t v = 0; v < paint.size(); ++v) paint[v] = (s.rest[v] - chin).norm() < 0.02f ? 1.f : 0.f;
  const AttributeRegion region =
      make_region("chin", head(), s.rest, soft_weights(distance_to_paint(s.rest, paint)));
  float before = 0;
  for (int i = 0; i <= 4000; ++i) {  // along a line through the lattice, in steps of 0.03 mm
    const Vec3f at = chin + Vec3f(0.06f - 0.00003f * float(i), 0.002f, 0.001f);
    const float w = region_weight(region, at);
    if (i > 0) {
      ASSERT_LT(std::abs(w - before), 0.03f) << i;
    }
    before = w;
  }
}

}  // namespace
}  // namespace likeness
