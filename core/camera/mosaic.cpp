// Row by row over the frames, and back.
#include "core/camera/mosaic.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "core/base/parallel.h"
#include "core/camera/mosaic_geometry.h"
#include "core/image/metrics.h"

namespace likeness {
namespace {

constexpr int kColours = 3;

bool is_background(const Image8* person, int x, int y) {
  return !person || person->empty() || !*person->at(x, y);
}

// The frame's colour between its pixels; false outside and where one of the four is the person's.
bool read_colour(const MosaicFrame& frame, float x, float y, std::array<float, kColours>& colour) {
  const Image8& picture = *frame.colour;
  if (!(x >= 0.5f && y >= 0.5f && x < float(picture.width) - 0.5f && y < float(picture.height) - 0.5f))
    return false;
  x -= 0.5f, y -= 0.5f;
  const int ix = std::min(int(x), picture.width - 2), iy = std::min(int(y), picture.height - 2);
  if (!is_background(frame.person, ix, iy) || !is_background(frame.person, ix + 1, iy) ||
      !is_background(frame.person, ix, iy + 1) || !is_background(frame.person, ix + 1, iy + 1))
    return false;
  const float fx = x - float(ix), fy = y - float(iy);
  const std::uint8_t *a = picture.at(ix, iy), *c = picture.at(ix, iy + 1);
  for (int k = 0; k < kColours; ++k) {
    const float top = a[k] + fx * float(a[k + kColours] - a[k]),
                low = c[k] + fx * float(c[k + kColours] - c[k]);
    colour[std::size_t(k)] = top + fy * (low - top);
  }
  return true;
}

std::uint8_t usual_value(std::vector<std::uint8_t>& values) {
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + long(middle), values.end());
  const int median = values[middle];
  constexpr int kClose = 6;  // of 255: twice a noisy film's deviation
  int sum = 0, count = 0;
  for (const int value : values)
    if (std::abs(value - median) <= kClose) sum += value, ++count;
  return std::uint8_t((sum + count / 2) / count);
}

using RowColours = std::array<std::vector<std::vector<std::uint8_t>>, kColours>;

// What the frames show of a mosaic row: colours, and how many could have shown a pixel.
void read_row(std::span<const MosaicFrame> frames, const std::vector<MosaicInView>& maps, int row,
              RowColours& seen, std::vector<int>& views) {
  for (auto& channel : seen)
    for (auto& values : channel) values.clear();
  std::fill(views.begin(), views.end(), 0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const MosaicFrame& frame = frames[i];
    const float free = float(1 / frame.gain), bias = float(frame.bias);
    const auto [begin, end] = maps[i].columns(row);
    for (int x = begin; x < end; ++x) {
      const auto place = maps[i].place(float(x) + 0.5f, float(row) + 0.5f);
      if (place.depth <= 0 || place.x < 0 || place.y < 0 || place.x > float(frame.colour->width) ||
          place.y > float(frame.colour->height))
        continue;
      ++views[std::size_t(x)];
      std::array<float, kColours> colour;
      if (!read_colour(frame, place.x, place.y, colour)) continue;
      for (std::size_t k = 0; k < kColours; ++k)
        seen[k][std::size_t(x)].push_back(
            std::uint8_t(std::clamp((colour[k] - bias) * free + 0.5f, 0.0f, 255.0f)));
    }
  }
}

Mat3d frame_from_mosaic(const Mosaic& mosaic, const Camera& camera) {
  return camera.cam_from_world.linear() * mosaic.cam_from_world.linear().transpose();
}

// A frame's background against the mosaic, summed.
struct Comparison {
  double squares = 0;
  std::int64_t background = 0, known = 0, off = 0;

  LookBack judged() const {
    LookBack result;
    if (background) result.covered = double(known) / double(background);
    if (!known) return result;
    result.off = double(off) / double(known);
    // Equal pictures of eight bits still differ by what rounding hides.
    const double error = std::max(squares / (kColours * double(known)), 1.0 / 12) / (255.0 * 255.0);
    result.psnr = psnr_from_mse(error);
    return result;
  }
};

Comparison compare(const Mosaic& mosaic, const MosaicFrame& frame) {
  Image8 known;
  const Image8 shown = warp_mosaic(mosaic, frame.camera, &known);
  Comparison sums;
  for (int y = 0; y < shown.height; ++y)
    for (int x = 0; x < shown.width; ++x) {
      if (!is_background(frame.person, x, y)) continue;
      ++sums.background;
      if (!*known.at(x, y)) continue;
      ++sums.known;
      double worst = 0;
      for (int k = 0; k < kColours; ++k) {
        const double off = frame.gain * shown.at(x, y)[k] + frame.bias - frame.colour->at(x, y)[k];
        sums.squares += off * off;
        worst = std::max(worst, std::abs(off));
      }
      sums.off += worst > kLookBackOff;
    }
  return sums;
}

std::vector<Comparison> compare_all(const Mosaic& mosaic, std::span<const MosaicFrame> frames) {
  std::vector<Comparison> all(frames.size());
  parallel_for(frames.size(), [&](std::size_t i) { all[i] = compare(mosaic, frames[i]); });
  return all;
}

}  // namespace

std::vector<int> mosaic_frames(const HandheldSolve& solve, std::size_t most) {
  std::vector<int> numbers, chosen;
  std::vector<HandheldView> views;
  for (const HandheldCamera& camera : solve.cameras)
    if (camera.found && !camera.held_out) {
      numbers.push_back(camera.frame);
      views.push_back(handheld_view(camera));
    }
  for (const std::size_t i : covering_views(solve.reference, views, most)) chosen.push_back(numbers[i]);
  return chosen;
}

Intrinsics mosaic_intrinsics(const HandheldSolve& solve, int width, int height, double most_pixels) {
  const double sx = double(width) / solve.reference.width, sy = double(height) / solve.reference.height;
  Intrinsics k = solve.extent;
  const double pixels = k.width * sx * k.height * sy;
  const double less = std::min(1.0, std::sqrt(most_pixels / pixels));
  k.fx *= sx * less, k.cx *= sx * less, k.fy *= sy * less, k.cy *= sy * less;
  k.width = int(std::ceil(k.width * sx * less));
  k.height = int(std::ceil(k.height * sy * less));
  return k;
}

Result<Mosaic> build_mosaic(std::span<const MosaicFrame> frames, const Intrinsics& intrinsics,
                            const Progress& progress, std::stop_token stop) {
  Mosaic mosaic;
  mosaic.intrinsics = intrinsics;
  mosaic.colour = Image8(intrinsics.width, intrinsics.height, kColours);
  mosaic.known = Image8(intrinsics.width, intrinsics.height, 1);
  std::vector<MosaicInView> maps;
  for (const MosaicFrame& frame : frames) {
    if (!frame.colour || frame.colour->channels != kColours ||
        frame.colour->width != frame.camera.intrinsics.width ||
        frame.colour->height != frame.camera.intrinsics.height)
      return Error{ErrorCode::bad_input,
                   fmt::format("The picture of frame {} has not its camera's size.", frame.camera.frame),
                   "Solve the cameras of this clip again.", "camera"};
    maps.emplace_back(intrinsics, frame.camera.intrinsics, frame_from_mosaic(mosaic, frame.camera));
  }
  std::atomic<int> rows = 0;
  parallel_ranges(std::size_t(intrinsics.height), 8, [&](std::size_t begin, std::size_t end) {
    RowColours seen;
    for (auto& channel : seen) channel.resize(std::size_t(intrinsics.width));
    std::vector<int> views(std::size_t(intrinsics.width));
    for (int y = int(begin); y < int(end) && !stop.stop_requested(); ++y) {
      read_row(frames, maps, y, seen, views);
      for (int x = 0; x < intrinsics.width; ++x) {
        const std::size_t at = std::size_t(x), enough = std::size_t(std::max(2, views[at] / 20));
        if (seen[0][at].size() < std::min(enough, frames.size())) continue;
        if (seen[0][at].empty()) continue;
        for (std::size_t k = 0; k < kColours; ++k) mosaic.colour.at(x, y)[k] = usual_value(seen[k][at]);
        *mosaic.known.at(x, y) = 255;
      }
      progress.report(double(++rows) / intrinsics.height);
    }
  });
  if (stop.stop_requested()) return cancelled_error();
  return mosaic;
}

Image8 warp_mosaic(const Mosaic& mosaic, const Camera& to, Image8* known) {
  const Intrinsics &from = mosaic.intrinsics, &k = to.intrinsics;
  Image8 shown(k.width, k.height, kColours);
  if (known) *known = Image8(k.width, k.height, 1);
  // From the camera's pixels to the mosaic's: the same homography, the other way round.
  Intrinsics lens = k;
  lens.k1 = lens.k2 = lens.p1 = lens.p2 = 0;
  const MosaicInView map(lens, from, frame_from_mosaic(mosaic, to).transpose());
  // So many readings a side: one for every mosaic pixel that a pixel of the camera covers in the middle.
  const int side = std::clamp(int(std::lround(from.fx / k.fx)), 1, 8);
  MosaicFrame source;
  source.colour = &mosaic.colour;
  parallel_ranges(std::size_t(k.height), 16, [&](std::size_t begin, std::size_t end) {
    for (int y = int(begin); y < int(end); ++y)
      for (int x = 0; x < k.width; ++x) {
        std::array<float, kColours> sum{}, colour;
        int count = 0;
        bool all = true;
        for (int i = 0; i < side * side; ++i) {
          const auto place = map.place(float(x) + (float(i % side) + 0.5f) / float(side),
                                       float(y) + (float(i / side) + 0.5f) / float(side));
          if (place.depth <= 0 || !read_colour(source, place.x, place.y, colour)) {
            all = false;
            continue;
          }
          const int u = int(place.x - 0.5f), v = int(place.y - 0.5f);
          all &= *mosaic.known.at(u, v) && *mosaic.known.at(u + 1, v) && *mosaic.known.at(u, v + 1) &&
                 *mosaic.known.at(u + 1, v + 1);
          for (std::size_t c = 0; c < kColours; ++c) sum[c] += colour[c];
          ++count;
        }
        for (std::size_t c = 0; c < kColours && count; ++c)
          shown.at(x, y)[c] = std::uint8_t(sum[c] / float(count) + 0.5f);
        if (known && all && count) *known->at(x, y) = 255;
      }
  });
  return shown;
}

std::vector<LookBack> look_back(const Mosaic& mosaic, std::span<const MosaicFrame> frames) {
  std::vector<LookBack> judged;
  for (const Comparison& one : compare_all(mosaic, frames)) judged.push_back(one.judged());
  return judged;
}

LookBack look_back_together(const Mosaic& mosaic, std::span<const MosaicFrame> frames) {
  Comparison all;
  for (const Comparison& one : compare_all(mosaic, frames)) {
    all.squares += one.squares;
    all.background += one.background, all.known += one.known, all.off += one.off;
  }
  return all.judged();
}

}  // namespace likeness
