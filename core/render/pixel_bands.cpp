// Cutting pictures and lists of pixels into bands.
#include "core/render/pixel_bands.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace likeness {
namespace {

Vec3f direction_at(const Intrinsics& intrinsics, double x, double y) {
  return ray_direction(intrinsics, Vec2d(x, y)).normalized().cast<float>();
}

}  // namespace

Band tile_band(const Intrinsics& k, int left, int top, int block) {
  const int right = std::min(left + kTileSide, k.width), bottom = std::min(top + kTileSide, k.height);
  Band band;
  band.block_columns = (right - left + block - 1) / block;
  for (int y = top; y < bottom; y += block)
    for (int x = left; x < right; x += block)
      band.blocks.push_back(
          direction_at(k, 0.5 * (x + std::min(x + block, right)), 0.5 * (y + std::min(y + block, bottom))));
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) {
      band.place.push_back(std::uint32_t(y * k.width + x));
      band.directions.push_back(direction_at(k, x + 0.5, y + 0.5));
      band.block_of.push_back(std::uint32_t((y - top) / block * band.block_columns + (x - left) / block));
    }
  return band;
}

Intrinsics reduced(const Intrinsics& full, int reduce) {
  Intrinsics k = full;
  k.width = (full.width + reduce - 1) / reduce, k.height = (full.height + reduce - 1) / reduce;
  const double sx = double(k.width) / full.width, sy = double(k.height) / full.height;
  k.fx *= sx, k.cx *= sx, k.fy *= sy, k.cy *= sy;
  return k;
}

int reduction(const Intrinsics& full, int most_rays) {
  if (full.width * std::int64_t(full.height) <= most_rays) return 1;
  for (int reduce = 2;; ++reduce) {
    const Intrinsics fewer = reduced(full, reduce);
    if (4 * std::int64_t(fewer.width) * fewer.height <= 3 * std::int64_t(most_rays) ||
        (fewer.width == 1 && fewer.height == 1))
      return reduce;
  }
}

std::vector<Eigen::Vector2i> edge_pixels(const Image& picture, float contrast, std::size_t most) {
  std::vector<float> differs(picture.pixels(), 0.f);
  const auto at = [&](int x, int y) { return std::size_t(y) * std::size_t(picture.width) + std::size_t(x); };
  const auto compare = [&](int x, int y, int right, int down) {
    if (x + right >= picture.width || y + down >= picture.height) return;
    const float *a = picture.at(x, y), *b = picture.at(x + right, y + down);
    float worst = 0;
    for (int c = 0; c < picture.channels; ++c) worst = std::max(worst, std::abs(a[c] - b[c]));
    for (float* const own : {&differs[at(x, y)], &differs[at(x + right, y + down)]})
      *own = std::max(*own, worst);
  };
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) compare(x, y, 1, 0), compare(x, y, 0, 1);
  float least = contrast;
  if (most < differs.size()) {
    std::vector<float> ordered = differs;
    const auto first_left_out = ordered.begin() + std::ptrdiff_t(most);
    std::nth_element(ordered.begin(), first_left_out, ordered.end(), std::greater<float>());
    least = std::max(least, *first_left_out);
  }
  std::vector<Eigen::Vector2i> edges;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (differs[at(x, y)] > least) edges.emplace_back(x, y);
  return edges;
}

Band edge_band(const Intrinsics& k, std::span<const Eigen::Vector2i> edges, int reduce) {
  Band band;
  band.empty_blocks_walk = true;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const int left = edges[i].x() * reduce, right = std::min(left + reduce, k.width);
    const int top = edges[i].y() * reduce, bottom = std::min(top + reduce, k.height);
    band.blocks.push_back(direction_at(k, 0.5 * (left + right), 0.5 * (top + bottom)));
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) {
        band.place.push_back(std::uint32_t(y * k.width + x));
        band.directions.push_back(direction_at(k, x + 0.5, y + 0.5));
        band.block_of.push_back(std::uint32_t(i));
      }
  }
  return band;
}

Band listed_band(const Intrinsics& k, std::span<const std::uint32_t> pixels, std::size_t first,
                 std::size_t last) {
  Band band;
  const auto width = std::uint32_t(k.width);
  for (std::size_t i = first; i < last; ++i) {
    band.place.push_back(std::uint32_t(i));
    band.directions.push_back(direction_at(k, pixels[i] % width + 0.5, pixels[i] / width + 0.5));
    band.block_of.push_back(std::uint32_t(i - first));
  }
  band.blocks = band.directions;
  return band;
}

}  // namespace likeness
