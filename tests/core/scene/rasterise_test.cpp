// Claims about the rasteriser: it sees what rays see, and its areas are those of geometry.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/scene/mesh_scene.h"
#include "tests/core/scene/sphere_mesh.h"

namespace likeness {
namespace {

Intrinsics camera(int width, int height, double focal) {
  return {width, height, focal, focal, width / 2.0, height / 2.0};
}

double area_of(const Image8& mask) { return double(std::count(mask.data.begin(), mask.data.end(), 255)); }

TEST(Silhouette, OfASphereHasTheAreaOfItsTangentCone) {
  const double radius = 0.1, distance = 0.6, focal = 900;
  const SphereMesh mesh = sphere_mesh(float(radius), {0, 0, float(distance)});
  const Image8 mask = silhouette(mesh.vertices, mesh.triangles, camera(512, 512, focal), Pose::Identity());
  const double cone = focal * radius / std::sqrt(distance * distance - radius * radius);
  EXPECT_NEAR(area_of(mask), std::numbers::pi * cone * cone, 2e-3 * std::numbers::pi * cone * cone);
}

TEST(Rasterise, HasNoHolesAndCountsEveryPixelOfASquareOnce) {
  // A square of 2 x 2 m cut into unequal triangles; its picture covers exactly 40 x 40 pixels.
  const std::vector<Vec3f> vertices = {{-1, -1, 5}, {1, -1, 5}, {1, 1, 5}, {-1, 1, 5}, {0.3f, -0.2f, 5}};
  const std::vector<Triangle> triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const Image8 mask = silhouette(vertices, triangles, camera(64, 64, 100), Pose::Identity());
  EXPECT_EQ(area_of(mask), 1600);
  for (int y = 12; y < 52; ++y)
    for (int x = 12; x < 52; ++x) ASSERT_EQ(*mask.at(x, y), 255) << x << ", " << y;
}

TEST(Rasterise, PixelCentresLieAtOneHalf) {
  // Left edge of the square at x = 10.4 px: the centre of pixel 10 (10.5) is inside; at 10.6 it is not.
  for (const auto& [edge, first] : {std::pair{10.4f, 10}, std::pair{10.6f, 11}}) {
    const std::vector<Vec3f> vertices = {{edge, 0, 1}, {30, 0, 1}, {30, 30, 1}, {edge, 30, 1}};
    const Intrinsics k{40, 40, 1, 1, 0, 0};
    const Image8 mask =
        silhouette(vertices, std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}, k, Pose::Identity());
    EXPECT_EQ(*mask.at(first - 1, 15), 0);
    EXPECT_EQ(*mask.at(first, 15), 255);
  }
}

// Every pixel of a posed, distorted or close-up view against the ray through its centre.
void expect_as_rays(const Intrinsics& k, const Pose& cam_from_mesh, double tolerated_share) {
  SphereMesh mesh = sphere_mesh(0.1f, {0, 0, 0}, 40);
  for (Vec3f& vertex : mesh.vertices) vertex = vertex.cwiseProduct(Vec3f(1, 1.5f, 0.8f));
  const int second = int(mesh.vertices.size());  // a second body in front, so that depth has to decide
  const SphereMesh small = sphere_mesh(0.05f, {0.05f, 0.05f, 0.12f}, 20);
  mesh.vertices.insert(mesh.vertices.end(), small.vertices.begin(), small.vertices.end());
  for (const Triangle& triangle : small.triangles)
    mesh.triangles.push_back((triangle.array() + second).matrix());
  const Raster raster = rasterise(mesh.vertices, mesh.triangles, k, cam_from_mesh);
  const MeshScene scene(mesh.vertices, mesh.triangles);
  const Pose mesh_from_cam = inverse(cam_from_mesh);
  const Vec3f origin = mesh_from_cam.translation().cast<float>();
  int different = 0, seen = 0;
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      // The inverse of the distortion by fixed-point iteration, independent of the camera library.
      const Vec2d distorted((x + 0.5 - k.cx) / k.fx, (y + 0.5 - k.cy) / k.fy);
      Vec2d plain = distorted;
      for (int i = 0; i < 30; ++i) {
        const Vec2d again = project<double>(k, Vec3d(plain.x(), plain.y(), 1));
        plain += distorted - Vec2d((again.x() - k.cx) / k.fx, (again.y() - k.cy) / k.fy);
      }
      const Vec3f direction = (mesh_from_cam.linear() * Vec3d(plain.x(), plain.y(), 1)).cast<float>();
      const std::optional<RayHit> hit = scene.intersect(origin, direction);
      const std::size_t pixel = std::size_t(y) * k.width + x;
      seen += hit.has_value();
      if (raster.triangle[pixel] != (hit ? hit->triangle : -1)) {
        ++different;
      } else if (hit) {
        ASSERT_NEAR(raster.depth[pixel], hit->distance, 1e-3 * hit->distance);
        const Vec3f weights(1 - hit->barycentric.sum(), hit->barycentric[0], hit->barycentric[1]);
        ASSERT_LT((raster.barycentric[pixel] - weights).norm(), 0.05f);
      }
    }
  EXPECT_GT(seen, k.width * k.height / 20);
  EXPECT_LE(different, tolerated_share * k.width * k.height);
}

TEST(Rasterise, SeesTheTriangleTheRayHits) {
  Pose cam_from_mesh = Pose::Identity();
  cam_from_mesh.translate(Vec3d(0.01, -0.02, 0.6)).rotate(rotation_about(Vec3d(1, 2, -1).normalized(), 2.5));
  expect_as_rays(camera(200, 150, 300), cam_from_mesh, 1e-3);
}

TEST(Rasterise, SeesItUnderDistortionToo) {
  Pose cam_from_mesh = Pose::Identity();
  cam_from_mesh.translate(Vec3d(0.02, 0.03, 0.45)).rotate(rotation_about(Vec3d(0, 1, 0.3).normalized(), 0.4));
  Intrinsics k = camera(200, 160, 220);
  k.k1 = -0.15, k.k2 = 0.03, k.p1 = 0.002, k.p2 = -0.003;
  expect_as_rays(k, cam_from_mesh, 0.02);  // edges stay straight between distorted vertices
}

TEST(Rasterise, ClipsWhatReachesBehindTheCamera) {
  // The camera stands inside the long body: every pixel sees it.
  const std::vector<Vec3f> floor = {{-50, 1, -50}, {50, 1, -50}, {50, 1, 50}, {-50, 1, 50}};
  const Intrinsics k = camera(100, 100, 50);
  const Raster raster = rasterise(floor, std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}, k, Pose::Identity());
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      const std::size_t pixel = std::size_t(y) * 100 + x;
      const double slope = (y + 0.5 - 50) / 50;  // the floor is met at z = 1 / slope, seen to z = 50
      if (slope > 0.0201) {
        ASSERT_GE(raster.triangle[pixel], 0) << x << ", " << y;
        ASSERT_NEAR(raster.depth[pixel], 1 / slope, 1e-4 / slope);
      } else if (slope < 0.0199) {
        ASSERT_EQ(raster.triangle[pixel], -1) << x << ", " << y;
      }
    }
}

TEST(Rasterise, NothingFoldsBackIntoViewUnderStrongDistortion) {
  Intrinsics k = camera(100, 100, 100);
  k.k1 = -0.3;  // turns back at radius 1.05
  const std::vector<Vec3f> aside = {{1.7f, -0.1f, 1}, {1.9f, -0.1f, 1}, {1.8f, 0.1f, 1}};
  const Image8 mask = silhouette(aside, std::vector<Triangle>{{0, 1, 2}}, k, Pose::Identity());
  EXPECT_EQ(area_of(mask), 0);
}

TEST(Rasterise, IsTheSameOnOneThreadAndOnAll) {
  const SphereMesh mesh = sphere_mesh(0.1f, {0, 0, 0.5f}, 60);
  const Intrinsics k = camera(300, 200, 400);
  const std::vector<int> all = rasterise_triangles(mesh.vertices, mesh.triangles, k, Pose::Identity());
  const ThreadLimit one(1);
  EXPECT_EQ(rasterise_triangles(mesh.vertices, mesh.triangles, k, Pose::Identity()), all);
}

TEST(Rasterise, EmptyInputsGiveAnEmptyPicture) {
  const Raster raster = rasterise({}, {}, camera(8, 4, 10), Pose::Identity());
  EXPECT_EQ(raster.triangle, std::vector<int>(32, -1));
  EXPECT_TRUE(rasterise({}, {}, Intrinsics{}, Pose::Identity()).triangle.empty());
}

}  // namespace
}  // namespace likeness
