// Mosaics by reading each frame at the mosaic's pixels.
#include "core/camera/grey_mosaic.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/camera/mosaic_geometry.h"

namespace likeness {
namespace {

constexpr float kUnseen = std::numeric_limits<float>::quiet_NaN();

// A frame's value between its pixels; NaN where one of the four is not known.
inline float read_frame(const GreyPicture& m, float x, float y) {
  if (!(x >= 0.5f && y >= 0.5f && x < float(m.width) - 0.5f && y < float(m.height) - 0.5f)) return kUnseen;
  x -= 0.5f, y -= 0.5f;
  const int ix = std::min(int(x), m.width - 2), iy = std::min(int(y), m.height - 2);
  const float fx = x - float(ix), fy = y - float(iy);
  const float* p = m.data.data() + std::size_t(iy) * std::size_t(m.width) + std::size_t(ix);
  const float top = p[0] + fx * (p[1] - p[0]), low = p[m.width] + fx * (p[m.width + 1] - p[m.width]);
  return top + fy * (low - top);
}

// The values that mosaic row y has in a frame, from column `begin` to `end`, freed of gain and bias.
template <class Add>
void read_row(const AlignedFrame& frame, const MosaicInView& map, int y, int begin, int end, const Add& add) {
  const float free = float(1 / frame.aligned.gain), bias = float(frame.aligned.bias);
  for (int x = begin; x < end; ++x) {
    const MosaicInView::Place place = map.place(float(x) + 0.5f, float(y) + 0.5f);
    if (place.depth <= 0) continue;
    const float value = read_frame(*frame.picture, place.x, place.y);
    if (value == value) add(x, (value - bias) * free);
  }
}

// The mean of what lies close to the median. Reorders the values.
float robust_mean(std::vector<float>& values) {
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + long(middle), values.end());
  const float median = values[middle];
  constexpr float kClose = 6;  // grey values: twice a noisy film's deviation
  float sum = 0;
  int count = 0;
  for (const float value : values)
    if (std::abs(value - median) <= kClose) sum += value, ++count;
  return sum / float(count);
}

}  // namespace

GrowingMosaic::GrowingMosaic(const Intrinsics& reference, int levels)
    : reference_(reference), levels_(levels) {}

void GrowingMosaic::grow(const Intrinsics& extent) {
  const Intrinsics& now = target_.intrinsics;
  const bool empty = target_.levels.empty();
  // Both origins lie on whole pixels of the reference.
  const int left = int(std::lround(extent.cx - (empty ? extent.cx : now.cx))),
            top = int(std::lround(extent.cy - (empty ? extent.cy : now.cy)));
  if (!empty && left <= 0 && top <= 0 && left + now.width >= extent.width &&
      top + now.height >= extent.height)
    return;
  Intrinsics larger = extent;
  if (!empty) {
    // The union of both.
    larger.cx = std::max(extent.cx, now.cx), larger.cy = std::max(extent.cy, now.cy);
    larger.width = int(std::lround(larger.cx + std::max(extent.width - extent.cx, now.width - now.cx)));
    larger.height = int(std::lround(larger.cy + std::max(extent.height - extent.cy, now.height - now.cy)));
  }
  GreyPicture mean(larger.width, larger.height, 1, kUnseen);
  Image weight(larger.width, larger.height, 1, 0.0f);
  if (!empty) {
    const int x0 = int(std::lround(larger.cx - now.cx)), y0 = int(std::lround(larger.cy - now.cy));
    for (int y = 0; y < now.height; ++y) {
      std::copy_n(target_.levels[0].at(0, y), now.width, mean.at(x0, y0 + y));
      std::copy_n(weight_.at(0, y), now.width, weight.at(x0, y0 + y));
    }
  }
  target_.intrinsics = larger;
  target_.levels.assign(1, std::move(mean));
  weight_ = std::move(weight);
}

void GrowingMosaic::add(const GreyPicture& picture, const AlignedView& aligned) {
  grow(mosaic_extent(reference_, std::span(&aligned.view, 1)));
  stale_ = true;
  GreyPicture& mean = target_.levels[0];
  const MosaicInView map(target_.intrinsics, reference_, aligned.view);
  const AlignedFrame frame{&picture, aligned};
  constexpr float kMemory = 30;  // frames: what comes later still counts
  constexpr float kClose = 12;   // grey values by which one frame may pull at what several agree on
  parallel_ranges(std::size_t(mean.height), 32, [&](std::size_t begin, std::size_t end) {
    for (int y = int(begin); y < int(end); ++y) {
      const auto span = map.columns(y);
      read_row(frame, map, y, span.first, span.second, [&](int x, float value) {
        float &m = *mean.at(x, y), &n = *weight_.at(x, y);
        if (n == 0) {
          m = value;
        } else {
          const float off = n < 3 ? value - m : std::clamp(value - m, -kClose, kClose);
          m += off / std::min(n + 1, kMemory);
        }
        ++n;
      });
    }
  });
}

const ViewTarget& GrowingMosaic::target() {
  if (stale_) {
    target_.levels = grey_pyramid(std::move(target_.levels[0]), levels_);
    stale_ = false;
  }
  return target_;
}

ViewTarget median_mosaic(std::span<const AlignedFrame> frames, const Intrinsics& reference, int levels) {
  std::vector<HandheldView> views;
  for (const AlignedFrame& frame : frames) views.push_back(frame.aligned.view);
  ViewTarget target;
  target.intrinsics = mosaic_extent(reference, views);
  GreyPicture mosaic(target.intrinsics.width, target.intrinsics.height, 1, kUnseen);
  std::vector<MosaicInView> maps;
  for (const AlignedFrame& frame : frames)
    maps.emplace_back(target.intrinsics, reference, frame.aligned.view);
  const std::size_t enough = frames.size() < 4 ? 1 : 2;
  parallel_ranges(std::size_t(mosaic.height), 4, [&](std::size_t begin, std::size_t end) {
    std::vector<std::vector<float>> seen(std::size_t(mosaic.width));
    for (auto& values : seen) values.reserve(frames.size());
    for (int y = int(begin); y < int(end); ++y) {
      for (auto& values : seen) values.clear();
      for (std::size_t i = 0; i < frames.size(); ++i) {
        const auto span = maps[i].columns(y);
        read_row(frames[i], maps[i], y, span.first, span.second,
                 [&](int x, float value) { seen[std::size_t(x)].push_back(value); });
      }
      for (int x = 0; x < mosaic.width; ++x)
        if (auto& values = seen[std::size_t(x)]; values.size() >= enough)
          *mosaic.at(x, y) = robust_mean(values);
    }
  });
  target.levels = grey_pyramid(std::move(mosaic), levels);
  return target;
}

}  // namespace likeness
