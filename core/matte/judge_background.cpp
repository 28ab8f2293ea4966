// See judge_background.h.
#include "core/matte/judge_background.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"

namespace likeness::matting {
namespace {

constexpr std::size_t kJudged = 32, kLookedBack = 100;  // frames, at most
constexpr double kLeastFree = 0.02;                     // of the picture, to say anything about a frame
// Of the picture's side: what lies this near to a cut may still be the person; shadows reach further.
constexpr double kMargin = 0.02, kFar = 0.1;
constexpr double kOff = 24;        // of 255: beyond noise and a codec, as core/camera/grey_plate.cpp
constexpr double kMostOff = 0.03;  // of the background; a hand that left the mask is about as much
constexpr double kPerfect_dB = 99;

double decibel(double mse) {
  return mse > 0 ? std::min(kPerfect_dB, 10 * std::log10(255.0 * 255.0 / mse)) : kPerfect_dB;
}

// 255 where nothing of the person is near, and where the picture was filmed.
cv::Mat away_from(const Stage& stage, const cv::Mat& cut, double margin) {
  const int radius = std::max(2, int(std::lround(margin * cut.cols)));
  cv::Mat person;
  cv::dilate(cut, person, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}));
  cv::Mat away = person == 0;
  if (const cv::Mat outside = unfilmed(stage, cut.cols); !outside.empty()) away.setTo(0, outside);
  return away;
}

// Evenly spread.
std::vector<std::size_t> spread(const std::vector<std::size_t>& all, std::size_t most) {
  std::vector<std::size_t> chosen;
  const std::size_t count = std::min(most, all.size());
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(all[i * all.size() / count]);
  return chosen;
}

// With every chosen job's picture at the cut's size, side by side in threads; the first fault.
template <class Use>
Result<void> with_pictures(const Stage& stage, const std::vector<Job>& jobs,
                           const std::vector<std::size_t>& chosen, Use use) {
  std::mutex mutex;
  std::optional<Error> fault;
  parallel_for(chosen.size(), [&](std::size_t i) {
    if (stage.stop.stop_requested()) return;
    const auto picture = read_frame(stage, jobs[chosen[i]].frame);
    if (picture) return use(i, reduced(*picture, stage.cut_size));
    const std::lock_guard lock(mutex);
    if (!fault) fault = picture.error();
  });
  if (stage.stop.stop_requested()) return cancelled_error();
  if (fault) return *fault;
  return {};
}

// behind(job): the picture of the background there, at the cut's size; empty: none.
template <class Behind>
Result<std::optional<BackgroundFit>> fit_behind(const Stage& stage, const std::vector<Job>& jobs,
                                                const std::vector<cv::Mat>& cuts, bool on_plate,
                                                Behind behind) {
  std::vector<std::size_t> held_out, training;
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (jobs[i].on_plate == on_plate) (jobs[i].held_out ? held_out : training).push_back(i);
  const bool has_held_out = !held_out.empty();
  const std::vector<std::size_t> chosen = spread(has_held_out ? held_out : training, kJudged);
  std::vector<BackgroundMeter> meters(chosen.size());  // added up in order, whatever the threads
  if (const auto read = with_pictures(stage, jobs, chosen,
                                      [&](std::size_t i, const cv::Mat& picture) {
                                        const cv::Mat shown = behind(jobs[chosen[i]]);
                                        if (!shown.empty())
                                          meters[i].add(picture, shown,
                                                        away_from(stage, cuts[chosen[i]], kMargin));
                                      });
      !read)
    return read.error();
  BackgroundMeter all;
  for (const BackgroundMeter& meter : meters) all.add(meter);
  return std::optional(all.fit(has_held_out));
}

}  // namespace

void BackgroundMeter::add(const cv::Mat& picture, const cv::Mat& behind, const cv::Mat& free) {
  double squares = 0, count = 0;
  std::array<double, 3> sum{}, own_squares{};
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      if (!free.at<unsigned char>(y, x)) continue;
      ++count;
      for (int c = 0; c < 3; ++c) {
        const double own = picture.at<cv::Vec3b>(y, x)[c], off = own - behind.at<cv::Vec3b>(y, x)[c];
        squares += off * off, sum[std::size_t(c)] += own, own_squares[std::size_t(c)] += own * own;
      }
    }
  if (count < kLeastFree * double(picture.total())) return;
  double spread = 0;
  for (std::size_t c = 0; c < 3; ++c) spread += own_squares[c] - sum[c] * sum[c] / count;
  ++frames_;
  psnr_db_ += decibel(squares / (3 * count));
  constant_db_ += decibel(spread / (3 * count));
}

void BackgroundMeter::add(const BackgroundMeter& other) {
  frames_ += other.frames_, psnr_db_ += other.psnr_db_, constant_db_ += other.constant_db_;
}

BackgroundFit BackgroundMeter::fit(bool held_out) const {
  const double count = std::max(1, frames_);
  return {frames_, held_out, psnr_db_ / count, constant_db_ / count};
}

Result<void> judge_background(const Stage& stage, const std::vector<Job>& jobs,
                              const std::vector<cv::Mat>& cuts, const Statistics& statistics,
                              MatteReport& report) {
  if (statistics.has_plate) {
    auto fit = fit_behind(stage, jobs, cuts, true, [&](const Job& job) {
      return plate_of_frame(stage, job, statistics.small_plate, stage.cut_size).colour;
    });
    if (!fit) return fit.error();
    report.plate = *fit, report.has_mosaic = stage.mosaic.has_value();
  }
  if (stage.room) {
    auto fit = fit_behind(stage, jobs, cuts, false, [&](const Job& job) {
      const Image8 room = stage.room(job.frame);
      return room.empty() ? cv::Mat() : reduced(view(room), stage.cut_size);
    });
    if (!fit) return fit.error();
    report.room = *fit;
  }
  return {};
}

std::optional<bool> differs_from_plate(const cv::Mat& picture, const cv::Mat& plate, const cv::Mat& free) {
  cv::Mat low, high;  // what a shift of up to a pixel can show of the plate
  const cv::Mat around = cv::Mat::ones(3, 3, CV_8U);
  cv::erode(plate, low, around);
  cv::dilate(plate, high, around);
  double own = 0, usual = 0;
  std::size_t known = 0, off = 0;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      if (!free.at<unsigned char>(y, x)) continue;
      ++known;
      for (int c = 0; c < 3; ++c)
        own += picture.at<cv::Vec3b>(y, x)[c], usual += plate.at<cv::Vec3b>(y, x)[c];
    }
  if (double(known) < kLeastFree * double(picture.total()) || usual <= 0) return std::nullopt;
  const double gain = own / usual;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      if (!free.at<unsigned char>(y, x)) continue;
      bool differs = false;
      for (int c = 0; c < 3; ++c) {
        const double value = picture.at<cv::Vec3b>(y, x)[c];
        differs |= value < gain * low.at<cv::Vec3b>(y, x)[c] - kOff ||
                   value > gain * high.at<cv::Vec3b>(y, x)[c] + kOff;
      }
      off += differs;
    }
  return double(off) > kMostOff * double(known);
}

Result<PlateLookBack> look_back_at_plate(const Stage& stage, const std::vector<Job>& jobs,
                                         const std::vector<cv::Mat>& cuts, const Statistics& statistics) {
  if (!statistics.has_plate) return PlateLookBack{};
  std::vector<std::size_t> before;
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (jobs[i].on_plate) before.push_back(i);
  const std::vector<std::size_t> chosen = spread(before, kLookedBack);
  std::atomic<int> frames = 0, differing = 0;
  if (const auto read = with_pictures(stage, jobs, chosen,
                                      [&](std::size_t i, const cv::Mat& picture) {
                                        const Plate plate = plate_of_frame(
                                            stage, jobs[chosen[i]], statistics.small_plate, stage.cut_size);
                                        const cv::Mat free =
                                            away_from(stage, cuts[chosen[i]], kFar) & (plate.known == kSeen);
                                        const auto differs = differs_from_plate(picture, plate.colour, free);
                                        frames += differs.has_value(), differing += differs.value_or(false);
                                      });
      !read)
    return read.error();
  return PlateLookBack{frames, frames > 0 ? double(differing) / frames : 0};
}

}  // namespace likeness::matting
