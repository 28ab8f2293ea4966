// Claims about the background plate.
#include "core/matte/plate.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <random>

#include "core/matte/plate_file.h"

namespace likeness {
namespace {

cv::Mat wall() {
  cv::Mat picture(48, 64, CV_8UC3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      picture.at<cv::Vec3b>(y, x) = {(unsigned char)(2 * x + 40), (unsigned char)(3 * y), 90};
  return picture;
}

double largest_difference(const cv::Mat& a, const cv::Mat& b, const cv::Mat& where) {
  double most = 0;
  for (int y = 0; y < a.rows; ++y)
    for (int x = 0; x < a.cols; ++x)
      if (where.at<unsigned char>(y, x))
        for (int c = 0; c < 3; ++c)
          most = std::max(most, std::abs(double(a.at<cv::Vec3b>(y, x)[c]) - b.at<cv::Vec3b>(y, x)[c]));
  return most;
}

TEST(Plate, RecoversTheWallBehindAMovingPersonAndCoversWhatWasSeen) {
  std::mt19937 random(5);
  std::vector<cv::Mat> pictures, masks;
  cv::Mat ever_free(48, 64, CV_8U, cv::Scalar(0));
  for (int i = 0; i < 30; ++i) {
    cv::Mat picture = wall(), mask(48, 64, CV_8U, cv::Scalar(0));
    for (auto it = picture.begin<cv::Vec3b>(); it != picture.end<cv::Vec3b>(); ++it)
      for (int c = 0; c < 3; ++c)
        (*it)[c] = cv::saturate_cast<unsigned char>((*it)[c] + int(random() % 5) - 2);
    const cv::Rect person(10 + i % 12, 12, 30, 36);
    picture(person).setTo(cv::Scalar(200, 30, 30));
    mask(person).setTo(255);
    // Once in a while the mask misses the person: the median is unaffected.
    if (i % 10 == 3) mask.setTo(0);
    pictures.push_back(picture);
    masks.push_back(mask);
    ever_free.setTo(255, mask == 0);
  }
  const Plate plate = estimate_plate(pictures, masks);
  cv::Mat beside(48, 64, CV_8U, cv::Scalar(0));
  beside(cv::Rect(0, 0, 17, 48)).setTo(255);
  beside(cv::Rect(46, 0, 18, 48)).setTo(255);
  EXPECT_LE(largest_difference(plate.colour, wall(), beside & plate.known), 2);
  EXPECT_GE(cv::countNonZero(plate.known & beside), cv::countNonZero(beside) * 9 / 10);
}

TEST(Plate, HairMissedByACutDoesNotBecomeTheWall) {
  // Brown hair rests in nine pictures of ten, and the cut missed its upper half in all of these.
  const cv::Vec3b brown(90, 60, 40);
  const cv::Rect hair(24, 16, 16, 8), missed(24, 16, 16, 4);
  std::vector<cv::Mat> pictures, masks;
  PlateDoubt doubt;
  doubt.persons_own = [&](const cv::Vec3b& colour) { return cv::norm(colour, brown, cv::NORM_INF) < 20; };
  for (int i = 0; i < 20; ++i) {
    cv::Mat picture = wall(), mask(48, 64, CV_8U, cv::Scalar(0)), near = mask.clone();
    const int aside = i % 10 == 0 ? 20 : 0;
    const cv::Point by(aside, 0);
    for (int y = hair.y; y < hair.br().y; ++y)  // in strands that sway with the head
      for (int x = hair.x; x < hair.br().x; ++x) {
        const int strand = 6 * ((x + i % 3) % 4 / 2);
        picture.at<cv::Vec3b>(y, x + aside) = brown + cv::Vec3b::all((unsigned char)(strand));
      }
    mask(hair + by).setTo(255);
    mask(missed + by).setTo(0);
    near(cv::Rect(20, 12, 24, 16) + by).setTo(255);
    pictures.push_back(picture), masks.push_back(mask), doubt.near.push_back(near);
  }
  const cv::Point top(30, 17);
  EXPECT_LE(cv::norm(estimate_plate(pictures, masks).colour.at<cv::Vec3b>(top), brown, cv::NORM_INF), 6);
  const Plate seen = estimate_plate(pictures, masks, &doubt);  // the two pictures without the hair decide
  EXPECT_EQ(seen.known.at<unsigned char>(top), 255);
  EXPECT_EQ(seen.colour.at<cv::Vec3b>(top), wall().at<cv::Vec3b>(top));
  for (cv::Mat& near : doubt.near) near.setTo(255);
  const Plate never_sure = estimate_plate(pictures, masks, &doubt);
  for (int y = missed.y; y < missed.br().y; ++y)
    for (int x = missed.x; x < missed.br().x; ++x) EXPECT_EQ(never_sure.known.at<unsigned char>(y, x), 0);
  EXPECT_EQ(never_sure.known.at<unsigned char>(5, 5), 255);  // near, but not of the person's colours
}

TEST(Plate, StaticTextureIsTheRoomsWhateverItsColour) {
  // Every colour might be the person's, and they are near all the time.
  constexpr int kHair = 32;  // from here on a texture that sways by a pixel or two
  std::vector<cv::Mat> pictures, masks(20, cv::Mat(48, 64, CV_8U, cv::Scalar(0)));
  PlateDoubt doubt;
  doubt.persons_own = [](const cv::Vec3b&) { return true; };
  doubt.near.assign(20, cv::Mat(48, 64, CV_8U, cv::Scalar(255)));
  for (int i = 0; i < 20; ++i) {
    cv::Mat picture(48, 64, CV_8UC3, cv::Scalar(120, 90, 70));
    for (int y = 0; y < 24; ++y)  // below it is plain
      for (int x = 0; x < 64; ++x) {
        const int shift = x < kHair ? 0 : i % 4;
        picture.at<cv::Vec3b>(y, x) = cv::Vec3b::all((unsigned char)(90 + 50 * ((x + shift) / 3 % 2)));
      }
    pictures.push_back(picture);
  }
  const Plate plate = estimate_plate(pictures, masks, &doubt);
  EXPECT_EQ(plate.known.at<unsigned char>(12, 12), kSeen);
  EXPECT_EQ(plate.colour.at<cv::Vec3b>(12, 12), pictures[0].at<cv::Vec3b>(12, 12));
  EXPECT_EQ(plate.known.at<unsigned char>(12, 52), 0);
  EXPECT_EQ(plate.known.at<unsigned char>(40, 12), 0);
}

TEST(Plate, RestingShirtFoldMissedByTheCutsIsNotTheWall) {
  // Striped cloth rests before a plain wall; the cuts end `missed` rows below its edge.
  const auto plate_of = [](int missed) {
    cv::Mat picture(48, 64, CV_8UC3, cv::Scalar(200, 210, 240)), mask(48, 64, CV_8U, cv::Scalar(0));
    for (int y = 20; y < 48; ++y)
      for (int x = 20; x < 28; ++x)
        picture.at<cv::Vec3b>(y, x) = cv::Vec3b::all((unsigned char)(20 + 50 * (x / 2 % 2)));
    mask(cv::Rect(20, 20 + missed, 8, 28 - missed)).setTo(255);
    PlateDoubt doubt;
    doubt.persons_own = [](const cv::Vec3b& colour) { return colour[0] < 100; };
    doubt.near.assign(20, cv::Mat(48, 64, CV_8U, cv::Scalar(255)));
    return estimate_plate(std::vector<cv::Mat>(20, picture), std::vector<cv::Mat>(20, mask), &doubt);
  };
  EXPECT_EQ(plate_of(3).known.at<unsigned char>(21, 24), 0);
  EXPECT_EQ(plate_of(3).known.at<unsigned char>(10, 24), kSeen);
  EXPECT_EQ(plate_of(20).known.at<unsigned char>(30, 24), kSeen);  // too large to be a sliver
}

TEST(Plate, HairHighlightMissedByTheCutsIsNotTheWall) {
  // It does not have the person's colours, and is at rest in every picture.
  const cv::Rect person(16, 16, 40, 32);
  const auto plate_of = [&](const cv::Rect& free) {
    cv::Mat picture(48, 64, CV_8UC3, cv::Scalar(200, 210, 240)), mask(48, 64, CV_8U, cv::Scalar(0));
    picture(person).setTo(cv::Scalar(60, 40, 30));
    picture(free).setTo(cv::Scalar(140, 130, 120));
    mask(person).setTo(255);
    mask(free).setTo(0);
    PlateDoubt doubt;
    doubt.persons_own = [](const cv::Vec3b& colour) { return colour[0] < 100; };
    doubt.near.assign(20, cv::Mat(48, 64, CV_8U, cv::Scalar(255)));
    return estimate_plate(std::vector<cv::Mat>(20, picture), std::vector<cv::Mat>(20, mask), &doubt);
  };
  const cv::Rect shine(28, 24, 8, 3), gap(28, 24, 8, 8), at_the_border(28, 45, 8, 3);
  EXPECT_EQ(plate_of(shine).known.at<unsigned char>(25, 32), 0);
  EXPECT_EQ(plate_of(shine).known.at<unsigned char>(5, 5), kSeen);
  EXPECT_EQ(plate_of(gap).known.at<unsigned char>(27, 32), kSeen);  // as between an arm and the body
  EXPECT_EQ(plate_of(at_the_border).known.at<unsigned char>(47, 32),
            kSeen);  // it may be part of anything
}

TEST(Plate, PixelsNeverSeenAreFilledAndNotCountedAsCovered) {
  const cv::Mat picture = wall();
  cv::Mat mask(48, 64, CV_8U, cv::Scalar(0));
  mask(cv::Rect(16, 12, 32, 36)).setTo(255);
  const Plate plate = estimate_plate(std::vector<cv::Mat>(6, picture), std::vector<cv::Mat>(6, mask));
  EXPECT_NEAR(plate.coverage(), 1 - 32.0 * 36 / (48 * 64), 0.06);
  EXPECT_EQ(plate.known.at<unsigned char>(30, 30), 0);
  // Red rises across the hole and is known on both sides, blue is constant; green can only be continued.
  for (int y = 14; y < 48; ++y)
    for (int x = 18; x < 46; ++x) {
      const cv::Vec3b filled = plate.colour.at<cv::Vec3b>(y, x), truth = picture.at<cv::Vec3b>(y, x);
      EXPECT_NEAR(filled[0], truth[0], 16) << x << "," << y;
      EXPECT_NEAR(filled[2], truth[2], 1) << x << "," << y;
      EXPECT_LE(filled[1], 3 * 47);
    }
}

TEST(FillHoles, ContinuesAConstantExactlyAndTouchesNothingKnown) {
  cv::Mat colour(40, 40, CV_8UC3, cv::Scalar(77, 123, 201)), known(40, 40, CV_8U, cv::Scalar(255));
  known(cv::Rect(5, 8, 30, 32)).setTo(0);
  colour.setTo(cv::Scalar(0, 255, 0), known == 0);
  const cv::Mat filled = fill_holes(colour, known);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(filled.at<cv::Vec3b>(y, x)[c], cv::Vec3b(77, 123, 201)[c], 1);
}

TEST(FillHoles, SurvivesAPictureThatIsAllHole) {
  const cv::Mat filled =
      fill_holes(cv::Mat(9, 7, CV_8UC3, cv::Scalar::all(0)), cv::Mat(9, 7, CV_8U, cv::Scalar(0)));
  EXPECT_EQ(filled.size(), cv::Size(7, 9));
}

TEST(PlateInfo, SurvivesTheFileAndAMissingFileMeansNoPlate) {
  const auto path =
      std::filesystem::temp_directory_path() / ("likeness_plate_" + std::to_string(::getpid()) + ".json");
  ASSERT_TRUE(write_plate_info(path, {1.0 / 3, {4, 5, 9}}).ok());
  const auto read = read_plate_info(path);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->coverage, 1.0 / 3);
  EXPECT_EQ(read->frames, (std::vector<int>{4, 5, 9}));
  std::ofstream(path) << "{}";
  EXPECT_FALSE(read_plate_info(path).ok());
  std::filesystem::remove(path);
  const auto none = read_plate_info(path);
  ASSERT_TRUE(none.ok());
  EXPECT_TRUE(none->frames.empty());
}

TEST(RoomPlate, IsTrustedAsFarAsItAgreesBesideThePerson) {
  const cv::Mat picture = wall();
  cv::Mat wrong = picture.clone(), free(48, 64, CV_8U, cv::Scalar(255)), reach(48, 64, CV_8U, cv::Scalar(0));
  wrong(cv::Rect(0, 0, 20, 48)) += cv::Scalar::all(40);  // a room that was learnt badly on the left
  free(cv::Rect(24, 8, 20, 40)).setTo(0);
  reach(cv::Rect(20, 4, 28, 44)).setTo(255);
  const Plate good = room_plate(picture, picture, free, reach), bad = room_plate(picture, wrong, free, reach);
  EXPECT_LT(good.noise.at<float>(30, 22), 6);
  EXPECT_GT(bad.noise.at<float>(30, 20), 1.5f * good.noise.at<float>(30, 20));
  EXPECT_GT(bad.noise.at<float>(30, 20), bad.noise.at<float>(30, 60));
  EXPECT_EQ(cv::norm(good.known, (reach != 0) & kOfRoom, cv::NORM_INF), 0);
}

TEST(CompletePlate, ShowsTheRoomWhereTheWallWasNeverSeen) {
  cv::Mat mask(48, 64, CV_8U, cv::Scalar(0));
  mask(cv::Rect(16, 12, 32, 36)).setTo(255);
  Plate plate = estimate_plate(std::vector<cv::Mat>(6, wall()), std::vector<cv::Mat>(6, mask));
  const Plate seen = {plate.colour.clone(), plate.noise.clone(), plate.known.clone()};
  const cv::Mat hole = seen.known == 0, room = wall() - cv::Scalar(10, 4, 0);  // learnt a little too dark
  complete_plate(plate, room);
  EXPECT_GT(largest_difference(seen.colour, wall(), hole), 15);
  EXPECT_LE(largest_difference(plate.colour, wall(), hole), 4);
  EXPECT_EQ(largest_difference(plate.colour, seen.colour, 255 - hole), 0);
  EXPECT_EQ(cv::norm(plate.noise, seen.noise, cv::NORM_INF, 255 - hole), 0);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      EXPECT_EQ(plate.known.at<unsigned char>(y, x), hole.at<unsigned char>(y, x) ? kOfRoom : kSeen);
  EXPECT_EQ(plate.coverage(), seen.coverage());
}

}  // namespace
}  // namespace likeness
