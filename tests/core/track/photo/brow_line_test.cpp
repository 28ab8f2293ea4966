// Painted brows that rise or rest where the landmarks say otherwise.
#include "core/track/photo/brow_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

constexpr int kBrowSize = 400;

Intrinsics brow_camera() {
  Intrinsics k;
  k.width = k.height = kBrowSize;
  k.fx = k.fy = 1000;
  k.cx = k.cy = kBrowSize / 2.0;
  return k;
}

double distance_to_line(const Vec2d& p, const Vec2d& a, const Vec2d& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}

struct BrowClip {
  std::vector<Image8> greys;
  std::vector<BrowPicture> pictures;
  std::vector<FaceFrame> faces;
  std::vector<double> rises;  // m, true
  ReducedPerson person;
  Eigen::VectorXd neutral;

  Vec3d brow_point(int k, double rise) const {
    return reduced_point(test_reduced_head(), person, k, neutral, 0) + rise * Vec3d(0, 1, -0.25).normalized();
  }
};

// 40 frames of a slowly turning face; from 20 to 25 the brows are 12 mm up and the landmarks 6 mm down; from
// 30 to 35 both are 3 mm up; from 36 to 38 the brows rest and the landmarks are 5 mm up. ink: how dark the
// brows are, levels.
BrowClip make_brow_clip(double ink, bool fringe = false) {
  BrowClip clip;
  const ReducedHead& head = test_reduced_head();
  clip.person = reduced_person(head, Eigen::VectorXd::Zero(head.identity_count()));
  clip.neutral = Eigen::VectorXd::Zero(head.expression_count());
  const Intrinsics k = brow_camera();
  for (int i = 0; i < 40; ++i) {
    const bool lost = i >= 20 && i < 25;
    clip.rises.push_back(lost ? 0.012 : i >= 30 && i < 35 ? 0.003 : 0.0);
    FaceFrame face;
    face.frame = i;
    face.seen = face.pose_given = true;
    face.held_out = i >= 23;
    face.state.cam_from_head = facing_pose(0.01 * (i - 20), 0.02, Vec3d(0, 0.03, 0.6));
    face.state.expression = clip.neutral;
    face.observation = observe_state(head, clip.person, face.state, 0, 1);
    Image8 grey(kBrowSize, kBrowSize, 1);
    std::array<Vec2d, 10> drawn;
    for (int b = 0; b < 10; ++b) {
      const Vec3d seen = clip.brow_point(17 + b, lost                ? -0.006
                                                 : i >= 36 && i < 39 ? 0.005
                                                                     : clip.rises.back());
      face.observation.rays[17 + b] = (face.state.cam_from_head * seen).hnormalized();
      drawn[b] = project<double>(k, face.state.cam_from_head * clip.brow_point(17 + b, clip.rises.back()));
    }
    for (int y = 0; y < kBrowSize; ++y)
      for (int x = 0; x < kBrowSize; ++x) {
        double near = 1e9;
        for (int b = 0; b < 9; ++b)
          if (b != 4) near = std::min(near, distance_to_line({x + 0.5, y + 0.5}, drawn[b], drawn[b + 1]));
        double value = 170 + 0.05 * x - ink / (1 + std::exp(1.5 * (near - 4)));
        if (fringe) value = 60 + 25 * std::sin(0.9 * x + 0.02 * y * std::sin(0.05 * x));
        *grey.at(x, y) = static_cast<std::uint8_t>(value);
      }
    clip.greys.push_back(std::move(grey));
    clip.faces.push_back(std::move(face));
  }
  for (const Image8& grey : clip.greys) clip.pictures.push_back({&grey, k});
  return clip;
}

Result<BrowSummary> correct(BrowClip& clip) {
  return correct_brows(test_reduced_head(), clip.person, clip.pictures, clip.faces, {});
}

// Mean height of the observed brows above their true place, m.
double mean_offset(const BrowClip& clip, int frame) {
  const Pose& pose = clip.faces[frame].state.cam_from_head;
  double sum = 0;
  for (int b = 17; b < 27; ++b) {
    const Vec3d in_cam = pose * clip.brow_point(b, clip.rises[frame]);
    sum -= (clip.faces[frame].observation.rays[b] - in_cam.hnormalized()).y() * in_cam.z() / 10;
  }
  return sum;
}

TEST(BrowLine, BrowsLostHighUpAreFoundWhereTheyAre) {
  BrowClip clip = make_brow_clip(90);
  ASSERT_LT(mean_offset(clip, 22), -0.015);
  const auto summary = correct(clip);
  ASSERT_TRUE(summary);
  EXPECT_TRUE(summary->known);
  EXPECT_EQ(summary->corrected, 8 * 4);
  for (int i = 20; i < 25; ++i) EXPECT_NEAR(mean_offset(clip, i), 0, 0.0012) << i;
}

TEST(BrowLine, BrowsAtRestComeDownFromWhereThePredictorSeesThem) {
  BrowClip clip = make_brow_clip(90);
  ASSERT_GT(mean_offset(clip, 37), 0.004);
  ASSERT_TRUE(correct(clip));
  for (int i = 36; i < 39; ++i) EXPECT_NEAR(mean_offset(clip, i), 0, 0.0012) << i;
}

TEST(BrowLine, PointsThatAgreeWithThePictureStay) {
  BrowClip clip = make_brow_clip(90);
  const std::vector<FaceFrame> before = clip.faces;
  ASSERT_TRUE(correct(clip));
  for (int i : {3, 19, 28, 32, 39})
    for (int b = 17; b < 27; ++b)
      EXPECT_EQ(clip.faces[i].observation.rays[b], before[i].observation.rays[b]) << i << " " << b;
}

TEST(BrowLine, BrowsTooFaintOrUnderAFringeAreLeftToThePredictor) {
  for (BrowClip clip : {make_brow_clip(1), make_brow_clip(90, true)}) {
    for (std::size_t i = 0; i < clip.greys.size(); ++i) clip.pictures[i].grey = &clip.greys[i];
    const auto summary = correct(clip);
    ASSERT_TRUE(summary);
    EXPECT_EQ(summary->corrected, 0);
  }
}

TEST(BrowLine, HeldOutPicturesTeachNothing) {
  BrowClip clip = make_brow_clip(90), other = make_brow_clip(90);
  for (std::size_t i = 0; i < other.greys.size(); ++i) {
    if (other.faces[i].held_out) other.greys[i] = Image8(kBrowSize, kBrowSize, 1, std::uint8_t(77));
    other.pictures[i].grey = &other.greys[i];
    clip.pictures[i].grey = &clip.greys[i];
  }
  ASSERT_TRUE(correct(clip));
  ASSERT_TRUE(correct(other));
  for (int i = 0; i < 23; ++i)
    for (int b = 17; b < 27; ++b)
      EXPECT_EQ(clip.faces[i].observation.rays[b], other.faces[i].observation.rays[b]) << i;
}

}  // namespace
}  // namespace likeness
