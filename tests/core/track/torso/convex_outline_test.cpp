// Claims about convex outlines.
#include "core/track/torso/convex_outline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace likeness {
namespace {

TEST(ConvexOutline, HoldsItsPointsAndNothingBeyondAnyOfItsSides) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-100, 100);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Vec2d> points;
    for (int i = 0; i < 40; ++i) points.push_back({uniform(random), 0.5 * uniform(random)});
    const ConvexOutline outline = convex_outline(points);
    for (const Vec2d& p : points) EXPECT_TRUE(holds(outline, p, 1e-9));
    for (std::size_t i = 0; i < outline.corners.size(); ++i) {
      const Vec2d middle = 0.5 * (outline.corners[i] + outline.corners[(i + 1) % outline.corners.size()]);
      EXPECT_TRUE(holds(outline, middle - 0.01 * outline.normals[i], 0));
      EXPECT_FALSE(holds(outline, middle + 0.01 * outline.normals[i], 0));
      EXPECT_TRUE(holds(outline, middle + 5.9 * outline.normals[i], 6));
      EXPECT_FALSE(holds(outline, middle + 6.1 * outline.normals[i], 6));
      EXPECT_FALSE(holds(outline, middle - 5.9 * outline.normals[i], -6));
    }
  }
}

TEST(ConvexOutline, OfACircleIsTheCircle) {
  std::vector<Vec2d> points;
  for (int i = 0; i < 360; ++i) {
    const double angle = std::numbers::pi * i / 180;
    points.push_back(Vec2d(300, 200) + 50 * Vec2d(std::cos(angle), std::sin(angle)));
  }
  const ConvexOutline outline = convex_outline(points);
  EXPECT_EQ(outline.corners.size(), 360u);
  for (const double radius : {10.0, 49.0, 51.0, 500.0})
    EXPECT_EQ(holds(outline, Vec2d(300, 200 - radius), 0), radius < 50) << radius;
}

TEST(ConvexOutline, FewerThanThreePointsHoldNothing) {
  EXPECT_FALSE(holds(convex_outline({}), {0, 0}, 10));
  EXPECT_FALSE(holds(convex_outline({{1, 1}, {2, 2}}), {1.5, 1.5}, 10));
}

}  // namespace
}  // namespace likeness
