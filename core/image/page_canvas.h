// A white page to draw on: wrapped text, boxes, curves over time, pictures.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "core/image/image.h"

namespace likeness {

using PageColour = std::array<std::uint8_t, 3>;  // sRGB
inline constexpr PageColour kInk{40, 44, 52}, kPale{150, 155, 163}, kRule{222, 225, 230}, kGood{46, 139, 87},
    kFair{217, 145, 22}, kBad{196, 58, 49}, kCourse{52, 101, 164}, kWhite{255, 255, 255};

// px of the page; y counts down, box.y is its upper edge.
struct PageBox {
  int x = 0, y = 0, width = 0, height = 0;
};

struct PageText {
  double size = 17;  // px, height of a capital letter plus descender
  PageColour colour = kInk;
  bool bold = false;
};

class PageCanvas {
 public:
  PageCanvas(int width, int height);

  void fill(const PageBox& box, const PageColour& colour);
  void frame(const PageBox& box, const PageColour& colour);
  void line(double x0, double y0, double x1, double y1, const PageColour& colour, int thickness = 1);
  // One line, its upper left corner at (x, y); returns its width.
  int text(int x, int y, std::string_view words, const PageText& how = {});
  int text_width(std::string_view words, const PageText& how) const;
  // Wrapped at `width`; returns the y below it.
  int paragraph(int x, int y, int width, std::string_view words, const PageText& how = {});
  // The picture, reduced or enlarged to fill the box, its middle kept.
  void picture(const PageBox& box, const Image8& rgb);

  // The page down to `height`.
  Image8 finish(int height) const;

 private:
  Image8 page_;
};

}  // namespace likeness
