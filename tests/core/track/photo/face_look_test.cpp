// Claims about how a face looks: what changes the description and what does not.
#include "core/track/photo/face_look.h"

#include <gtest/gtest.h>

#include <cmath>

namespace likeness {
namespace {

// A blotchy picture that depends on the seed, smooth enough to survive sampling.
Image8 blotches(int seed) {
  Image8 picture(200, 200, 1);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x)
      *picture.at(x, y) = static_cast<std::uint8_t>(110 + 35 * std::sin(0.11 * x + seed) +
                                                    35 * std::cos(0.13 * y + 0.05 * x + 2.0 * seed));
  return picture;
}

std::array<Vec2d, kLandmarkCount> upright_points(const Vec2d& shift = Vec2d::Zero()) {
  std::array<Vec2d, kLandmarkCount> points;
  for (int i = 0; i < kLandmarkCount; ++i) {
    const double y = i >= 48 ? 130 : i >= 36 ? 75 : 100;
    points[i] = Vec2d(100, y) + shift;
  }
  return points;
}

TEST(FaceLook, BrightnessAndContrastDoNotMatter) {
  const Image8 picture = blotches(1);
  Image8 dim = picture;
  for (std::uint8_t& v : dim.data) v = static_cast<std::uint8_t>(v / 2 + 40);
  EXPECT_GT(alike(face_look(picture, upright_points()), face_look(dim, upright_points())), 0.99);
}

TEST(FaceLook, OtherFacesAndPointsBesideTheFaceLookDifferent) {
  const FaceLook look = face_look(blotches(1), upright_points());
  EXPECT_NEAR(alike(look, look), 1, 1e-5);
  EXPECT_LT(alike(look, face_look(blotches(3), upright_points())), 0.8);
  EXPECT_LT(alike(look, face_look(blotches(1), upright_points({18, 0}))), 0.8);
}

TEST(FaceLook, WithoutAFaceThereIsNoLook) {
  std::array<Vec2d, kLandmarkCount> heap;
  heap.fill(Vec2d(50, 50));
  EXPECT_TRUE(face_look(blotches(1), heap).values.empty());
  EXPECT_TRUE(face_look(Image8(200, 200, 1, 90), upright_points()).values.empty());
  EXPECT_EQ(alike({}, face_look(blotches(1), upright_points())), 0);
}

TEST(FaceLook, TheCoveredFrameAgreesLeast) {
  std::vector<FaceLook> looks;
  std::vector<int> references;
  for (int i = 0; i < 80; ++i) {
    Image8 picture = blotches(1);
    if (i == 40)
      for (int y = 60; y < 150; ++y)
        for (int x = 60; x < 105; ++x) *picture.at(x, y) = 230;
    looks.push_back(face_look(picture, upright_points()));
    if (i % 4 == 0) references.push_back(i);
  }
  const auto agreement = agreement_of_looks(looks, references);
  EXPECT_LT(agreement[40], 0.6);
  for (int i = 0; i < 80; ++i)
    if (i != 40) {
      EXPECT_GT(agreement[i], 0.95) << i;
    }
}

}  // namespace
}  // namespace likeness
