#include "core/base/align_points.h"

#include <gtest/gtest.h>

#include "core/base/rigid.h"

namespace likeness {
namespace {

TEST(AlignPoints, SimilarityIsFoundAgain) {
  const Mat3d turn = rotation_about(Vec3d(1, -2, 0.5).normalized(), 0.7);
  const Vec3d shift(0.3, -4, 2);
  Eigen::Matrix3Xd from(3, 5), to(3, 5);
  from << 0, 1, 0, 2, -1, 0, 0, 1, 3, 0.5, 1, 0, 0, -1, 2;
  to = (1.7 * turn * from).colwise() + shift;
  const Eigen::Matrix4d similarity = similarity_between(from, to);
  EXPECT_TRUE((similarity.topLeftCorner<3, 3>().isApprox(1.7 * turn, 1e-10)));
  EXPECT_TRUE((similarity.topRightCorner<3, 1>().isApprox(shift, 1e-10)));
}

TEST(AlignPoints, RotationTurnsOneDirectionIntoAnother) {
  const Vec3d from(0.2, -3, 1), to(5, 0.1, -2);
  const Mat3d turn = rotation_between(from, to);
  EXPECT_TRUE((turn * from.normalized()).isApprox(to.normalized(), 1e-12));
  EXPECT_NEAR(turn.determinant(), 1, 1e-12);
  EXPECT_TRUE((rotation_between(from, -from) * from).isApprox(-from, 1e-6));
}

TEST(AlignPoints, PrincipalAxisBelongsToTheLargestEigenvalue) {
  const Eigen::Vector4d axis = Eigen::Vector4d(1, -2, 3, 0.5).normalized();
  const Eigen::Matrix4d a = 5 * axis * axis.transpose() + Eigen::Matrix4d::Identity();
  EXPECT_NEAR(std::abs(principal_axis(a).dot(axis)), 1, 1e-12);
}

}  // namespace
}  // namespace likeness
