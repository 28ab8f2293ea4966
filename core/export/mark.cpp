// Text in a corner: see mark.h.
#include "core/export/mark.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>

namespace likeness {

void draw_mark(Image8& picture, std::string_view text) {
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  const std::string line(text);
  int below = 0;
  const cv::Size unit = cv::getTextSize(line, kFont, 1, 1, &below);
  // Letters of fewer than 9 px cannot be read.
  const double high = std::max(9.0, picture.height / 30.0) / unit.height;
  const double scale = std::min(high, 0.9 * picture.width / unit.width);
  const int thickness = std::max(1, int(std::lround(scale * 1.4)));
  const int margin = std::max(2, picture.height / 60);
  const cv::Point at(margin, picture.height - margin - int(std::ceil(below * scale)));
  cv::Mat pixels(picture.height, picture.width, CV_8UC(picture.channels), picture.data.data());
  cv::putText(pixels, line, at, kFont, scale, {20, 20, 20, 255}, thickness + 2, cv::LINE_AA);
  cv::putText(pixels, line, at, kFont, scale, {240, 240, 240, 255}, thickness, cv::LINE_AA);
}

}  // namespace likeness
