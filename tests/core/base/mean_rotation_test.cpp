// Claims about the mean of rotations.
#include "core/base/mean_rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/rigid.h"

namespace likeness {
namespace {

Mat3d turned(double angle, const Vec3d& axis) { return rotation_about(axis.normalized(), angle); }

TEST(NearestRotation, RecoversAScaledRotationAndNeverReflects) {
  const Mat3d r = turned(0.7, {1, -2, 0.5});
  EXPECT_LT((nearest_rotation(3.5 * r) - r).norm(), 1e-12);
  const Mat3d mirror = Vec3d(1, 1, -0.5).asDiagonal();
  EXPECT_NEAR(nearest_rotation(mirror).determinant(), 1, 1e-12);
}

TEST(MeanRotation, LiesBetweenTurnsToEitherSide) {
  const Mat3d usual = turned(2.9, {0.3, 1, 0});  // near half a turn, where angles jump
  std::vector<Mat3d> rotations;
  for (const double a : {-0.4, -0.1, 0.1, 0.4}) rotations.push_back(turned(a, {0, 0, 1}) * usual);
  EXPECT_LT((mean_rotation(rotations) - usual).norm(), 1e-12);
  EXPECT_NEAR(turn_about_mean(rotations), std::sqrt((0.16 + 0.01) / 2), 1e-9);
}

TEST(MeanRotation, OfNoneIsTheIdentity) {
  EXPECT_EQ(mean_rotation({}), Mat3d::Identity());
  EXPECT_EQ(turn_about_mean({}), 0);
  const std::vector<Mat3d> one{turned(1, {0, 1, 0})};
  EXPECT_NEAR(turn_about_mean(one), 0, 1e-7);  // the arc cosine's own error
}

}  // namespace
}  // namespace likeness
