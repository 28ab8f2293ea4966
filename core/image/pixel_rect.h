// A rectangle of whole pixels.
#pragma once

#include <algorithm>
#include <cstdint>

namespace likeness {

// Columns x .. x + width - 1 and rows y .. y + height - 1; empty where either side is not positive.
struct PixelRect {
  int x = 0, y = 0, width = 0, height = 0;

  bool empty() const { return width <= 0 || height <= 0; }
  int right() const { return x + width; }
  int bottom() const { return y + height; }
  bool contains(int px, int py) const { return px >= x && py >= y && px < right() && py < bottom(); }
  bool operator==(const PixelRect&) const = default;
};

// The whole pixels that it holds of a picture resampled from `from` to `to` px a side.
inline PixelRect resampled(const PixelRect& rect, int from, int to) {
  if (rect.empty() || from == to) return rect;
  const auto first = [&](int at) { return int((std::int64_t(at) * to + from - 1) / from); };
  const auto last = [&](int at) { return int(std::int64_t(at) * to / from); };
  const int x = first(rect.x), y = first(rect.y);
  return {x, y, last(rect.right()) - x, last(rect.bottom()) - y};
}

// What both hold.
inline PixelRect common_part(const PixelRect& a, const PixelRect& b) {
  const int x = std::max(a.x, b.x), y = std::max(a.y, b.y);
  return {x, y, std::max(0, std::min(a.right(), b.right()) - x),
          std::max(0, std::min(a.bottom(), b.bottom()) - y)};
}

}  // namespace likeness
