// Claims about the outline of a face and the edge found near it.
#include "core/track/fit/face_contour.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/scene/mesh_scene.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

constexpr Intrinsics kCamera{384, 384, 900, 900, 192, 192, 0, 0, 0, 0};

Image8 step_picture(double edge, int inside, int outside) {
  Image8 picture(64, 64, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const double covered = std::clamp(edge - x, 0.0, 1.0);
      *picture.at(x, y) = std::uint8_t(std::lround(covered * inside + (1 - covered) * outside));
    }
  return picture;
}

TEST(FaceContour, LiesOnTheSilhouette) {
  const HeadModel& model = test_head();
  const Pose pose = facing_pose(0.5, 0.1, Vec3d(0, 0, 0.75));
  const auto contour =
      face_contour(model, contour_triangles(model, model.vertices), model.vertices, kCamera, pose);
  const Image8 mask = silhouette(model.vertices, model.triangles, kCamera, pose);
  ASSERT_GT(contour.size(), 30u);
  int on_outer = 0;
  for (const ContourPoint& c : contour) {
    EXPECT_NEAR(c.outward.norm(), 1, 1e-9);
    EXPECT_NEAR(c.px_per_m, 900 / 0.7, 250);
    const Vec2d inside = c.pixel - 2.5 * c.outward, outside = c.pixel + 2.5 * c.outward;
    EXPECT_EQ(*mask.at(int(inside.x()), int(inside.y())), 255);
    on_outer += *mask.at(int(outside.x()), int(outside.y())) == 0;
  }
  EXPECT_GT(on_outer, int(contour.size()) / 2);  // the rest: the jaw before the neck, the nose before a cheek
}

TEST(FaceContour, TheEdgeIsFoundToAFractionOfAPixel) {
  for (const double edge : {29.3, 32.0, 35.6}) {
    const auto shift = find_edge(step_picture(edge, 180, 60), Vec2d(32, 20.5), Vec2d(1, 0), 8, 4);
    ASSERT_TRUE(shift.has_value());
    EXPECT_NEAR(*shift, edge - 32, 0.2);
  }
}

TEST(FaceContour, RejectsMissingAndAmbiguousEdges) {
  EXPECT_FALSE(find_edge(step_picture(32, 100, 103), Vec2d(32, 20.5), Vec2d(1, 0), 8, 4));
  Image8 two = step_picture(29, 180, 60);
  for (int y = 0; y < 64; ++y)
    for (int x = 35; x < 64; ++x) *two.at(x, y) = 180;
  EXPECT_FALSE(find_edge(two, Vec2d(32, 20.5), Vec2d(1, 0), 8, 4));
  EXPECT_FALSE(find_edge(step_picture(32, 180, 60), Vec2d(2, 20.5), Vec2d(1, 0), 8, 4))
      << "out of the picture";
}

}  // namespace
}  // namespace likeness
