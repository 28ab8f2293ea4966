#include "core/track/photo/gaze.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/scene/mesh_scene.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

constexpr int kEyeSize = 384;

Intrinsics eye_lens() {
  return {kEyeSize, kEyeSize, 1.6 * kEyeSize, 1.6 * kEyeSize, kEyeSize / 2.0, kEyeSize / 2.0};
}

struct EyePicture {
  Image8 grey;
  std::array<Vec2d, kLandmarkCount> landmarks;
};

// Skin grey, white bright, iris dark with a darker pupil; the demo eye's proportions.
EyePicture film_eyes(const Gaze& gaze, const Pose& cam_from_head, double noise, std::uint32_t seed,
                     float blink = 0) {
  const HeadModel& model = test_head();
  const HeadShape shape = shape_head(model, Eigen::VectorXf());
  Articulation face = neutral_articulation(model);
  face.left_eye = face.right_eye = eye_rotation(gaze);
  if (blink > 0)
    for (const char* name : {"eyeBlink_L", "eyeBlink_R"}) add_action(face, *find_action(model, name), blink);
  const std::vector<Vec3f> posed = pose_head(model, shape, face);
  const Raster raster = rasterise(posed, model.triangles, eye_lens(), cam_from_head);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  EyePicture out{Image8(kEyeSize, kEyeSize, 1), {}};
  for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
    double level = 90;
    if (raster.triangle[i] >= 0) {
      const Triangle& t = model.triangles[raster.triangle[i]];
      const HeadPart part = model.parts[t[0]];
      level = 150;
      if (part == HeadPart::left_eyeball || part == HeadPart::right_eyeball) {
        Vec3f rest = Vec3f::Zero();
        for (int k = 0; k < 3; ++k) rest += raster.barycentric[i][k] * shape.vertices[t[k]];
        const Vec3f d =
            (rest - shape.joints[part == HeadPart::left_eyeball ? kLeftEye : kRightEye]).normalized();
        const float share = std::acos(std::min(1.0f, d.z())) / std::asin(0.49f);
        level = share < 0.4f ? 25 : share < 1 ? 65 : 200;
      }
    }
    out.grey.data[i] = static_cast<std::uint8_t>(std::clamp(level + noise * normal(random), 0.0, 255.0));
  }
  const auto points = landmark_positions(model, posed);
  for (int k = 0; k < kLandmarkCount; ++k)
    out.landmarks[k] =
        project<double>(eye_lens(), Vec3d(cam_from_head * points[k].cast<double>())) +
        0.15 * noise * Vec2d(noise * normal(random), noise * normal(random)) / std::max(1.0, noise);
  return out;
}

Pose at_distance(double distance, double yaw) { return facing_pose(yaw, 0, Vec3d(0, 0, distance)); }

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double ma = 0, mb = 0, ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) ma += a[i] / a.size(), mb += b[i] / b.size();
  for (std::size_t i = 0; i < a.size(); ++i)
    ab += (a[i] - ma) * (b[i] - mb), aa += (a[i] - ma) * (a[i] - ma), bb += (b[i] - mb) * (b[i] - mb);
  return ab / std::sqrt(aa * bb);
}

TEST(Gaze, FollowsTheIrisThroughNoiseAndHeadTurns) {
  const EyeBalls eyes = eye_balls(test_head(), test_shape());
  std::vector<double> yaw, pitch, found_yaw, found_pitch;
  for (int i = 0; i < 40; ++i) {
    const Gaze truth{0.45 * std::sin(i * 0.9), 0.22 * std::sin(i * 1.7 + 1), 0};
    const Pose pose = at_distance(0.5, 0.4 * std::sin(i * 0.37));
    const EyePicture picture = film_eyes(truth, pose, 5, 100 + i);
    const auto found = measure_gaze(picture.grey, eye_lens(), pose, eyes, picture.landmarks);
    if (!found) continue;
    yaw.push_back(truth.yaw), pitch.push_back(truth.pitch);
    found_yaw.push_back(found->yaw), found_pitch.push_back(found->pitch);
  }
  ASSERT_GE(yaw.size(), 38u);
  std::printf("correlation: yaw %.3f, pitch %.3f\n", correlation(yaw, found_yaw),
              correlation(pitch, found_pitch));
  EXPECT_GT(correlation(yaw, found_yaw), 0.97);
  EXPECT_GT(correlation(pitch, found_pitch), 0.85);
}

TEST(Gaze, IsFinerThanAPixelAtCloseRange) {
  const EyeBalls eyes = eye_balls(test_head(), test_shape());
  const Pose pose = at_distance(0.45, 0);
  for (double yaw : {-0.2, 0.0, 0.15}) {
    const EyePicture picture = film_eyes({yaw, 0, 0}, pose, 0, 1);
    const auto found = measure_gaze(picture.grey, eye_lens(), pose, eyes, picture.landmarks);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->yaw, yaw, 0.06) << "a pixel is about 0.06 rad here";
  }
}

TEST(Gaze, GivesNoReadingForClosedEyes) {
  const EyeBalls eyes = eye_balls(test_head(), test_shape());
  const Pose pose = at_distance(0.5, 0);
  const EyePicture picture = film_eyes({0.2, 0, 0}, pose, 3, 2, 1);
  EXPECT_FALSE(measure_gaze(picture.grey, eye_lens(), pose, eyes, picture.landmarks));
}

TEST(Gaze, UsesTheOtherEyeWhenOneIsCovered) {
  const EyeBalls eyes = eye_balls(test_head(), test_shape());
  const Pose pose = at_distance(0.5, 0);
  EyePicture picture = film_eyes({0.2, 0, 0}, pose, 2, 3);
  for (int y = 0; y < kEyeSize; ++y)  // a hand over the subject's left eye
    for (int x = static_cast<int>(picture.landmarks[42].x()) - 3; x < kEyeSize; ++x)
      *picture.grey.at(x, y) = 140;
  const auto found = measure_gaze(picture.grey, eye_lens(), pose, eyes, picture.landmarks);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->eye[1].confidence, 0);
  EXPECT_GT(found->eye[0].confidence, 0);
  EXPECT_NEAR(found->yaw, 0.2, 0.1);
}

}  // namespace
}  // namespace likeness
