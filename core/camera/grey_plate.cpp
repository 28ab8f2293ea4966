// See grey_plate.h.
#include "core/camera/grey_plate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/quantile.h"

namespace likeness {
namespace {

constexpr std::size_t kFrames =
    48;  // spread over the clip: enough for a median, and for a share of a twentieth
constexpr std::size_t kLeastSeen = 6;  // frames in which a pixel is free before it is known
constexpr int kOff = 24;               // of 255: beyond noise, a codec and an edge's half pixel
constexpr double kMostOff = 0.03;      // of a frame's background; a hand that left the mask is about as much
constexpr double kMostUnexplained = 0.25;  // of the frames: passers-by and a door take fewer
constexpr std::size_t kLeastPixels = 200;  // of background, to say anything about a frame

}  // namespace

bool PlateFit::holds() const { return frames == 0 || unexplained <= kMostUnexplained; }

PlateFit fit_of_plate(const BackgroundPictures& pictures) {
  std::vector<std::size_t> chosen;
  const std::size_t all = pictures.frames.size(), count = std::min(kFrames, all);
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(i * all / count);
  PlateFit fit;
  if (count < kLeastSeen) return fit;
  const std::size_t pixels = pictures.grey.front().pixels();
  const auto is_free = [&](std::size_t i, std::size_t p) {
    const Image8* person = pictures.person_at(i);
    return person == nullptr || person->data[p] == 0;
  };
  std::vector<int> plate(pixels, -1);  // -1: not known
  parallel_ranges(pixels, 4096, [&](std::size_t begin, std::size_t end) {
    std::vector<int> seen;
    for (std::size_t p = begin; p < end; ++p) {
      seen.clear();
      for (const std::size_t i : chosen)
        if (is_free(i, p)) seen.push_back(pictures.grey[i].data[p]);
      if (seen.size() >= kLeastSeen) plate[p] = median(seen);
    }
  });
  int unexplained = 0;
  for (const std::size_t i : chosen) {
    const Image8& grey = pictures.grey[i];
    double own = 0, usual = 0;
    std::size_t known = 0, off = 0;
    for (std::size_t p = 0; p < pixels; ++p)
      if (plate[p] >= 0 && is_free(i, p)) own += grey.data[p], usual += plate[p], ++known;
    if (known < kLeastPixels || usual <= 0) continue;
    const double gain = own / usual;
    for (std::size_t p = 0; p < pixels; ++p)
      off += plate[p] >= 0 && is_free(i, p) && std::abs(grey.data[p] - gain * plate[p]) > kOff;
    ++fit.frames;
    unexplained += double(off) > kMostOff * double(known);
  }
  fit.unexplained = fit.frames > 0 ? double(unexplained) / fit.frames : 0;
  return fit;
}

}  // namespace likeness
