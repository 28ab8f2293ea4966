// Sums over masks.
#include "core/lab/beyond/measures.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
constexpr int kSpeckLevels = 48, kSpeckWindow = 7;

bool far_apart(const std::uint8_t* a, const std::uint8_t* b) {
  for (int c = 0; c < 3; ++c)
    if (std::abs(int(a[c]) - int(b[c])) > kSpeckLevels) return true;
  return false;
}

}  // namespace

double speck_share(const Image8& truth, const Image8& rendered, const Image8& mask) {
  LIKENESS_CHECK(truth.data.size() == rendered.data.size() && mask.pixels() == truth.pixels(),
                 "%zu, %zu and %zu pixels", truth.pixels(), rendered.pixels(), mask.pixels());
  const cv::Mat picture(rendered.height, rendered.width, CV_8UC3,
                        const_cast<std::uint8_t*>(rendered.data.data()));
  cv::Mat usual;
  cv::medianBlur(picture, usual, kSpeckWindow);
  std::size_t count = 0, specks = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    if (mask.data[i] == 0) continue;
    ++count;
    const std::uint8_t* own = rendered.data.data() + 3 * i;
    specks += far_apart(own, truth.data.data() + 3 * i) && far_apart(own, usual.data + 3 * i);
  }
  return count > 0 ? double(specks) / double(count) : kNoValue;
}

Vec3d mean_colour(const Image8& picture, const Image8& mask) {
  Vec3d sum = Vec3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    if (mask.data[i] == 0) continue;
    ++count;
    for (int c = 0; c < 3; ++c) sum[c] += picture.data[3 * i + std::size_t(c)];
  }
  return count > 0 ? Vec3d(sum / double(count)) : Vec3d::Constant(kNoValue);
}

double mean_change(const Image8& a, const Image8& b, const Image8& mask) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    if (mask.data[i] == 0) continue;
    ++count;
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(int(a.data[3 * i + c]) - int(b.data[3 * i + c]));
  }
  return count > 0 ? sum / double(3 * count) : kNoValue;
}

double mask_iou(const Image8& a, const Image8& b) {
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    both += a.data[i] != 0 && b.data[i] != 0;
    either += a.data[i] != 0 || b.data[i] != 0;
  }
  return either > 0 ? double(both) / double(either) : 1;
}

}  // namespace likeness
