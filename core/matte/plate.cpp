// Per-pixel median and spread, then pull-push for pixels that were never free.
#include "core/matte/plate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/quantile.h"

namespace likeness {
namespace {

void blend(cv::Vec3f& value, const cv::Vec3f& with, float share) {
  value = with * share + value * (1 - share);
}

using Channels = std::array<std::vector<int>, 3>;

// Median colour, and the largest spread about it of a channel. Reorders the values.
float usual_colour(Channels& seen, cv::Vec3b& colour) {
  float spread = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const int usual = median(seen[c]);
    colour[int(c)] = (unsigned char)(usual);
    for (int& value : seen[c]) value = std::abs(value - usual);
    spread = std::max(spread, 1.4826f * float(median(seen[c])));
  }
  return spread;
}

constexpr unsigned char kDoubtful = 1;  // free, but of a colour that the person is more likely to have
constexpr float kStill = 0.5f;          // above which texture is the room's

// How certainly texture is static, 0..1: a body that breathes moves its texture by about a pixel, variance as
// large as the contrast. The room's variance is noise. Both in squared 8-bit units, of grey values.
float stillness(float contrast, float variance) {
  return contrast / (contrast + 2) * std::clamp(1.5f - 4 * variance / (contrast + 0.5f), 0.0f, 1.0f);
}

int texture_window(const cv::Mat& picture) { return std::max(5, picture.cols / 24 | 1); }

int grey_of(const cv::Vec3b& colour) { return (colour[0] + 2 * colour[1] + colour[2]) / 4; }

// Variance of the grey values at a pixel, from all but a tenth, which a bad cut may have spoilt; as for a
// normal distribution.
float usual_variance(std::vector<int>& grey) {
  constexpr float kNinth = 1.645f;  // standard deviations that hold nine tenths
  const int usual = median(grey);
  for (int& value : grey) value = std::abs(value - usual);
  const float deviation = float(quantile(grey, 0.9)) / kNinth;
  return deviation * deviation;
}

// Removes `settled` patches smaller than the window that decided on them where they adjoin unknown pixels:
// more likely a fold of a resting shoulder that the cuts missed.
void drop_slivers(const cv::Mat& known, int window, cv::Mat& settled) {
  cv::Mat beside, labels, statistics, centres;
  cv::dilate((known == 0) & (settled == 0), beside, cv::Mat());
  const int count = cv::connectedComponentsWithStats(settled, labels, statistics, centres);
  std::vector<char> hangs(std::size_t(count), 0);
  for (int y = 0; y < known.rows; ++y)
    for (int x = 0; x < known.cols; ++x)
      if (beside.at<unsigned char>(y, x)) hangs[std::size_t(labels.at<int>(y, x))] = 1;
  for (int y = 0; y < known.rows; ++y)
    for (int x = 0; x < known.cols; ++x) {
      const int patch = labels.at<int>(y, x);
      if (patch > 0 && hangs[std::size_t(patch)] &&
          statistics.at<int>(patch, cv::CC_STAT_AREA) < window * window)
        settled.at<unsigned char>(y, x) = 0;
    }
}

// Doubtful pixels amid static doubtful texture are the room's: hair moves with the head. The border between
// doubtful and seen pixels is an outline, which says nothing about either side. variance: of the grey values
// over time.
void settle_doubts(Plate& plate, const cv::Mat& variance) {
  cv::Mat contrast(plate.known.size(), CV_32F, cv::Scalar(0)), spread = contrast.clone(),
                                                               count = contrast.clone();
  const auto doubtful = [&](int y, int x) { return plate.known.at<unsigned char>(y, x) == kDoubtful; };
  const auto slope = [&](int y, int x, int dy, int dx) {
    return 0.5f * float(grey_of(plate.colour.at<cv::Vec3b>(y + dy, x + dx)) -
                        grey_of(plate.colour.at<cv::Vec3b>(y - dy, x - dx)));
  };
  for (int y = 1; y + 1 < contrast.rows; ++y)
    for (int x = 1; x + 1 < contrast.cols; ++x) {
      if (!doubtful(y, x)) continue;
      const bool across = doubtful(y, x - 1) && doubtful(y, x + 1),
                 down = doubtful(y - 1, x) && doubtful(y + 1, x);
      if (!across && !down) continue;
      const float dx = across ? slope(y, x, 0, 1) : 0, dy = down ? slope(y, x, 1, 0) : 0;
      contrast.at<float>(y, x) = dx * dx + dy * dy;
      spread.at<float>(y, x) = variance.at<float>(y, x);
      count.at<float>(y, x) = 1;
    }
  const int window = texture_window(contrast);
  for (cv::Mat* sum : {&contrast, &spread, &count}) cv::boxFilter(*sum, *sum, -1, {window, window});
  cv::Mat settled(contrast.size(), CV_8U, cv::Scalar(0));
  for (int y = 0; y < contrast.rows; ++y)
    for (int x = 0; x < contrast.cols; ++x) {
      const float n = count.at<float>(y, x);
      if (doubtful(y, x) && n > 0 &&
          stillness(contrast.at<float>(y, x) / n, spread.at<float>(y, x) / n) > kStill)
        settled.at<unsigned char>(y, x) = 255;
    }
  plate.known.setTo(0, plate.known == kDoubtful);
  drop_slivers(plate.known, window, settled);
  plate.known.setTo(kSeen, settled);
}

// Removes small patches that touch nothing known: more likely hair that the cuts missed than a wall seen
// through a gap, and so small a gap can be filled in from its rim. Patches cut off by the picture's border
// may be large.
void drop_islands(int window, cv::Mat& known) {
  cv::Mat labels, statistics, centres;
  const int count = cv::connectedComponentsWithStats(known, labels, statistics, centres);
  for (int i = 1; i < count; ++i) {
    const auto of = [&](int what) { return statistics.at<int>(i, what); };
    const bool inside = of(cv::CC_STAT_LEFT) > 0 && of(cv::CC_STAT_TOP) > 0 &&
                        of(cv::CC_STAT_LEFT) + of(cv::CC_STAT_WIDTH) < known.cols &&
                        of(cv::CC_STAT_TOP) + of(cv::CC_STAT_HEIGHT) < known.rows;
    if (inside && of(cv::CC_STAT_AREA) < window * window) known.setTo(0, labels == i);
  }
}

}  // namespace

double Plate::coverage() const {
  return known.empty() ? 0 : double(cv::countNonZero(known == kSeen)) / double(known.total());
}

cv::Mat fill_holes(const cv::Mat& colour, const cv::Mat& known) {
  // -- Pull: weighted averages down to one pixel.
  std::vector<cv::Mat> values, weights;
  cv::Mat value, weight, weight3;
  colour.convertTo(value, CV_32FC3);
  known.convertTo(weight, CV_32F, 1.0 / 255);
  cv::merge(std::array<cv::Mat, 3>{weight, weight, weight}, weight3);
  value = value.mul(weight3);
  while (true) {
    values.push_back(value);
    weights.push_back(weight);
    if (value.cols <= 1 && value.rows <= 1) break;
    cv::Mat smaller, smaller_weight;
    const cv::Size half(std::max(1, (value.cols + 1) / 2), std::max(1, (value.rows + 1) / 2));
    cv::pyrDown(value, smaller, half);
    cv::pyrDown(weight, smaller_weight, half);
    value = smaller;
    weight = smaller_weight;
  }
  // -- Push: each level completes the finer one where it has too little, then smooths what it completed.
  cv::Mat filled(values.back().size(), CV_32FC3, cv::Scalar::all(128));
  for (std::size_t level = values.size(); level-- > 0;) {
    cv::Mat coarse;
    cv::resize(filled, coarse, values[level].size(), 0, 0, cv::INTER_LINEAR);
    cv::Mat share(coarse.size(), CV_32F);
    for (int y = 0; y < coarse.rows; ++y)
      for (int x = 0; x < coarse.cols; ++x) {
        const float w = weights[level].at<float>(y, x);
        // The coarsest level has no coarser one.
        share.at<float>(y, x) = level + 1 == values.size() && w > 0 ? 1.0f : std::min(1.0f, 2 * w);
        if (w > 1e-6f)
          blend(coarse.at<cv::Vec3f>(y, x), values[level].at<cv::Vec3f>(y, x) / w, share.at<float>(y, x));
      }
    const cv::Mat anchor = coarse.clone();
    for (int sweep = 0; sweep < 12; ++sweep) {
      cv::Mat even;
      cv::blur(coarse, even, {3, 3});
      for (int y = 0; y < coarse.rows; ++y)
        for (int x = 0; x < coarse.cols; ++x) {
          blend(even.at<cv::Vec3f>(y, x), anchor.at<cv::Vec3f>(y, x), share.at<float>(y, x));
        }
      coarse = even;
    }
    filled = coarse;
  }
  cv::Mat result;
  filled.convertTo(result, CV_8UC3);
  colour.copyTo(result, known);
  return result;
}

Plate estimate_plate(const std::vector<cv::Mat>& pictures, const std::vector<cv::Mat>& occupied,
                     const PlateDoubt* doubt) {
  LIKENESS_CHECK(!pictures.empty() && pictures.size() == occupied.size() &&
                     (!doubt || doubt->near.size() == pictures.size()),
                 "%zu pictures and %zu masks", pictures.size(), occupied.size());
  const int width = pictures[0].cols, height = pictures[0].rows;
  Plate plate;
  plate.colour = cv::Mat(height, width, CV_8UC3, cv::Scalar::all(0));
  plate.noise = cv::Mat(height, width, CV_32F, cv::Scalar(0));
  plate.known = cv::Mat(height, width, CV_8U, cv::Scalar(0));
  cv::Mat variance(height, width, CV_32F, cv::Scalar(0));  // of doubtful pixels
  const std::size_t enough = std::min(pictures.size(), std::max<std::size_t>(2, pictures.size() / 20));
  parallel_ranges(std::size_t(height), 8, [&](std::size_t begin, std::size_t end) {
    Channels free, away;  // away: free and not near the person
    std::vector<int> grey;
    for (int y = int(begin); y < int(end); ++y)
      for (int x = 0; x < width; ++x) {
        for (Channels* seen : {&free, &away})
          for (auto& channel : *seen) channel.clear();
        for (std::size_t i = 0; i < pictures.size(); ++i) {
          if (occupied[i].at<unsigned char>(y, x)) continue;
          const auto& pixel = pictures[i].at<cv::Vec3b>(y, x);
          const bool near = doubt && doubt->near[i].at<unsigned char>(y, x);
          for (std::size_t c = 0; c < 3; ++c) {
            free[c].push_back(pixel[int(c)]);
            if (!near) away[c].push_back(pixel[int(c)]);
          }
        }
        const bool sure = away[0].size() >= enough;
        Channels& seen = sure ? away : free;
        if (seen[0].size() < enough) continue;
        grey.clear();
        for (std::size_t i = 0; doubt && !sure && i < seen[0].size(); ++i)
          grey.push_back((seen[0][i] + 2 * seen[1][i] + seen[2][i]) / 4);
        auto& colour = plate.colour.at<cv::Vec3b>(y, x);
        plate.noise.at<float>(y, x) = usual_colour(seen, colour);
        const bool doubtful = doubt && !sure && doubt->persons_own(colour);
        if (doubtful) variance.at<float>(y, x) = usual_variance(grey);
        plate.known.at<unsigned char>(y, x) = doubtful ? kDoubtful : kSeen;
      }
  });
  if (doubt) settle_doubts(plate, variance);
  // A colour at an edge is uncertain by what half a pixel of sway would change.
  cv::Mat grey, dx, dy;
  cv::cvtColor(plate.colour, grey, cv::COLOR_RGB2GRAY);
  cv::Sobel(grey, dx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(grey, dy, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::Mat gradient;
  cv::magnitude(dx, dy, gradient);
  plate.noise = cv::max(plate.noise, 2.0f) + 0.25f * gradient;
  // The rim of the hole mixes in some of the person's soft edge.
  cv::Mat inner;
  cv::erode(plate.known, inner, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  plate.known = inner;
  if (doubt) drop_islands(texture_window(inner), plate.known);
  plate.colour = fill_holes(plate.colour, plate.known);
  return plate;
}

Plate room_plate(const cv::Mat& picture, const cv::Mat& room, const cv::Mat& free, const cv::Mat& reach) {
  Plate plate;
  plate.colour = room;
  plate.known = (reach != 0) & kOfRoom;
  cv::Mat difference, worst(picture.size(), CV_32F), weight, error, count;
  cv::absdiff(picture, room, difference);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const auto& d = difference.at<cv::Vec3b>(y, x);
      worst.at<float>(y, x) = free.at<unsigned char>(y, x) ? float(std::max({d[0], d[1], d[2]})) : 0.0f;
    }
  free.convertTo(weight, CV_32F, 1.0 / 255);
  const int side = std::max(5, picture.cols / 6 | 1);
  cv::boxFilter(worst, error, -1, {side, side});
  cv::boxFilter(weight, count, -1, {side, side});
  const double usual = cv::sum(worst)[0] / std::max(1.0, cv::sum(weight)[0]);
  constexpr float kPrior = 0.1f;  // weight of the whole picture's error, as a share of a window
  error = (error + kPrior * usual) / (count + kPrior);
  cv::Mat grey, dx, dy, gradient;
  cv::cvtColor(room, grey, cv::COLOR_RGB2GRAY);
  cv::Sobel(grey, dx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(grey, dy, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::magnitude(dx, dy, gradient);
  plate.noise = cv::max(0.5 * error, 2.0f) + 0.5f * gradient;
  return plate;
}

void complete_plate(Plate& plate, const cv::Mat& room) {
  const cv::Mat seen = plate.known == kSeen;
  // Half the difference about the middle grey, so that eight bits hold it.
  cv::Mat difference;
  cv::addWeighted(plate.colour, 0.5, room, -0.5, 128, difference);
  const cv::Mat offset = fill_holes(difference, seen);
  cv::Mat shown(room.size(), CV_8UC3);
  for (int y = 0; y < room.rows; ++y)
    for (int x = 0; x < room.cols; ++x)
      for (int c = 0; c < 3; ++c)
        shown.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<unsigned char>(
            int(room.at<cv::Vec3b>(y, x)[c]) + 2 * (int(offset.at<cv::Vec3b>(y, x)[c]) - 128));
  const Plate behind = room_plate(plate.colour, room, seen, 255 - seen);
  shown.copyTo(plate.colour, behind.known);
  behind.noise.copyTo(plate.noise, behind.known);
  behind.known.copyTo(plate.known, behind.known);
}

cv::Mat still_texture(const std::vector<cv::Mat>& pictures) {
  // Spread over time against contrast in space, of the grey values.
  cv::Mat sum, squares;
  for (const auto& picture : pictures) {
    cv::Mat grey, value;
    cv::cvtColor(picture, grey, cv::COLOR_RGB2GRAY);
    grey.convertTo(value, CV_32F);
    if (sum.empty()) sum = cv::Mat(value.size(), CV_32F, cv::Scalar(0)), squares = sum.clone();
    cv::accumulate(value, sum);
    cv::accumulateSquare(value, squares);
  }
  const double count = double(pictures.size());
  const cv::Mat mean = sum / count;
  const cv::Mat variance = cv::max(squares / count - mean.mul(mean), 0.0);
  cv::Mat dx, dy, local_contrast, local_variance;
  cv::Sobel(mean, dx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(mean, dy, CV_32F, 0, 1, 3, 1.0 / 8);
  const int window = texture_window(mean);
  const cv::Mat contrast = dx.mul(dx) + dy.mul(dy);
  cv::boxFilter(contrast, local_contrast, -1, {window, window});
  cv::boxFilter(variance, local_variance, -1, {window, window});
  cv::Mat still(mean.size(), CV_32F);
  for (int y = 0; y < still.rows; ++y)
    for (int x = 0; x < still.cols; ++x)
      still.at<float>(y, x) = stillness(local_contrast.at<float>(y, x), local_variance.at<float>(y, x));
  return still;
}

}  // namespace likeness
