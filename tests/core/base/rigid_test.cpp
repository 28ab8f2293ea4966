// Claims about inverses of poses, rotations about axes and rotation vectors.
#include "core/base/rigid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace likeness {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

class Rigid : public testing::Test {
 protected:
  double number() { return std::uniform_real_distribution<double>(-1, 1)(engine_); }
  Vec3d vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  Vec3d axis() { return vector().normalized(); }
  Pose pose() {
    Pose pose = Pose::Identity();
    pose.linear() = rotation_about(axis(), kHalfTurn * number());
    pose.translation() = 3 * vector();
    return pose;
  }

 private:
  std::mt19937 engine_{7};
};

TEST_F(Rigid, InverseIsEigensToTheBitAndUndoesThePose) {
  for (int i = 0; i < 200; ++i) {
    const Pose a = pose();
    const Vec3d point = vector();
    EXPECT_TRUE(inverse(a).matrix() == a.inverse().matrix());
    EXPECT_LT((inverse(a) * (a * point) - point).norm(), 1e-14);
  }
  EXPECT_TRUE(inverse(Pose::Identity()).matrix() == Pose::Identity().matrix());
}

TEST_F(Rigid, InverseOfAProductIsTheProductOfInversesInReverse) {
  for (int i = 0; i < 50; ++i) {
    const Pose a = pose(), b = pose();
    EXPECT_LT((inverse(a * b).matrix() - (inverse(b) * inverse(a)).matrix()).norm(), 1e-13);
  }
}

TEST_F(Rigid, RotationAboutIsEigensToTheBitAndKeepsItsAxis) {
  for (int i = 0; i < 200; ++i) {
    const Vec3d about = axis();
    const double angle = 4 * number();
    const Mat3d r = rotation_about(about, angle);
    EXPECT_TRUE(r == Eigen::AngleAxisd(angle, about).toRotationMatrix());
    EXPECT_LT((r * about - about).norm(), 1e-14);
    EXPECT_LT((r.transpose() * r - Mat3d::Identity()).norm(), 1e-14);
    EXPECT_LT((r * rotation_about(about, 0.3) - rotation_about(about, angle + 0.3)).norm(), 1e-14);
  }
}

TEST_F(Rigid, RotationAboutTurnsCounterClockwise) {
  EXPECT_LT((rotation_about(Vec3d::UnitZ(), kHalfTurn / 2) * Vec3d::UnitX() - Vec3d::UnitY()).norm(), 1e-15);
  EXPECT_LT((rotation_about(Vec3d::UnitX(), kHalfTurn / 2) * Vec3d::UnitY() - Vec3d::UnitZ()).norm(), 1e-15);
  EXPECT_LT((rotation_about(Vec3d::UnitY(), kHalfTurn / 2) * Vec3d::UnitZ() - Vec3d::UnitX()).norm(), 1e-15);
}

TEST_F(Rigid, AxisAndAngleRoundTripFromNearZeroToNearHalfATurn) {
  for (const double angle : {1e-9, 1e-4, 0.5, kHalfTurn / 2, 3.0, kHalfTurn - 1e-4, kHalfTurn - 1e-7})
    for (int i = 0; i < 20; ++i) {
      const Vec3d about = axis();
      const Eigen::AngleAxisd found = axis_and_angle(rotation_about(about, angle));
      EXPECT_NEAR(found.angle(), angle, 1e-14);
      EXPECT_LT((found.axis() - about).norm(), 1e-6) << angle;
      EXPECT_EQ(found.angle(), rotation_angle(rotation_about(about, angle)));
    }
}

TEST_F(Rigid, HalfATurnHasItsAxisUpToTheSign) {
  for (int i = 0; i < 20; ++i) {
    const Vec3d about = axis();
    const Mat3d r = rotation_about(about, kHalfTurn);
    const Eigen::AngleAxisd found = axis_and_angle(r);
    EXPECT_NEAR(found.angle(), kHalfTurn, 1e-14);
    EXPECT_NEAR(std::abs(found.axis().dot(about)), 1, 1e-14);
    EXPECT_LT((turn_from_vector(vector_from_turn(r)) - r).norm(), 1e-14);
  }
}

TEST_F(Rigid, NoTurnHasTheAngleZeroAndTheAxisX) {
  const Eigen::AngleAxisd none = axis_and_angle(Mat3d::Identity());
  EXPECT_EQ(none.angle(), 0);
  EXPECT_TRUE(none.axis() == Vec3d::UnitX());
  EXPECT_EQ(rotation_angle(Mat3d::Identity()), 0);
  EXPECT_TRUE(vector_from_turn(Mat3d::Identity()) == Vec3d::Zero());
  EXPECT_TRUE(turn_from_vector(Vec3d::Zero()) == Mat3d::Identity());
}

TEST_F(Rigid, AngleIsTheLesserOfTheTwoWaysRound) {
  for (int i = 0; i < 50; ++i) {
    const Vec3d about = axis();
    const double angle = kHalfTurn * std::abs(number());
    EXPECT_NEAR(rotation_angle(rotation_about(about, 2 * kHalfTurn - angle)), angle, 1e-13);
    EXPECT_NEAR(rotation_angle(rotation_about(about, -angle)), angle, 1e-13);
  }
}

TEST_F(Rigid, RotationVectorsRoundTrip) {
  // Below 1e-12 rad the rotation is linear in its vector.
  for (const double angle : {1e-14, 0.9e-12, 1.1e-12, 1e-8, 0.01, 1.0, 3.0, kHalfTurn - 1e-6})
    for (int i = 0; i < 20; ++i) {
      const Vec3d v = angle * axis();
      EXPECT_LT((vector_from_turn(turn_from_vector(v)) - v).norm(), 1e-3 * std::min(angle, 1e-8)) << angle;
    }
  const Vec3d about = axis();
  EXPECT_LT((vector_from_turn(turn_from_vector((2 * kHalfTurn - 0.4) * about)) + 0.4 * about).norm(), 1e-13);
}

TEST_F(Rigid, CrossMatrixIsTheSlopeOfTheRotation) {
  for (int i = 0; i < 50; ++i) {
    const Vec3d v = vector(), x = vector();
    EXPECT_LT((cross_matrix(v) * x - v.cross(x)).norm(), 1e-15);
    const Mat3d slope = (turn_from_vector(1e-5 * v) - turn_from_vector(-1e-5 * v)) / 2e-5;
    EXPECT_LT((slope - cross_matrix(v)).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace likeness
