// Components, distances and medians by OpenCV; sums over masks.
#include "core/holds/picture_faults.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr float kOpaqueAlpha = 0.5f, kClearAlpha = 0.2f, kSolidAlpha = 0.8f;
constexpr double kGap = 0.03, kSoftRim = 0.02;  // of the picture's width; a gap is closed from both sides
constexpr double kMostHair = 0.98;              // of the alpha above the chin
constexpr int kSpeck = 48, kSpeckNeighbours = 7;

cv::Mat opaque_mask(const Image& alpha, float above) {
  LIKENESS_CHECK(alpha.channels == 1, "alpha of %d channels", alpha.channels);
  cv::Mat mask(alpha.height, alpha.width, CV_8U);
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x) mask.at<unsigned char>(y, x) = *alpha.at(x, y) > above ? 255 : 0;
  return mask;
}

cv::Mat view_of(const Image8& mask) {
  return {mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.data.data())};
}

// px to the nearest pixel of the mask; everywhere far for an empty one.
cv::Mat away_from(const Image8& mask) {
  cv::Mat away;
  cv::distanceTransform(255 - view_of(mask), away, cv::DIST_L2, 5);
  return away;
}

// px to the nearest pixel outside, the picture's border not counting.
cv::Mat depth_within(const cv::Mat& mask) {
  cv::Mat depth;
  cv::distanceTransform(mask, depth, cv::DIST_L2, 5);
  return depth;
}

cv::Mat disk(double radius) {
  const int r = std::max(1, int(std::lround(radius)));
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * r + 1, 2 * r + 1});
}

}  // namespace

double loose_share(const Image& alpha) {
  cv::Mat labels, sizes, middles;
  const int count =
      cv::connectedComponentsWithStats(opaque_mask(alpha, kOpaqueAlpha), labels, sizes, middles, 8, CV_32S);
  double all = 0, largest = 0;
  for (int i = 1; i < count; ++i) {
    const double size = sizes.at<int>(i, cv::CC_STAT_AREA);
    all += size, largest = std::max(largest, size);
  }
  return all > 0 ? 1 - largest / all : 0;
}

double shredded_share(const Image& alpha) {
  cv::Mat body = opaque_mask(alpha, kClearAlpha);
  // As if the body went on beyond the picture: its lower edge is no outline.
  const int margin = std::max(1, int(std::lround(2 * kGap * alpha.width)));
  cv::copyMakeBorder(body, body, margin, margin, margin, margin, cv::BORDER_REPLICATE);
  cv::morphologyEx(body, body, cv::MORPH_CLOSE, disk(kGap * alpha.width));
  const cv::Mat depth = depth_within(body);
  double inside = 0, through = 0;
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x) {
      if (depth.at<float>(y + margin, x + margin) <= kSoftRim * alpha.width) continue;
      inside += 1, through += *alpha.at(x, y) < kSolidAlpha;
    }
  return inside > 0 ? through / inside : 0;
}

double missing_share(const Image& alpha, const Image8& mask, double rim_px) {
  const cv::Mat depth = depth_within(view_of(mask));
  double inside = 0, missing = 0;
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x)
      if (depth.at<float>(y, x) > rim_px) inside += 1, missing += 1 - double(*alpha.at(x, y));
  return inside > 0 ? missing / inside : 0;
}

double reach_px(const Image& alpha, const Image8& mask, const Above& above) {
  const cv::Mat away = away_from(mask);
  std::vector<std::pair<float, double>> lies;  // how far, how much
  double all = 0;
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x)
      if (above.holds(x, y) && *alpha.at(x, y) > kClearAlpha)
        lies.emplace_back(away.at<float>(y, x), *alpha.at(x, y)), all += *alpha.at(x, y);
  std::ranges::sort(lies);
  double within = 0;
  for (const auto& [distance, amount] : lies)
    if ((within += amount) >= kMostHair * all) return distance;
  return 0;
}

double outside_share(const Image& alpha, const Image8& mask, const Above& above, double reach_px) {
  const cv::Mat away = away_from(mask);
  double area = 0, outside = 0;
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x) {
      if (!above.holds(x, y)) continue;
      area += *mask.at(x, y) != 0;
      if (away.at<float>(y, x) > reach_px) outside += double(*alpha.at(x, y));
    }
  return area > 0 ? outside / area : 0;
}

double speck_share_within(const Image& rgb, const Image8& mask) {
  const Image8 bytes = to_bytes(rgb);
  const cv::Mat picture(bytes.height, bytes.width, CV_8UC3, const_cast<std::uint8_t*>(bytes.data.data()));
  cv::Mat usual;
  cv::medianBlur(picture, usual, kSpeckNeighbours);
  double count = 0, specks = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    if (mask.data[i] == 0) continue;
    count += 1;
    bool off = false;
    for (std::size_t c = 0; c < 3; ++c)
      off |= std::abs(int(bytes.data[3 * i + c]) - int(usual.data[3 * i + c])) > kSpeck;
    specks += off;
  }
  return count > 0 ? specks / count : 0;
}

double change_within(const Image& a, const Image& b, const Image8& mask) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    if (mask.data[i] == 0) continue;
    count += 3;
    for (std::size_t c = 0; c < 3; ++c)
      sum += std::abs(double(a.data[3 * i + c]) - double(b.data[3 * i + c]));
  }
  return count > 0 ? sum / count : 0;
}

double brightness_within(const Image& rgb, const Image8& mask) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    if (mask.data[i] == 0) continue;
    count += 3;
    for (std::size_t c = 0; c < 3; ++c) sum += double(rgb.data[3 * i + c]);
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace likeness
