// Claims about separating person from background in one picture, and about the soft edge.
#include "core/matte/segment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

namespace likeness {
namespace {

constexpr int kSide = 96;

// How much of a pixel lies in a disc.
double coverage(int x, int y, double cx, double cy, double radius) {
  int inside = 0;
  for (int sy = 0; sy < 6; ++sy)
    for (int sx = 0; sx < 6; ++sx)
      inside += std::hypot(x + (sx + 0.5) / 6 - cx, y + (sy + 0.5) / 6 - cy) < radius;
  return inside / 36.0;
}

struct DiscScene {
  cv::Mat picture = cv::Mat(kSide, kSide, CV_8UC3), alpha = cv::Mat(kSide, kSide, CV_8U);
  cv::Mat wall = cv::Mat(kSide, kSide, CV_8UC3);
  PersonPrior prior;
  Plate plate;
  DiscScene() {
    std::mt19937 random(2);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const int stripe = (x / 8 + y / 8) % 2 ? 60 : 190;
        wall.at<cv::Vec3b>(y, x) = {(unsigned char)stripe, (unsigned char)(stripe / 2), 120};
        const double a = coverage(x, y, 48, 48, 28);
        alpha.at<unsigned char>(y, x) = (unsigned char)std::lround(255 * a);
        for (int c = 0; c < 3; ++c) {
          const double person = cv::Vec3b(210, 160, 40)[c];
          const double mixed = a * person + (1 - a) * wall.at<cv::Vec3b>(y, x)[c] + double(random() % 5) - 2;
          picture.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<unsigned char>(mixed);
        }
      }
    // The track knows the disc roughly: certain in the middle, possible well beyond the edge.
    prior.certain = cv::Mat(kSide, kSide, CV_8U, cv::Scalar(0));
    prior.possible = prior.certain.clone();
    cv::circle(prior.certain, {48, 48}, 14, 255, cv::FILLED);
    cv::circle(prior.possible, {48, 48}, 42, 255, cv::FILLED);
    prior.location = cv::Mat(kSide, kSide, CV_32F, cv::Scalar(0));
    plate = estimate_plate(std::vector<cv::Mat>(3, wall),
                           std::vector<cv::Mat>(3, cv::Mat(kSide, kSide, CV_8U, cv::Scalar(0))));
  }
};

double overlap(const cv::Mat& a, const cv::Mat& b) {
  const cv::Mat x = a > 127, y = b > 127;
  return double(cv::countNonZero(x & y)) / cv::countNonZero(x | y);
}

TEST(CutPerson, FindsTheOutlineFromThePlateAlone) {
  const DiscScene scene;
  const ColourModel unknown;
  EXPECT_GT(overlap(cut_person({&scene.picture, &scene.prior, &scene.plate, &unknown}), scene.alpha), 0.97);
}

TEST(CutPerson, FindsTheOutlineFromColoursAlone) {
  const DiscScene scene;
  ColourModel colours;
  colours.add(scene.picture, scene.prior.certain, true);
  const cv::Mat outside = scene.prior.possible == 0;
  colours.add(scene.picture, outside, false);
  colours.finish();
  EXPECT_GT(overlap(cut_person({&scene.picture, &scene.prior, nullptr, &colours}), scene.alpha), 0.95);
}

TEST(CutPerson, DropsWhatIsNotConnectedToThePerson) {
  DiscScene scene;
  cv::circle(scene.picture, {88, 8}, 5, cv::Scalar(10, 250, 10),
             cv::FILLED);  // something that moved in the background
  const ColourModel unknown;
  const cv::Mat person = cut_person({&scene.picture, &scene.prior, &scene.plate, &unknown});
  EXPECT_EQ(person.at<unsigned char>(8, 88), 0);
}

TEST(CutPerson, AFaintShadowOnTheWallIsNotThePerson) {
  DiscScene scene;
  scene.prior.possible.setTo(255);
  for (int y = 70; y < 92; ++y)
    for (int x = 4; x < 34; ++x) scene.picture.at<cv::Vec3b>(y, x) = scene.wall.at<cv::Vec3b>(y, x) * 0.85;
  const ColourModel unknown;
  const cv::Mat person = cut_person({&scene.picture, &scene.prior, &scene.plate, &unknown});
  EXPECT_EQ(cv::countNonZero(person(cv::Rect(4, 72, 22, 18))), 0);
}

TEST(Soften, RecoversTheMixtureAlongTheEdge) {
  const DiscScene scene;
  const cv::Mat person = scene.alpha > 127;
  for (const Plate* plate : {&scene.plate, static_cast<const Plate*>(nullptr)}) {
    const cv::Mat alpha = soften(scene.picture, person, plate, 3);
    double sum = 0;
    int count = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const int truth = scene.alpha.at<unsigned char>(y, x);
        const double distance = std::abs(std::hypot(x + 0.5 - 48, y + 0.5 - 48) - 28);
        if (distance > 8) {
          EXPECT_EQ(alpha.at<unsigned char>(y, x), truth) << x << "," << y;
        }
        if (truth == 0 || truth == 255) continue;
        sum += std::abs(alpha.at<unsigned char>(y, x) - truth);
        ++count;
      }
    // The hard cut would be wrong by 64 on average.
    EXPECT_LT(sum / count, plate ? 15 : 50);
  }
}

TEST(ColourModel, IsPositiveForThePersonsColoursAndNegativeForTheBackgrounds) {
  const DiscScene scene;
  ColourModel colours;
  const cv::Mat inside = scene.alpha == 255, outside = scene.alpha == 0;
  colours.add(scene.picture, inside, true);
  colours.add(scene.picture, outside, false);
  colours.finish();
  EXPECT_GT(colours.ratio({210, 160, 40}), 1);
  EXPECT_LT(colours.ratio({60, 30, 120}), -1);
  EXPECT_FLOAT_EQ(colours.ratio({0, 255, 0}), 0);  // never seen: says nothing
}

}  // namespace
}  // namespace likeness
