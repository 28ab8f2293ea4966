// Claims about the light that skin tells of: it is found in what faces the camera, brows and lips do not
// mislead it, and nothing behind is darker or lighter than skin may be.
#include "core/train/skin_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace likeness {
namespace {

// Lambertian, from the upper left before the face.
Vec3f lit(const Vec3f& normal) {
  const Vec3f from = Vec3f(-0.5f, 0.6f, 1.f).normalized();
  return (0.15f + 0.5f * std::max(0.f, normal.dot(from))) * Vec3f(1, 0.7f, 0.55f);
}

struct LitSkin {
  std::vector<Vec3f> normals, colours;
  std::vector<float> weights;
  explicit LitSkin(int count, float least_facing = 0.3f) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    while (int(normals.size()) < count) {
      const Vec3f n = Vec3f(normal(random), normal(random), normal(random)).normalized();
      if (n.z() < least_facing) continue;
      normals.push_back(n), colours.push_back(lit(n)), weights.push_back(1);
    }
  }
};

TEST(SkinLight, IsFoundAndShadesWhatIsTurnedFartherAway) {
  const LitSkin face(2000);
  const SkinLight light = fit_light(face.normals, face.colours, face.weights);
  double error = 0;
  for (std::size_t v = 0; v < face.normals.size(); ++v)
    error += (shade(light, face.normals[v]) - face.colours[v]).norm() / double(face.normals.size());
  EXPECT_LT(error, 0.02);
  const Vec3f left = Vec3f(-0.95f, 0, 0.25f).normalized(), right = Vec3f(0.95f, 0, 0.25f).normalized();
  EXPECT_LT((shade(light, left) - lit(left)).norm(), 0.08);
  EXPECT_LT(shade(light, right).mean(), 0.75f * shade(light, left).mean());
}

TEST(SkinLight, IsNotMisledByBrowsAndLips) {
  LitSkin face(2000);
  for (std::size_t v = 0; v < face.colours.size(); v += 8) face.colours[v] = Vec3f(0.03f, 0.02f, 0.02f);
  const SkinLight light = fit_light(face.normals, face.colours, face.weights);
  double error = 0, places = 0;
  for (std::size_t v = 1; v < face.colours.size(); v += 8)
    error += (shade(light, face.normals[v]) - face.colours[v]).norm(), ++places;
  EXPECT_LT(error / places, 0.03) << "a mean of both kinds is off by more than 0.06";
}

TEST(SkinLight, StaysWithinWhatSkinIsLikeEverywhere) {
  const LitSkin face(500, 0.6f);
  const SkinLight light = fit_light(face.normals, face.colours, face.weights);
  for (int i = 0; i < 64; ++i) {
    const float turn = 0.0981748f * float(i);
    for (const float up : {-0.9f, 0.f, 0.9f}) {
      const Vec3f n = Vec3f(std::sin(turn), up, std::cos(turn)).normalized();
      const Vec3f share = shade(light, n).cwiseQuotient(light.usual);
      EXPECT_GE(share.minCoeff(), 0.25f - 1e-4f);
      EXPECT_LE(share.maxCoeff(), 2 + 1e-4f);
    }
  }
}

TEST(SkinLight, IsTheSameFromEverywhereWhereLittleIsSeen) {
  const LitSkin face(20);
  const SkinLight light = fit_light(face.normals, face.colours, face.weights);
  EXPECT_EQ(shade(light, Vec3f::UnitX()), shade(light, Vec3f::UnitZ()));
}

}  // namespace
}  // namespace likeness
