// Claims about how a person network's share is taken up: what it decides, and what it leaves open.
#include "core/matte/person_share.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace likeness {
namespace {

constexpr int kShareSide = 120;
constexpr double kHole = 9;
const ShareBand kBand{3, 9, 5};

cv::Mat nothing() { return cv::Mat(kShareSide, kShareSide, CV_8U, cv::Scalar(0)); }
int at(const cv::Mat& mask, int x, int y) { return mask.at<unsigned char>(y, x); }

// A head on shoulders that reach the lower border; what the track knows is the middle of the head, and it
// guesses a narrow torso.
struct Bust {
  cv::Mat share = nothing();
  PersonPrior prior;
  Bust() {
    cv::ellipse(share, {60, 45}, {18, 24}, 0, 0, 360, 255, cv::FILLED);
    cv::rectangle(share, {20, 80}, {100, kShareSide}, 255, cv::FILLED);
    cv::rectangle(share, {52, 60}, {68, 85}, 255, cv::FILLED);
    cv::GaussianBlur(share, share, {0, 0}, 1);
    prior.certain = nothing(), prior.likely = nothing(), prior.possible = nothing(), prior.below = nothing(),
    prior.hair = nothing();
    cv::ellipse(prior.certain, {60, 45}, {12, 18}, 0, 0, 360, 255, cv::FILLED);
    cv::rectangle(prior.certain, {54, 90}, {66, kShareSide}, 255, cv::FILLED);
    cv::rectangle(prior.below, {0, 78}, {kShareSide, kShareSide}, 255, cv::FILLED);
    cv::circle(prior.hair, {60, 45}, 40, 255, cv::FILLED);
    cv::circle(prior.likely, {60, 45}, 24, 255, cv::FILLED);
    cv::circle(prior.possible, {60, 45}, 34, 255, cv::FILLED);
    prior.location = cv::Mat(kShareSide, kShareSide, CV_32F, cv::Scalar(-1));
  }
  void take_up() { take_up_share(prior, share, kBand, kHole); }
};

TEST(SteadyShare, FlickerOfOnePictureIsGoneAndAMovingOutlineStays) {
  // An edge that moves by 7 px a picture, and a hole and a patch in the middle picture alone.
  const auto half = [](int to) {
    cv::Mat share = nothing();
    share(cv::Rect(0, 0, to, kShareSide)).setTo(255);
    return share;
  };
  const cv::Mat before = half(40), own = half(47), after = half(54);
  cv::Mat flickers = own.clone();
  cv::circle(flickers, {20, 60}, 6, 10, cv::FILLED);
  cv::circle(flickers, {90, 60}, 6, 240, cv::FILLED);
  EXPECT_EQ(cv::countNonZero(steady_share(before, flickers, after) != own), 0);
}

TEST(PersonsOwnShare, SomebodyElseIsLeftOut) {
  Bust bust;
  cv::circle(bust.share, {108, 30}, 8, 255, cv::FILLED);
  const cv::Mat own = persons_own_share(bust.share, bust.prior.certain, kHole);
  EXPECT_EQ(at(own, 108, 30), 0);
  EXPECT_GT(at(own, 60, 45), 250);
  EXPECT_GT(at(own, 25, 110), 250);  // the same person's shoulder, far from the seed
}

TEST(PersonsOwnShare, ASmallHoleIsClosedAndALargeOneIsSeenThrough) {
  Bust bust;
  cv::circle(bust.share, {40, 100}, 3, 0, cv::FILLED);
  cv::circle(bust.share, {80, 100}, 8, 0, cv::FILLED);
  const cv::Mat own = persons_own_share(bust.share, bust.prior.certain, kHole);
  EXPECT_EQ(at(own, 40, 100), 255);
  EXPECT_EQ(at(own, 80, 100), 0);
}

TEST(PersonsOwnShare, ANetworkThatLooksElsewhereHasFailed) {
  Bust bust;
  cv::Mat elsewhere = nothing();
  cv::circle(elsewhere, {15, 15}, 12, 255, cv::FILLED);
  EXPECT_TRUE(persons_own_share(elsewhere, bust.prior.certain, kHole).empty());
  EXPECT_TRUE(persons_own_share(bust.share, nothing(), kHole).empty());
  const PersonPrior before = bust.prior;
  bust.share = elsewhere;
  const cv::Mat certain = bust.prior.certain.clone(), location = bust.prior.location.clone();
  bust.take_up();
  EXPECT_TRUE(bust.prior.held.empty());
  EXPECT_TRUE(bust.prior.excluded.empty());
  EXPECT_EQ(cv::countNonZero(bust.prior.certain != certain), 0);
  EXPECT_EQ(cv::countNonZero(bust.prior.location != location), 0);
}

// The track guesses a narrow torso; the plate would learn the rest of one that never moves.
TEST(TakeUpShare, ATorsoAtRestIsCertainToItsOutline) {
  Bust bust;
  ASSERT_EQ(at(bust.prior.possible, 30, 110), 0);
  bust.take_up();
  for (const int x : {26, 40, 80, 94}) {
    EXPECT_EQ(at(bust.prior.certain, x, 110), 255) << x;
    EXPECT_EQ(at(bust.prior.held, x, 110), 255) << x;
    EXPECT_EQ(at(bust.prior.likely, x, 110), 255) << x;
    EXPECT_EQ(at(bust.prior.possible, x, 110), 255) << x;
  }
  EXPECT_EQ(at(bust.prior.certain, 60, kShareSide - 1), 255);  // the picture's border is not an outline
}

TEST(TakeUpShare, AboutTheOutlineItLeavesTheCutFree) {
  Bust bust;
  bust.take_up();
  for (int x = 0; x < kShareSide; ++x) {
    const int from_edge = x - 100;  // of the shoulder's right side, away from hair
    if (x < 60) continue;
    if (from_edge != 5) {  // the band's edge
      EXPECT_EQ(at(bust.prior.excluded, x, 112) > 0, from_edge > 5) << x;
    }
    if (from_edge > -3 && from_edge < 3) {
      EXPECT_EQ(at(bust.prior.certain, x, 112), 0) << x;
      EXPECT_EQ(at(bust.prior.possible, x, 112), 255) << x;
    }
  }
  // What the network says there is evidence, more on its sides than on the outline itself.
  const auto& location = bust.prior.location;
  EXPECT_GT(location.at<float>(112, 98), 1);
  EXPECT_LT(location.at<float>(112, 104), -1);
  EXPECT_LT(std::abs(location.at<float>(112, 101)), 1.5f);
}

TEST(TakeUpShare, TheBandIsWiderWhereHairMayBe) {
  Bust bust;
  bust.take_up();
  // To the right of the head, its outline at 78; the same distance from the shoulder's is excluded.
  EXPECT_EQ(at(bust.prior.possible, 85, 45), 255);
  EXPECT_EQ(at(bust.prior.excluded, 85, 45), 0);
  EXPECT_EQ(at(bust.prior.excluded, 93, 45), 255);
  EXPECT_EQ(at(bust.prior.excluded, 108, 112), 255);
}

TEST(TakeUpShare, ARaisedHandIsThePersonsFarFromTheTrack) {
  Bust bust;
  cv::line(bust.share, {95, 100}, {108, 60}, 255, 9);
  cv::circle(bust.share, {108, 55}, 9, 255, cv::FILLED);
  bust.take_up();
  EXPECT_EQ(at(bust.prior.certain, 108, 55), 255);
  EXPECT_EQ(at(bust.prior.likely, 108, 61), 255);
}

TEST(TakeUpShare, ATorsoThatIsNotWhereTheTrackGuessesIsNotCertain) {
  Bust bust;
  bust.share(cv::Rect(0, 95, kShareSide, kShareSide - 95)).setTo(0);  // the person stands behind a desk
  ASSERT_EQ(at(bust.prior.certain, 60, 112), 255);
  bust.take_up();
  EXPECT_EQ(at(bust.prior.certain, 60, 112), 0);
  EXPECT_EQ(at(bust.prior.excluded, 60, 112), 255);
}

// A dip of the share in the middle of the face: the track knows better.
TEST(TakeUpShare, TheTrackedHeadStaysWhereTheNetworkIsUnsure) {
  Bust bust;
  cv::circle(bust.share, {60, 45}, 8, 60, cv::FILLED);
  bust.take_up();
  EXPECT_EQ(at(bust.prior.certain, 60, 45), 255);
  EXPECT_EQ(at(bust.prior.likely, 60, 45), 255);
}

// Somebody else may be hidden behind the person's own hand: neither person nor wall.
TEST(TakeUpShare, SomebodyElseIsNeitherThePersonNorTheBackground) {
  Bust bust;
  cv::circle(bust.share, {108, 30}, 8, 255, cv::FILLED);
  bust.take_up();
  EXPECT_EQ(at(bust.prior.certain, 108, 30), 0);
  EXPECT_EQ(at(bust.prior.likely, 108, 30), 0);
  EXPECT_EQ(at(bust.prior.excluded, 108, 30), 0);
  EXPECT_LT(bust.prior.location.at<float>(30, 108), 0);
}

}  // namespace
}  // namespace likeness
