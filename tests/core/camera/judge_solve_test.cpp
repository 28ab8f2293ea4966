// Claims about which solves of structure from motion may be used.
#include "core/camera/judge_solve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/base/rigid.h"
#include "core/camera/assumed_lens.h"
#include "tests/core/camera/textured_room.h"

namespace likeness {
namespace {

// Cameras on an arc about a cloud of points, which they see exactly.
ColmapModel arc_model(Intrinsics lens, double arc_deg, double noise_px = 0) {
  ColmapModel model;
  model.cameras[1] = lens;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::normal_distribution<double> noise(0, 1);
  for (int i = 0; i < 60; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    model.points[i].position = {x, y, z};
  }
  const double distance = 2.5 * lens.fx / lens.width;
  for (int i = 0; i < 10; ++i) {
    const double angle = arc_deg / 57.3 * (i / 9.0 - 0.5);
    ColmapImage image;
    image.name = std::to_string(100 + i);
    image.camera = 1;
    image.cam_from_world = look_at({distance * std::sin(angle), 0, -distance * std::cos(angle)}, {0, 0, 0});
    for (auto& [id, point] : model.points) {
      Vec2d pixel = project<double>(lens, Vec3d(image.cam_from_world * point.position));
      const double dx = noise(random), dy = noise(random);
      pixel += noise_px * Vec2d(dx, dy);
      image.observations.push_back({pixel, id});
      ++point.views;
    }
    model.images.push_back(image);
  }
  return model;
}

Intrinsics upright_lens() { return assumed_intrinsics(540, 960, 0); }

TEST(JudgeSolve, AGoodSolveIsUsed) {
  const SolveJudgement judged = judge_solve(arc_model(upright_lens(), 40, 0.5), 11, 0);
  EXPECT_TRUE(judged.usable()) << testing::PrintToString(judged.reasons);
  EXPECT_NEAR(judged.placed, 10 / 11.0, 1e-9);
  EXPECT_GT(judged.parallax_deg, 15);
  EXPECT_NEAR(judged.view_deg, 65, 2);
}

TEST(JudgeSolve, ALensThatNobodyFilmsWithIsNot) {
  Intrinsics lens = assumed_intrinsics(480, 480, 0);
  lens.fx = lens.fy = 2130;
  const SolveJudgement judged = judge_solve(arc_model(lens, 40), 10, 0);
  ASSERT_EQ(judged.reasons.size(), 1u);
  EXPECT_THAT(judged.reasons[0], testing::HasSubstr("2130 px"));
  lens.fx = lens.fy = 100;
  EXPECT_FALSE(judge_solve(arc_model(lens, 40), 10, 0).usable());
}

TEST(JudgeSolve, TheFilesOwnLensCounts) {
  const Intrinsics lens = film_intrinsics(960, 540, 26);
  EXPECT_TRUE(judge_solve(arc_model(lens, 40), 10, 28).usable());
  const SolveJudgement judged = judge_solve(arc_model(lens, 40), 10, 52);
  ASSERT_EQ(judged.reasons.size(), 1u);
  EXPECT_THAT(judged.reasons[0], testing::HasSubstr("names for its lens"));
  // A square was cut out of something larger: its tag says nothing.
  EXPECT_TRUE(judge_solve(arc_model(assumed_intrinsics(540, 540, 0), 40), 10, 14).usable());
}

TEST(JudgeSolve, ACameraThatHardlyTravelledIsNot) {
  const SolveJudgement judged = judge_solve(arc_model(upright_lens(), 1.5), 10, 0);
  ASSERT_EQ(judged.reasons.size(), 1u);
  EXPECT_THAT(judged.reasons[0], testing::HasSubstr("hardly travelled"));
}

TEST(JudgeSolve, NorOneThatMissesItsPicturesOrLeavesThemOut) {
  const SolveJudgement noisy = judge_solve(arc_model(upright_lens(), 40, 3), 10, 0);
  ASSERT_EQ(noisy.reasons.size(), 1u);
  EXPECT_THAT(noisy.reasons[0], testing::HasSubstr("miss the pictures"));
  const SolveJudgement sparse = judge_solve(arc_model(upright_lens(), 40), 30, 0);
  ASSERT_EQ(sparse.reasons.size(), 1u);
  EXPECT_THAT(sparse.reasons[0], testing::HasSubstr("10 of 30"));
  EXPECT_FALSE(judge_solve({}, 30, 0).usable());
}

TEST(JudgeSolve, DistortionMayNotFold) {
  Intrinsics lens = upright_lens();
  EXPECT_EQ(least_squeeze(lens), 1);
  lens.k1 = -0.1;
  const double mild = least_squeeze(lens);
  EXPECT_GT(mild, 0.7);
  EXPECT_LT(mild, 1);
  EXPECT_TRUE(judge_solve(arc_model(lens, 40), 10, 0).usable());
  lens.k1 = -0.9;  // the radius never reaches the corner: it turns back at 0.6
  EXPECT_LE(least_squeeze(lens), 0);
  const SolveJudgement judged = judge_solve(arc_model(lens, 40), 10, 0);
  ASSERT_FALSE(judged.usable());
  EXPECT_THAT(judged.reasons[0], testing::HasSubstr("folds"));
  lens.k1 = 0.5;  // a pincushion stretches, and never folds
  EXPECT_EQ(least_squeeze(lens), 1);
}

}  // namespace
}  // namespace likeness
