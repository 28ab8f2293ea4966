// Red from the matte, blue and green from the posed model; the model has no hair, so the matte above the neck
// line and near the head joins the green.
#include "core/matte/regions.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace likeness {
namespace {

constexpr double kHairReach = 0.12;  // m from the bare head; anything farther is not the head's

// The matte of the crop at its place in the source picture, zero outside the crop.
cv::Mat matte_in_source(const Capture& capture, const cv::Mat& alpha) {
  const SquareCrop& crop = capture.crop;
  cv::Mat full(capture.height, capture.width, CV_8U, cv::Scalar(0)), large;
  cv::resize(alpha, large, {crop.side, crop.side}, 0, 0,
             crop.side > alpha.cols ? cv::INTER_LINEAR : cv::INTER_AREA);
  const cv::Rect inside =
      cv::Rect(crop.x, crop.y, crop.side, crop.side) & cv::Rect(0, 0, full.cols, full.rows);
  if (!inside.empty()) large(inside - cv::Point(crop.x, crop.y)).copyTo(full(inside));
  return full;
}

}  // namespace

cv::Mat head_with_hair(const cv::Mat& matte, const PersonModel& person, const PersonPlace& place,
                       const Intrinsics& picture) {
  cv::Mat head = head_silhouette(person, place, picture, false);
  cv::Mat away;
  cv::distanceTransform(255 - head, away, cv::DIST_L2, 3);
  const float reach = float(kHairReach * place.px_per_metre);
  for (int y = 0; y < head.rows; ++y)
    for (int x = 0; x < head.cols; ++x) {
      if (!matte.at<unsigned char>(y, x) || away.at<float>(y, x) > reach) continue;
      const Vec2d from_jaw = Vec2d(x + 0.5, y + 0.5) - place.jaw_corners;
      if (from_jaw.dot(place.up) > 0) head.at<unsigned char>(y, x) = 255;
    }
  return head;
}

Image8 draw_regions(const Capture& capture, const cv::Mat& alpha, const PersonModel& person,
                    const PersonPlace& place, const Intrinsics& source) {
  const cv::Mat matte = matte_in_source(capture, alpha) > 127;
  cv::Mat head = head_with_hair(matte, person, place, source);
  const cv::Mat face = head_silhouette(person, place, source, true);
  const int radius = std::max(1, int(std::lround(0.03 * capture.crop.side)));
  cv::dilate(head, head, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}));
  Image8 regions(capture.width, capture.height, 3);
  for (int y = 0; y < head.rows; ++y)
    for (int x = 0; x < head.cols; ++x) {
      if (!capture.film.empty() && !capture.film.contains(x, y)) continue;
      unsigned char* pixel = regions.at(x, y);
      pixel[0] = matte.at<unsigned char>(y, x);
      pixel[1] = head.at<unsigned char>(y, x);
      pixel[2] = face.at<unsigned char>(y, x);
    }
  return regions;
}

}  // namespace likeness
