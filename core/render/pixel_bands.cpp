// Cutting pictures and lists of pixels into bands.
#include "core/render/pixel_bands.h"

#include <algorithm>
#include <cmath>

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

int reduction(const Intrinsics& full, std::size_t rays) {
  const auto pixels = [&](int reduce) {
    const Intrinsics k = reduced(full, reduce);
    return std::size_t(k.width) * std::size_t(k.height);
  };
  if (pixels(1) <= rays) return 1;
  int reduce = 2;
  while (4 * pixels(reduce) > 3 * rays && pixels(reduce) > 1) ++reduce;
  return reduce;
}

std::vector<Eigen::Vector2i> edge_cells(const Image& picture, float contrast, std::size_t most) {
  const int width = picture.width, height = picture.height, columns = width + 1;
  std::vector<float> differs(std::size_t(columns) * std::size_t(height + 1), 0.f);
  // A step between two pixels is shared by the cells on both sides of the line between them.
  const auto raise = [&](int column, int row, float step) {
    float& cell = differs[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
    cell = std::max(cell, step);
  };
  const auto step = [&](int x, int y, int x2, int y2) {
    const float *a = picture.at(x, y), *b = picture.at(x2, y2);
    float worst = 0;
    for (int c = 0; c < picture.channels; ++c) worst = std::max(worst, std::abs(a[c] - b[c]));
    return worst;
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (x + 1 < width)
        for (const float s = step(x, y, x + 1, y); const int row : {y, y + 1}) raise(x + 1, row, s);
      if (y + 1 < height)
        for (const float s = step(x, y, x, y + 1); const int column : {x, x + 1}) raise(column, y + 1, s);
    }
  std::vector<std::uint32_t> edges;
  for (std::size_t i = 0; i < differs.size(); ++i)
    if (differs[i] > contrast) edges.push_back(std::uint32_t(i));
  if (edges.size() > most) {
    // Among equal steps - whole outlines, from transparent to opaque - some are taken everywhere.
    const auto scattered = [](std::uint32_t i) { return i * 2654435761u; };
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
      return differs[a] != differs[b] ? differs[a] > differs[b] : scattered(a) < scattered(b);
    };
    std::nth_element(edges.begin(), edges.begin() + std::ptrdiff_t(most), edges.end(), before);
    edges.resize(most);
    std::sort(edges.begin(), edges.end());
  }
  std::vector<Eigen::Vector2i> cells;
  for (const std::uint32_t i : edges)
    cells.emplace_back(int(i % std::uint32_t(columns)) - 1, int(i / std::uint32_t(columns)) - 1);
  return cells;
}

Band edge_band(const Intrinsics& k, const Intrinsics& fewer, std::span<const Eigen::Vector2i> cells) {
  // The first pixel whose centre lies at or beyond that of the reduced picture's pixel `cell`.
  const auto first = [](int cell, int from, int to) {
    return cell < 0 ? 0 : int(std::ceil((cell + 0.5) * to / from - 0.5));
  };
  Band band;
  band.empty_blocks_walk = true;
  for (const Eigen::Vector2i& cell : cells) {
    const int left = first(cell.x(), fewer.width, k.width), top = first(cell.y(), fewer.height, k.height);
    const int right = cell.x() + 1 == fewer.width ? k.width : first(cell.x() + 1, fewer.width, k.width);
    const int bottom = cell.y() + 1 == fewer.height ? k.height : first(cell.y() + 1, fewer.height, k.height);
    if (left == right || top == bottom) continue;
    const auto block = std::uint32_t(band.blocks.size());
    band.blocks.push_back(direction_at(k, 0.5 * (left + right), 0.5 * (top + bottom)));
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) {
        band.place.push_back(std::uint32_t(y * k.width + x));
        band.directions.push_back(direction_at(k, x + 0.5, y + 0.5));
        band.block_of.push_back(block);
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
