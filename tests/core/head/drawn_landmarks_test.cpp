// Claims about landmarks moved to where a predictor draws them.
#include "core/head/drawn_landmarks.h"

#include <gtest/gtest.h>

#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

std::array<Vec3f, kLandmarkCount> places(const HeadModel& model) {
  return landmark_positions(model, model.vertices);
}

TEST(DrawnLandmarks, EveryLandmarkIsTheMirrorOfItsMirror) {
  for (int l = 0; l < kLandmarkCount; ++l) EXPECT_EQ(mirrored_landmark(mirrored_landmark(l)), l);
  const auto at = places(make_builtin_head());
  for (int l = 0; l < kLandmarkCount; ++l) {
    const Vec3f mirrored = at[std::size_t(mirrored_landmark(l))].cwiseProduct(Vec3f(-1, 1, 1));
    EXPECT_LT((at[std::size_t(l)] - mirrored).norm(), 0.002f) << l;
  }
}

TEST(DrawnLandmarks, MoveBothHalvesAsSeenFromTheFrontAndStayOnTheSurface) {
  HeadModel model = make_builtin_head();
  const auto before = places(model);
  const float eyes = (before[36] - before[45]).norm();
  draw_landmarks(model, std::to_array<DrawnLandmark>(
                            {{37, {0.02f, 0}}, {33, {0.5f, -0.012f}}, {48, {-0.012f, 0.004f}}}));
  const auto after = places(model);
  const auto moved = [&](int l) { return Vec3f((after[std::size_t(l)] - before[std::size_t(l)]) / eyes); };
  EXPECT_NEAR(moved(37).x(), 0.02, 0.004);
  EXPECT_NEAR(moved(44).x(), -0.02, 0.004);
  EXPECT_NEAR(moved(33).x(), 0, 0.001);  // one in the middle stays there
  EXPECT_NEAR(moved(33).y(), -0.012, 0.004);
  EXPECT_NEAR(moved(48).x(), -0.012, 0.004);
  EXPECT_NEAR(moved(54).x(), 0.012, 0.004);
  for (const int l : {0, 8, 30, 36, 66}) EXPECT_EQ(moved(l), Vec3f::Zero()) << l;
  for (int l = 0; l < kLandmarkCount; ++l) {
    const Vec3f& w = model.landmark_barycentric[std::size_t(l)];
    EXPECT_NEAR(w.sum(), 1, 1e-5);
    EXPECT_GE(w.minCoeff(), -1e-6f);
  }
}

// An open mouth shows which lip a landmark lies on.
TEST(DrawnLandmarks, LipLandmarksStayOnTheirLip) {
  HeadModel model = make_builtin_head();
  const HeadShape shape = shape_head(model, {Eigen::VectorXf::Zero(model.identity_count()), {}});
  Articulation open = neutral_articulation(model);
  add_action(open, *find_action(model, "jawOpen"), 0.7f);
  const auto gap = [&] {
    const auto at = landmark_positions(model, pose_head(model, shape, open));
    return at[62].y() - at[66].y();
  };
  const float before = gap();
  draw_landmarks(model, std::to_array<DrawnLandmark>({{62, {0, -0.01f}}, {66, {0, 0.01f}}}));
  EXPECT_GT(gap(), 0.8f * before);
}

}  // namespace
}  // namespace likeness
