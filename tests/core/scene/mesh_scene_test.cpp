// Claims about ray and closest-point queries: a sphere's are known in closed form, a box of noise is searched
// by hand.
#include "core/scene/mesh_scene.h"

#include <gtest/gtest.h>

#include <random>

#include "core/base/parallel.h"
#include "tests/core/scene/sphere_mesh.h"

namespace likeness {
namespace {

constexpr float kRadius = 0.1f;
const Vec3f kCentre(0.02f, -0.03f, 0.5f);

MeshScene sphere_scene() {
  SphereMesh mesh = sphere_mesh(kRadius, kCentre);
  return MeshScene(std::move(mesh.vertices), std::move(mesh.triangles));
}

std::vector<Vec3f> random_points(int count, float spread, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0, spread);
  std::vector<Vec3f> points(count);
  for (Vec3f& point : points) point = {normal(random), normal(random), normal(random)};
  return points;
}

TEST(MeshScene, RaysMeetTheSphereWhereTheQuadraticSays) {
  const MeshScene scene = sphere_scene();
  int hits = 0;
  for (const Vec3f& offset : random_points(2000, 0.1f, 1)) {
    const Vec3f origin(0.01f, 0.02f, -0.3f),
        direction = 1.7f * (kCentre + offset - origin);  // not of unit length
    const Vec3f toward = origin - kCentre;
    const float a = direction.squaredNorm(), b = direction.dot(toward);
    const float c = toward.squaredNorm() - kRadius * kRadius, discriminant = b * b - a * c;
    if (std::abs(discriminant) < 0.02f * a * kRadius * kRadius) continue;  // grazing: the facets decide
    const std::optional<RayHit> hit = scene.intersect(origin, direction);
    ASSERT_EQ(hit.has_value(), discriminant > 0);
    ASSERT_EQ(scene.occluded(origin, direction, 0, 1e30f), discriminant > 0);
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->distance, (-b - std::sqrt(discriminant)) / a, 2e-3f * kRadius);
    const Triangle& triangle = scene.triangles()[hit->triangle];
    const Vec2f& uv = hit->barycentric;
    const Vec3f by_weights = (1 - uv[0] - uv[1]) * scene.vertices()[triangle[0]] +
                             uv[0] * scene.vertices()[triangle[1]] + uv[1] * scene.vertices()[triangle[2]];
    EXPECT_LT((by_weights - (origin + hit->distance * direction)).norm(), 1e-5f);
  }
  EXPECT_GT(hits, 500);
}

TEST(MeshScene, NearAndFarBoundTheRay) {
  const MeshScene scene = sphere_scene();
  const Vec3f origin = kCentre - Vec3f(0, 0, 1), forward(0, 0, 1);
  EXPECT_FALSE(scene.intersect(origin, forward, 0, 0.89f));
  EXPECT_FALSE(scene.occluded(origin, forward, 0, 0.89f));
  const std::optional<RayHit> back =
      scene.intersect(origin, forward, 0.95f, 2);  // past the front: the far side
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->distance, 1 + kRadius, 1e-4f);
  EXPECT_FALSE(scene.intersect(origin, forward, 1.2f));
}

TEST(MeshScene, NoRaySlipsThroughAnEdge) {
  const MeshScene scene = sphere_scene();
  for (std::size_t t = 0; t < scene.triangles().size(); t += 3)
    for (const float share : {0.1f, 0.5f, 0.83f}) {
      const Triangle& triangle = scene.triangles()[t];
      const Vec3f point = share * scene.vertices()[triangle[0]] + (1 - share) * scene.vertices()[triangle[1]];
      ASSERT_TRUE(scene.intersect(kCentre, point - kCentre)) << "triangle " << t;
    }
}

TEST(MeshScene, ClosestPointOnASphereLiesOnTheLineToItsCentre) {
  const MeshScene scene = sphere_scene();
  for (const Vec3f& offset : random_points(500, 0.1f, 2)) {
    const float from_centre = offset.norm();
    if (from_centre < 0.02f) continue;
    const std::optional<ClosestPoint> closest = scene.closest(kCentre + offset);
    ASSERT_TRUE(closest);
    EXPECT_NEAR(closest->distance, std::abs(from_centre - kRadius), 2e-4f * kRadius);
    EXPECT_LT((closest->position - (kCentre + offset * (kRadius / from_centre))).norm(), 0.02f * kRadius);
    EXPECT_NEAR(closest->barycentric.sum(), 1, 1e-5f);
    EXPECT_GE(closest->barycentric.minCoeff(), 0);
  }
}

TEST(MeshScene, ClosestRespectsItsRadius) {
  const MeshScene scene = sphere_scene();
  const Vec3f outside = kCentre + Vec3f(0, 0, kRadius + 0.05f);
  EXPECT_FALSE(scene.closest(outside, 0.0499f));
  EXPECT_TRUE(scene.closest(outside, 0.0501f));
}

TEST(MeshScene, ClosestPointIsTheBestOfDenseSamplesOnEveryTriangle) {
  // Triangles of all shapes, slivers and points among them.
  std::vector<Vec3f> vertices = random_points(60, 0.1f, 3);
  vertices[4] = vertices[3];
  vertices[8] = (vertices[6] + vertices[7]) / 2;
  std::vector<Triangle> triangles;
  for (int t = 0; t < 20; ++t) triangles.emplace_back(3 * t, 3 * t + 1, 3 * t + 2);
  const MeshScene scene(vertices, triangles);
  for (const Vec3f& point : random_points(100, 0.15f, 4)) {
    float best = 1e30f;
    constexpr int kSteps = 60;
    for (const Triangle& triangle : triangles)
      for (int i = 0; i <= kSteps; ++i)
        for (int j = 0; i + j <= kSteps; ++j)
          best = std::min(best, ((vertices[triangle[0]] * float(kSteps - i - j) +
                                  vertices[triangle[1]] * float(i) + vertices[triangle[2]] * float(j)) /
                                     kSteps -
                                 point)
                                    .norm());
    const std::optional<ClosestPoint> closest = scene.closest(point);
    ASSERT_TRUE(closest);
    EXPECT_LE(closest->distance, best + 1e-6f);
    EXPECT_GE(closest->distance, best - 0.008f);  // samples are up to 8 mm apart
    EXPECT_NEAR((closest->position - point).norm(), closest->distance, 1e-6f);
    const Triangle& on = triangles[closest->triangle];
    Vec3f by_weights = Vec3f::Zero();
    for (int k = 0; k < 3; ++k) by_weights += closest->barycentric[k] * vertices[on[k]];
    EXPECT_LT((by_weights - closest->position).norm(), 1e-6f);
  }
}

TEST(MeshScene, MovedVerticesMatchAFreshScene) {
  const SphereMesh start = sphere_mesh(kRadius, kCentre, 80),
                   elsewhere = sphere_mesh(0.17f, {0.4f, 0.1f, -0.2f}, 80);
  const MeshScene fresh(elsewhere.vertices, elsewhere.triangles);
  for (const MeshUse use : {MeshUse::many_queries, MeshUse::many_moves}) {
    MeshScene moved(start.vertices, start.triangles, use);
    moved.move_vertices(elsewhere.vertices);
    for (const Vec3f& point : random_points(300, 0.3f, 5)) {
      const auto a = moved.closest(point), b = fresh.closest(point);
      ASSERT_TRUE(a && b);
      EXPECT_NEAR(a->distance, b->distance, 1e-6f);
      const auto hit_a = moved.intersect(Vec3f::Zero(), point), hit_b = fresh.intersect(Vec3f::Zero(), point);
      ASSERT_EQ(hit_a.has_value(), hit_b.has_value());
      if (!hit_a) continue;
      EXPECT_NEAR(hit_a->distance * point.norm(), hit_b->distance * point.norm(), 1e-5f);
    }
  }
}

TEST(MeshScene, ParallelQueriesEqualSerialOnes) {
  const MeshScene scene = sphere_scene();
  const std::vector<Vec3f> points = random_points(4000, 0.2f, 6);
  std::vector<int> parallel(points.size()), serial(points.size());
  parallel_for(points.size(), [&](std::size_t i) { parallel[i] = scene.closest(points[i])->triangle; });
  for (std::size_t i = 0; i < points.size(); ++i) serial[i] = scene.closest(points[i])->triangle;
  EXPECT_EQ(parallel, serial);
}

TEST(MeshScene, AnEmptyMeshIsNeverHit) {
  MeshScene scene({}, {});
  EXPECT_FALSE(scene.intersect(Vec3f::Zero(), Vec3f::UnitZ()));
  EXPECT_FALSE(scene.occluded(Vec3f::Zero(), Vec3f::UnitZ(), 0, 1));
  EXPECT_FALSE(scene.closest(Vec3f::Zero()));
  scene.move_vertices({});
}

}  // namespace
}  // namespace likeness
