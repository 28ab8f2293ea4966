// See picture_cells.h.
#include "core/capture/picture_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr double kNoise = 4;          // levels^2: of a small picture's pixel, as coded films leave it
constexpr double kGradientFloor = 2;  // levels per px: noise has gradients, too
constexpr float kMostGradient = 12, kMostContrast = 24;

// Sums over one cell of both pictures.
struct CellSums {
  double a = 0, b = 0, aa = 0, bb = 0, ab = 0, gradient = 0;
};

double slope_squared(const Image8& picture, int x, int y) {
  const auto at = [&](int column, int row) {
    return double(
        *picture.at(std::clamp(column, 0, picture.width - 1), std::clamp(row, 0, picture.height - 1)));
  };
  const double dx = 0.5 * (at(x + 1, y) - at(x - 1, y)), dy = 0.5 * (at(x, y + 1) - at(x, y - 1));
  return dx * dx + dy * dy;
}

CellSums sums_of(const Image8& before, const Image8& after, int left, int top, int cell) {
  CellSums s;
  for (int y = top; y < top + cell; ++y)
    for (int x = left; x < left + cell; ++x) {
      const double a = *before.at(x, y), b = *after.at(x, y);
      s.a += a, s.b += b, s.aa += a * a, s.bb += b * b, s.ab += a * b;
      s.gradient += 0.5 * (slope_squared(before, x, y) + slope_squared(after, x, y));
    }
  return s;
}

}  // namespace

CellChange compare_cells(const Image8& before, const Image8& after, int cell) {
  LIKENESS_CHECK(before.width == after.width && before.height == after.height && before.channels == 1 &&
                     after.channels == 1 && before.width % cell == 0 && before.height % cell == 0,
                 "%d x %d px and %d x %d px in cells of %d", before.width, before.height, after.width,
                 after.height, cell);
  CellChange change;
  const double n = double(cell) * cell;
  for (int top = 0; top < before.height; top += cell)
    for (int left = 0; left < before.width; left += cell) {
      const CellSums s = sums_of(before, after, left, top, cell);
      const double va = std::max(0.0, s.aa / n - s.a / n * (s.a / n)),
                   vb = std::max(0.0, s.bb / n - s.b / n * (s.b / n)),
                   together = s.ab / n - s.a / n * (s.b / n);
      const double scale = std::sqrt((va + kNoise) * (vb + kNoise));
      // What is left of the difference once brightness and contrast agree. Two cells that show nothing agree.
      const double left_over = std::sqrt(std::max(0.0, (va + vb) * (1 - (together + kNoise) / scale)));
      const double gradient = std::sqrt(s.gradient / n);
      change.moved.push_back(float(left_over / (gradient + kGradientFloor)));
      change.gradient.push_back(std::min(float(gradient), kMostGradient));
      change.alike.push_back(float(together / scale));
      change.contrast.push_back(std::min(float(std::sqrt(std::max(va, vb))), kMostContrast));
    }
  return change;
}

double mean_motion(const CellChange& change, double most) {
  double sum = 0, weight = 1e-9;
  for (std::size_t i = 0; i < change.moved.size(); ++i) {
    sum += double(change.gradient[i]) * std::min(double(change.moved[i]), most);
    weight += double(change.gradient[i]);
  }
  return sum / weight;
}

}  // namespace likeness
