// Claims about the measures by which sources of landmarks are compared, on made points whose errors are
// known.
#include "core/lab/truth/landmark_sources.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace likeness {
namespace {

using Points = std::array<Vec2d, kLandmarkCount>;

Points face_at(const Vec2d& place) {
  Points points;
  for (int k = 0; k < kLandmarkCount; ++k)
    points[std::size_t(k)] = place + 20 * Vec2d(std::cos(1.7 * k), std::sin(1.7 * k));
  points[36] = place + Vec2d(-50, 0), points[45] = place + Vec2d(50, 0);  // 100 px apart
  return points;
}

// sigma: px of each coordinate; speed: px a frame.
FoundPoints walk(int frames, double sigma, double speed, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  FoundPoints found;
  for (int i = 0; i < frames; ++i) {
    Points points = face_at({200 + speed * i, 150});
    for (int k = 0; k < kLandmarkCount; ++k) {
      if (k == 36 || k == 45) continue;
      points[std::size_t(k)].x() += sigma * noise(random);
      points[std::size_t(k)].y() += sigma * noise(random);
    }
    found.emplace_back(points);
  }
  return found;
}

TEST(LandmarkSources, TrembleIsTheNoiseOfAHeadAtRest) {
  const FoundPoints calm = walk(200, 0.5, 0, 1), restless = walk(200, 2, 0, 2);
  const auto still = still_frames({calm, restless});
  EXPECT_GT(std::ranges::count(still, true), 150);
  const auto a = tremble(calm, still), b = tremble(restless, still);
  for (const FacePart part : {FacePart::brows, FacePart::nose, FacePart::lips}) {
    ASSERT_TRUE(a[std::size_t(part)] && b[std::size_t(part)]);
    EXPECT_NEAR(*a[std::size_t(part)], 0.005, 0.0005);
    EXPECT_NEAR(*b[std::size_t(part)], 0.02, 0.002);
  }
}

TEST(LandmarkSources, AMovingHeadHasNoTremble) {
  const FoundPoints moving = walk(200, 0.5, 2, 1);
  const auto still = still_frames({moving});
  EXPECT_EQ(std::ranges::count(still, true), 0);
  for (const auto& noise : tremble(moving, still)) EXPECT_FALSE(noise.has_value());
}

TEST(LandmarkSources, AConstantOffsetIsNoMovingError) {
  const FoundPoints truth = walk(50, 0, 1, 1);
  FoundPoints found = truth;
  for (auto& points : found)
    for (std::size_t k = 48; k < 68; ++k) (*points)[k] += Vec2d(3, -4);
  found[7].reset();
  const PointErrors errors = point_errors(found, truth);
  EXPECT_NEAR(errors.whole[std::size_t(FacePart::lips)], 0.05, 1e-9);
  EXPECT_NEAR(errors.moving[std::size_t(FacePart::lips)], 0, 1e-9);
  EXPECT_NEAR(errors.whole[std::size_t(FacePart::brows)], 0, 1e-9);
}

TEST(LandmarkSources, MouthAndEyesAreJudgedByTheirGaps) {
  Points open = face_at({200, 150});
  const auto gap = [](Points& p, std::initializer_list<std::array<int, 2>> pairs, double px) {
    for (const auto& [upper, lower] : pairs) p[std::size_t(lower)] = p[std::size_t(upper)] + Vec2d(0, px);
  };
  gap(open, {{61, 67}, {62, 66}, {63, 65}}, 6);
  gap(open, {{37, 41}, {38, 40}, {43, 47}, {44, 46}}, 9);
  Points shut = open;
  gap(shut, {{61, 67}, {62, 66}, {63, 65}}, 1);
  gap(shut, {{37, 41}, {38, 40}, {43, 47}, {44, 46}}, 2);
  const FoundPoints found{open, open, shut, std::nullopt};
  using enum Marked;
  const MarkScore score = score_points(found, {10, 11, 12, 13},
                                       {{10, yes, no, unsure},
                                        {11, no, no, unsure},  // wrong: the mouth is open
                                        {12, no, yes, unsure},
                                        {13, unsure, no, unsure},  // no face: wrong
                                        {99, yes, yes, unsure}});  // no such frame
  EXPECT_EQ(score.mouths, 3);
  EXPECT_EQ(score.wrong_mouths, std::vector<int>{11});
  EXPECT_EQ(score.eyes, 4);
  EXPECT_EQ(score.wrong_eyes, std::vector<int>{13});
}

}  // namespace
}  // namespace likeness
