#include "core/track/clip/error_strip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace likeness {
namespace {

constexpr int kLeft = 76, kRight = 20, kTop = 34, kRow = 140, kGap = 44, kVerdictRow = 26,
              kBottom = 48;      // px
constexpr int kFirstInner = 17;  // the jaw line before it is less certain and would hide the rest

const cv::Scalar kText(40, 40, 40), kAxis(150, 150, 150), kRule(228, 228, 228);

void write(cv::Mat& picture, const std::string& text, int x, int y, double size = 0.45) {
  cv::putText(picture, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, size, kText, 1, cv::LINE_AA);
}

// 1, 2 or 5 times a power of ten: about `parts` steps up to `top`.
double round_step(double top, int parts) {
  const double raw = std::max(1e-9, top / parts), power = std::pow(10.0, std::floor(std::log10(raw)));
  for (double m : {1.0, 2.0, 5.0})
    if (m * power >= raw * 0.999) return m * power;
  return 10 * power;
}

cv::Scalar verdict_ink(FrameStatus status) {
  if (status == FrameStatus::good) return {60, 160, 80};
  return status == FrameStatus::weak ? cv::Scalar(230, 160, 20) : cv::Scalar(205, 45, 45);
}

// Bars over their own axis; few tall ones do not flatten the rest: the scale ends at the 98th percentile.
void draw_row(cv::Mat& picture, int top, const std::string& title, const std::vector<double>& values,
              const Track& track, int column) {
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const double tall = sorted.empty() ? 1 : sorted[(sorted.size() - 1) * 98 / 100];
  const double step = round_step(std::max(0.5, 1.15 * tall), 4);
  const double full = step * std::ceil(std::max(0.5, 1.15 * tall) / step);
  const int bottom = top + kRow, width = picture.cols - kLeft - kRight;
  write(picture, title, kLeft, top - 10);
  for (double v = 0; v <= full + 1e-9; v += step) {
    const int y = bottom - static_cast<int>(std::lround(kRow * v / full));
    cv::line(picture, {kLeft, y}, {kLeft + width, y}, v == 0 ? kAxis : kRule, 1);
    write(picture, fmt::format("{:g} px", v), 8, y + 5, 0.4);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (track.frames[i].status == FrameStatus::lost && values[i] == 0) continue;
    const int height = std::max(1, static_cast<int>(std::lround(kRow * std::min(1.0, values[i] / full))));
    const int x = kLeft + static_cast<int>(i) * column;
    cv::rectangle(picture, {x, bottom - height, column, height}, verdict_ink(track.frames[i].status),
                  cv::FILLED);
  }
}

}  // namespace

double mean_inner_spread(const TrackedFrame& frame) {
  double sum = 0;
  for (int i = kFirstInner; i < kLandmarkCount; ++i) sum += frame.landmark_spread[i];
  return sum / (kLandmarkCount - kFirstInner);
}

Image8 error_strip(const Track& track) {
  const int frames = std::max<int>(1, static_cast<int>(track.frames.size()));
  const int column = std::clamp(900 / frames, 1, 12), width = std::max(420, column * frames);
  Image8 strip(kLeft + width + kRight, kTop + 2 * (kRow + kGap) + kVerdictRow + kBottom, 3, 255);
  cv::Mat picture(strip.height, strip.width, CV_8UC3, strip.data.data());
  std::vector<double> error, spread;
  int count[3] = {};
  for (const TrackedFrame& f : track.frames) {
    error.push_back(f.inner_error_px);
    spread.push_back(mean_inner_spread(f));
    ++count[static_cast<int>(f.status)];
  }
  draw_row(picture, kTop, "head model to landmarks, mean", error, track, column);
  draw_row(picture, kTop + kRow + kGap, "spread of the landmark runs, mean", spread, track, column);
  const int top = kTop + 2 * (kRow + kGap);
  write(picture,
        fmt::format("verdict: {} good (green), {} weak (amber), {} lost (red)", count[0], count[1], count[2]),
        kLeft, top - 10);
  const double step = round_step(frames, 8);
  for (std::size_t i = 0; i < track.frames.size(); ++i)
    cv::rectangle(picture, {kLeft + static_cast<int>(i) * column, top, column, kVerdictRow},
                  verdict_ink(track.frames[i].status), cv::FILLED);
  for (double f = 0; f < frames; f += std::max(1.0, step)) {
    const int x = kLeft + static_cast<int>(f) * column;
    cv::line(picture, {x, top + kVerdictRow}, {x, top + kVerdictRow + 6}, kAxis, 1);
    const int number = track.frames.empty() ? 0 : track.frames[static_cast<std::size_t>(f)].frame;
    write(picture, fmt::format("{}", number), x, top + kVerdictRow + 20, 0.4);
  }
  write(picture, "frame of the source", kLeft, top + kVerdictRow + 40);
  return strip;
}

}  // namespace likeness
