// Claims about the square crop.
#include "core/capture/choose_crop.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace likeness {
namespace {

FaceBox face_at(double centre_x, double centre_y, double width) {
  return {centre_x - width / 2, centre_y - width / 2, width, width, 1};
}

TEST(ChooseCrop, HoldsEveryHeadAndStaysInsideThePicture) {
  std::mt19937 random(3);
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<>(a, b)(random); };
  for (int trial = 0; trial < 300; ++trial) {
    const int width = int(uniform(480, 1920)), height = int(uniform(480, 1920));
    const double shorter = std::min(width, height), face = uniform(0.12, 0.3) * shorter;
    const double cx = uniform(0.3, 0.7) * width, cy = uniform(0.35, 0.6) * height;
    std::vector<FaceBox> faces;
    for (int i = 0; i < 40; ++i) {
      faces.push_back(face_at(cx + uniform(-0.2, 0.2) * face, cy + uniform(-0.2, 0.2) * face,
                              face * uniform(0.95, 1.05)));
    }
    const SquareCrop crop = choose_crop(faces, {0, 0, width, height}).crop;
    EXPECT_GE(crop.x, 0);
    EXPECT_GE(crop.y, 0);
    EXPECT_LE(crop.x + crop.side, width);
    EXPECT_LE(crop.y + crop.side, height);
    for (const FaceBox& f : faces) {
      EXPECT_LE(crop.x, f.x - 0.1 * f.width);
      EXPECT_GE(crop.x + crop.side, f.x + 1.1 * f.width);
      EXPECT_LE(crop.y, std::max(0.0, f.y - 0.45 * f.height));
      EXPECT_GE(crop.y + crop.side, f.y + 1.1 * f.height);
    }
  }
}

TEST(ChooseCrop, TakesShouldersWithASmallHeadInALargePicture) {
  const SquareCrop crop = choose_crop({face_at(960, 400, 200)}, {0, 0, 1920, 1080}).crop;
  EXPECT_LT(crop.side, 700);
  EXPECT_GE(crop.y + crop.side, 400 + 100 + 1.05 * 200);
  EXPECT_NEAR(crop.x + crop.side / 2.0, 960, 2);
}

TEST(ChooseCrop, TakesTheWholeOfASquarePictureThatAHeadNearlyFills) {
  const SquareCrop crop = choose_crop({face_at(250, 230, 170)}, {0, 0, 512, 512}).crop;
  EXPECT_EQ(crop.x, 0);
  EXPECT_EQ(crop.y, 0);
  EXPECT_EQ(crop.side, 512);
}

TEST(ChooseCrop, IgnoresSingleMistakesOfTheDetector) {
  std::vector<FaceBox> faces(60, face_at(900, 400, 200));
  const SquareCrop clean = choose_crop(faces, {0, 0, 1920, 1080}).crop;
  faces.push_back(face_at(200, 950, 210));  // far away and alone
  faces.push_back(face_at(900, 400, 600));  // three times as large
  const SquareCrop crop = choose_crop(faces, {0, 0, 1920, 1080}).crop;
  EXPECT_EQ(crop.side, clean.side);
  EXPECT_EQ(crop.x, clean.x);
  EXPECT_EQ(crop.y, clean.y);
}

TEST(ChooseCrop, FollowsAHeadThatMovesAcrossThePicture) {
  std::vector<FaceBox> faces;
  for (int i = 0; i < 50; ++i) faces.push_back(face_at(500 + 10 * i, 500, 200));
  const SquareCrop crop = choose_crop(faces, {0, 0, 1920, 1080}).crop;
  EXPECT_LE(crop.x, 400);
  EXPECT_GE(crop.x + crop.side, 990 + 100);
}

TEST(ChooseCrop, ReachesBeyondAPictureTooNarrowForTheHead) {
  // The heads span 760 px of a picture 400 px high.
  std::vector<FaceBox> faces;
  for (int i = 0; i < 50; ++i) faces.push_back(face_at(200 + 12 * i, 200, 180));
  const SquareCrop crop = choose_crop(faces, {0, 0, 1000, 400}).crop;
  EXPECT_GT(crop.side, 400);
  EXPECT_LT(crop.y, 0);
  EXPECT_GT(crop.y + crop.side, 400);
  EXPECT_LE(crop.x, 110);
  EXPECT_GE(crop.x + crop.side, 200 + 588 + 90);
}

// As a phone held upright films a selfie: the boxes of a head at rest jump by the steps of the detector's
// scales.
TEST(ChooseCrop, StaysInAPortraitFilmThatTheHeadNearlyFills) {
  std::vector<FaceBox> faces;
  for (int i = 0; i < 60; ++i) faces.push_back(face_at(370, 612, std::array{418, 448, 403, 360, 465}[i % 5]));
  const SquareCrop crop = choose_crop(faces, {0, 0, 720, 1280}).crop;
  EXPECT_EQ(crop.side, 720);
  EXPECT_EQ(crop.x, 0);
  // From the hair to below the chin.
  EXPECT_LE(crop.y, 612 - 418 / 2 - 0.45 * 418);
  EXPECT_GE(crop.y + crop.side, 612 + 418 / 2 + 0.1 * 418);
}

TEST(ChooseCrop, KnowsOnlyTheFilmWithinItsBars) {
  const std::vector<FaceBox> faces(20, face_at(960, 500, 300));
  const std::vector<FaceBox> moved(20, face_at(960 + 700, 500 + 40, 300));
  const SquareCrop film = choose_crop(faces, {600, 0, 600, 1000}).crop,
                   bars = choose_crop(moved, {600 + 700, 40, 600, 1000}).crop;
  EXPECT_EQ(bars.x, film.x + 700);
  EXPECT_EQ(bars.y, film.y + 40);
  EXPECT_EQ(bars.side, film.side);
}

TEST(ChooseCrop, CountsHeadsThatThePictureCutsOff) {
  EXPECT_EQ(choose_crop({face_at(300, 300, 150)}, {0, 0, 640, 640}).head_cut_share, 0);
  EXPECT_EQ(choose_crop({face_at(300, 90, 150)}, {0, 0, 640, 640}).head_cut_share, 1);
}

}  // namespace
}  // namespace likeness
