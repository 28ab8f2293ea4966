// Claims about the neck that bends between head and torso.
#include "core/scene/neck_bend.h"

#include <gtest/gtest.h>

#include <random>

#include "core/base/rigid.h"

namespace likeness {
namespace {

NeckZone zone() { return {-0.16f, -0.11f, {0, -0.135f, -0.02f}}; }

Pose turned(double yaw, double pitch, double roll, const Vec3d& shift) {
  // About the neck's middle, as heads turn.
  const Vec3d middle = zone().middle.cast<double>();
  Pose pose = Pose::Identity();
  pose.linear() = (Eigen::AngleAxisd(yaw, Vec3d::UnitY()) * Eigen::AngleAxisd(pitch, Vec3d::UnitX()) *
                   Eigen::AngleAxisd(roll, Vec3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation() = middle + shift - pose.linear() * middle;
  return pose;
}

// The bend as neck_bend.h defines it, in doubles.
Vec3d bent_by_definition(const Pose& head_from_torso, const Vec3d& p) {
  const NeckZone z = zone();
  const double u = std::clamp((double(z.top) - p.y()) / double(z.top - z.base), 0.0, 1.0);
  const double s = u * u * (3 - 2 * u);
  const Vec3d middle = z.middle.cast<double>(), moved = head_from_torso * middle - middle;
  const Eigen::AngleAxisd whole = axis_and_angle(head_from_torso.linear());
  return rotation_about(whole.axis(), s * whole.angle()) * (p - middle) + middle + s * moved;
}

std::vector<Pose> poses() {
  return {turned(0.5, 0, 0, {0, 0, 0}), turned(0, 0.4, 0, {0, 0.005, 0.01}), turned(0, 0, 0.3, {0.01, 0, 0}),
          turned(-0.4, -0.25, 0.15, {-0.02, 0.01, 0}), turned(0, 0, 0, {0.04, 0, 0})};
}

TEST(NeckBend, StraightensWhatWasBent) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> x(-0.06, 0.06), y(-0.19, -0.09);
  for (const Pose& pose : poses()) {
    const NeckBend bend = make_neck_bend(zone(), pose);
    for (int i = 0; i < 500; ++i) {
      const Vec3d p(x(random), y(random), x(random) - 0.02), q = bent_by_definition(pose, p);
      if (q.y() >= zone().top) continue;  // what has risen above the top counts as the head
      // A point may be reached twice where the neck is folded; one that is bent back onto q will do.
      const Vec3d back = straightened(bend, q.cast<float>()).cast<double>();
      EXPECT_LT((bent_by_definition(pose, back) - q).norm(), 3e-4) << p.transpose();
    }
  }
}

// The steps in lanes find the meeting that the walk from the head's end finds.
TEST(NeckBend, LanesMatchTheReference) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> x(-0.08f, 0.08f), y(-0.22f, -0.08f);
  for (const Pose& pose : poses()) {
    const NeckBend bend = make_neck_bend(zone(), pose);
    int apart = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3f q(x(random), y(random), x(random));
      // Where the neck is folded, rounding may choose another of two meetings that touch.
      apart += (straightened_in_lanes(bend, q) - straightened(bend, q)).norm() > 1e-5f;
    }
    EXPECT_LE(apart, 4);
  }
  const Vec3f p(0.02f, -0.15f, 0.01f);
  EXPECT_EQ(straightened_in_lanes(make_neck_bend(zone(), Pose::Identity()), p), p);
}

TEST(NeckBend, BendsAsDefined) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Pose& pose : poses()) {
    const NeckBend bend = make_neck_bend(zone(), pose);
    for (int i = 0; i < 200; ++i) {
      const Vec3d p(0.06 * uniform(random), -0.14 + 0.05 * uniform(random), 0.06 * uniform(random));
      EXPECT_LT((bent(bend, p.cast<float>()).cast<double>() - bent_by_definition(pose, p)).norm(), 1e-4);
    }
  }
}

TEST(NeckBend, AboveTheTopIsTheHeadAndBelowTheBaseTheTorso) {
  for (const Pose& pose : poses()) {
    const NeckBend bend = make_neck_bend(zone(), pose);
    const Vec3f high(0.03f, -0.10f, 0.02f);
    EXPECT_EQ(straightened(bend, high), high);
    const Vec3d collar(0.03, -0.175, 0.02);
    EXPECT_LT((straightened(bend, (pose * collar).cast<float>()).cast<double>() - collar).norm(), 1e-5);
  }
}

TEST(NeckBend, NeighboursStayNeighbours) {
  for (const Pose& pose : poses()) {
    const NeckBend bend = make_neck_bend(zone(), pose);
    for (float x = -0.05f; x < 0.05f; x += 0.02f)
      for (float y = -0.19f; y < -0.105f; y += 0.0005f) {
        const Vec3f a = straightened(bend, {x, y, 0}), b = straightened(bend, {x, y + 0.0005f, 0});
        EXPECT_LT((a - b).norm(), 0.004f) << x << " " << y;
      }
  }
}

TEST(NeckBend, AHeadThatRestsOnItsTorsoIsLeftAlone) {
  EXPECT_TRUE(make_neck_bend(zone(), Pose::Identity()).straight);
  EXPECT_TRUE(make_neck_bend({}, turned(0.5, 0, 0, {0, 0, 0})).straight);
  EXPECT_FALSE(make_neck_bend(zone(), turned(0.01, 0, 0, {0, 0, 0})).straight);
}

TEST(NeckBend, ACubesCoordinatesGiveTheSameBend) {
  const Vec3f origin(-0.2f, -0.25f, -0.2f);
  const float side = 0.4f;
  const NeckBend metres = make_neck_bend(zone(), poses()[3]),
                 unit = make_neck_bend(zone(), poses()[3], origin, side);
  const Vec3f q(0.02f, -0.14f, 0.01f);
  const Vec3f there = origin + side * straightened(unit, (q - origin) / side);
  EXPECT_LT((there - straightened(metres, q)).norm(), 1e-6f);
}

}  // namespace
}  // namespace likeness
