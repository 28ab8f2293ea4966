// Drawing by OpenCV: see page_canvas.h.
#include "core/image/page_canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

namespace likeness {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kUnit = 29;  // px, height of this font's letters at scale 1, descenders included

cv::Scalar scalar(const PageColour& c) { return {double(c[0]), double(c[1]), double(c[2])}; }
cv::Rect rect(const PageBox& b) { return {b.x, b.y, std::max(0, b.width), std::max(0, b.height)}; }
cv::Mat view(Image8& image) { return {image.height, image.width, CV_8UC3, image.data.data()}; }
int thickness_of(const PageText& how) { return how.bold ? 2 : 1; }

// The font has no letters beyond these.
std::string plain(std::string_view words) {
  std::string letters;
  for (const char c : words) {
    if (static_cast<unsigned char>(c) < 128)
      letters += c;
    else if ((static_cast<unsigned char>(c) & 0xC0) != 0x80)  // one mark for a letter of several bytes
      letters += '?';
  }
  return letters;
}

}  // namespace

PageCanvas::PageCanvas(int width, int height) : page_(width, height, 3, 255) {}

void PageCanvas::fill(const PageBox& box, const PageColour& colour) {
  cv::Mat page = view(page_);
  cv::rectangle(page, rect(box), scalar(colour), cv::FILLED);
}

void PageCanvas::frame(const PageBox& box, const PageColour& colour) {
  cv::Mat page = view(page_);
  cv::rectangle(page, rect(box), scalar(colour), 1);
}

void PageCanvas::line(double x0, double y0, double x1, double y1, const PageColour& colour, int thickness) {
  cv::Mat page = view(page_);
  constexpr double kFine = 16;  // of four fractional bits
  cv::line(page, {int(std::lround(x0 * kFine)), int(std::lround(y0 * kFine))},
           {int(std::lround(x1 * kFine)), int(std::lround(y1 * kFine))}, scalar(colour), thickness,
           cv::LINE_AA, 4);
}

int PageCanvas::text_width(std::string_view words, const PageText& how) const {
  int below = 0;
  return cv::getTextSize(plain(words), kFont, how.size / kUnit, thickness_of(how), &below).width;
}

int PageCanvas::text(int x, int y, std::string_view words, const PageText& how) {
  cv::Mat page = view(page_);
  const int baseline = y + int(std::lround(0.76 * how.size));
  cv::putText(page, plain(words), {x, baseline}, kFont, how.size / kUnit, scalar(how.colour),
              thickness_of(how), cv::LINE_AA);
  return text_width(words, how);
}

int PageCanvas::paragraph(int x, int y, int width, std::string_view words, const PageText& how) {
  const int step = int(std::lround(1.5 * how.size));
  std::string row;
  const auto put = [&] {
    if (row.empty()) return;
    text(x, y, row, how);
    y += step;
    row.clear();
  };
  while (!words.empty()) {
    const auto space = words.find(' ');
    const std::string word(words.substr(0, space));
    words = space == std::string_view::npos ? std::string_view{} : words.substr(space + 1);
    const std::string longer = row.empty() ? word : row + " " + word;
    if (!row.empty() && text_width(longer, how) > width) {
      put();
      row = word;
    } else {
      row = longer;
    }
  }
  put();
  return y;
}

void PageCanvas::picture(const PageBox& box, const Image8& rgb) {
  if (rgb.empty() || box.width <= 0 || box.height <= 0) return;
  const double scale = std::max(double(box.width) / rgb.width, double(box.height) / rgb.height);
  const int w = std::max(box.width, int(std::lround(rgb.width * scale))),
            h = std::max(box.height, int(std::lround(rgb.height * scale)));
  Image8 fitted = crop(resize(rgb, w, h), (w - box.width) / 2, (h - box.height) / 2, box.width, box.height);
  view(fitted).copyTo(view(page_)(rect(box)));
}

Image8 PageCanvas::finish(int height) const {
  return crop(page_, 0, 0, page_.width, std::min(height, page_.height));
}

}  // namespace likeness
