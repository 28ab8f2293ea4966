// See person_share.h.
#include "core/matte/person_share.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr unsigned char kRatherPerson = 127;               // above it a pixel is more person than not
constexpr unsigned char kSurelyIn = 230, kSurelyOut = 25;  // of 255: what the network is sure of
constexpr double kSeedSeen = 0.5;  // of the seed: below it, the network looks at something else

// The outline is drawn on a grid of 256, about 2 mm in a head-and-shoulders picture, and off by up to two of
// its cells; a strand of hair is off by centimetres. Metres.
constexpr double kEdgeBand = 0.012, kHairBandOutside = 0.035, kHairBandInside = 0.02;
constexpr double kMinBand = 2;  // px

// Evidence of the place from a share: its log-odds, less than a plate that clearly differs.
constexpr float kShareTrust = 0.8f;
// The tracked place stays a part of it: a pot beside a shoulder, which the network half believes in, lies
// where few people are.
constexpr float kPlaceTrust = 0.5f;
constexpr float kAnotherPerson = -1.5f;  // the same where the network sees somebody else

float odds_of_share(unsigned char share) {
  const float value = std::clamp(float(share) / 255, 0.02f, 0.98f);
  return std::log(value / (1 - value));
}

// px to the nearest pixel that is zero in `mask`; the picture's edge is not a border.
cv::Mat depth_in(const cv::Mat& mask) {
  cv::Mat depth;
  if (cv::countNonZero(mask) == int(mask.total()))
    depth = cv::Mat(mask.size(), CV_32F, cv::Scalar(1e6));
  else
    cv::distanceTransform(mask, depth, cv::DIST_L2, 5);
  return depth;
}

// 255 in those holes of `person` that a disc of `hole_px` across would not enter far: too small to be seen
// through.
cv::Mat small_holes(const cv::Mat& person, double hole_px) {
  cv::Mat labels, statistics, centres, holes(person.size(), CV_8U, cv::Scalar(0));
  const cv::Mat background = person == 0;
  const int count = cv::connectedComponentsWithStats(background, labels, statistics, centres, 4, CV_32S);
  const double largest = M_PI / 4 * hole_px * hole_px;
  std::vector<char> closes(std::size_t(count), 0);
  for (int i = 1; i < count; ++i) {
    const int* s = statistics.ptr<int>(i);
    const bool open = s[cv::CC_STAT_LEFT] == 0 || s[cv::CC_STAT_TOP] == 0 ||
                      s[cv::CC_STAT_LEFT] + s[cv::CC_STAT_WIDTH] == person.cols ||
                      s[cv::CC_STAT_TOP] + s[cv::CC_STAT_HEIGHT] == person.rows;
    closes[std::size_t(i)] = !open && s[cv::CC_STAT_AREA] <= largest;
  }
  for (int y = 0; y < person.rows; ++y)
    for (int x = 0; x < person.cols; ++x)
      if (closes[std::size_t(labels.at<int>(y, x))]) holes.at<unsigned char>(y, x) = 255;
  return holes;
}

// 255 on the patches of `mask` that touch `seed`.
cv::Mat patches_at(const cv::Mat& mask, const cv::Mat& seed) {
  cv::Mat labels, kept(mask.size(), CV_8U, cv::Scalar(0));
  const int count = cv::connectedComponents(mask, labels, 8, CV_32S);
  std::vector<char> touches(std::size_t(count), 0);
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (seed.at<unsigned char>(y, x)) touches[std::size_t(labels.at<int>(y, x))] = 1;
  touches[0] = 0;
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (touches[std::size_t(labels.at<int>(y, x))]) kept.at<unsigned char>(y, x) = 255;
  return kept;
}

}  // namespace

cv::Mat steady_share(const cv::Mat& before, const cv::Mat& own, const cv::Mat& after) {
  cv::Mat low, high, middle;
  cv::min(before, after, low);
  cv::max(before, after, high);
  cv::min(own, high, middle);
  cv::max(low, middle, middle);
  return middle;
}

cv::Mat persons_own_share(const cv::Mat& share, const cv::Mat& seed, double hole_px) {
  const cv::Mat anybody = share > kRatherPerson;
  const int seed_size = cv::countNonZero(seed);
  if (seed_size == 0 || cv::countNonZero(anybody & seed) < kSeedSeen * seed_size) return {};
  const cv::Mat person = patches_at(anybody, seed), with_rim = patches_at(share > kSurelyOut, person);
  cv::Mat result = share.clone();
  result.setTo(0, with_rim == 0);
  result.setTo(0, anybody & (person == 0));
  result.setTo(255, small_holes(result > kRatherPerson, hole_px));
  return result;
}

ShareBand share_band(double px_per_metre) {
  const auto width = [&](double metres) { return std::max(kMinBand, metres * px_per_metre); };
  return {width(kEdgeBand), width(kHairBandOutside), width(kHairBandInside)};
}

void take_up_share(PersonPrior& prior, const cv::Mat& share, const ShareBand& band, double hole_px) {
  if (share.empty()) return;
  LIKENESS_CHECK(share.size() == prior.certain.size() && share.type() == CV_8U,
                 "a share of %d px for a prior of %d px", share.cols, prior.certain.cols);
  const cv::Mat head = prior.certain & (prior.below == 0);
  const cv::Mat own = persons_own_share(share, head, hole_px);
  if (own.empty()) return;
  cv::Mat anybody;
  cv::max(share, own, anybody);
  anybody = anybody > kSurelyOut;
  const cv::Mat inside = own > kSurelyIn;
  const cv::Mat depth = depth_in(inside), away = depth_in(anybody == 0);
  prior.excluded = cv::Mat(share.size(), CV_8U, cv::Scalar(0));
  for (int y = 0; y < share.rows; ++y)
    for (int x = 0; x < share.cols; ++x) {
      const bool hair = prior.hair.at<unsigned char>(y, x);
      const unsigned char value = own.at<unsigned char>(y, x);
      const bool far = away.at<float>(y, x) > float(hair ? band.hair_outside : band.edge),
                 deep = depth.at<float>(y, x) > float(hair ? band.hair_inside : band.edge),
                 person = value > kRatherPerson,
                 another = !person && share.at<unsigned char>(y, x) > kRatherPerson;
      unsigned char& certain = prior.certain.at<unsigned char>(y, x);
      // The bare head well inside its outline is as sure as the network; the torso below it is a guess.
      const bool tracked =
          certain && (person || (!prior.below.at<unsigned char>(y, x) && value > kSurelyOut));
      certain = deep || tracked ? 255 : 0;
      prior.likely.at<unsigned char>(y, x) = person || tracked ? 255 : 0;
      prior.possible.at<unsigned char>(y, x) = far ? 0 : 255;
      prior.excluded.at<unsigned char>(y, x) = far ? 255 : 0;
      float& location = prior.location.at<float>(y, x);
      location = another ? kAnotherPerson : kShareTrust * odds_of_share(value) + kPlaceTrust * location;
    }
  prior.held = inside | prior.certain;
}

}  // namespace likeness
