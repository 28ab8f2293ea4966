// The matte stage's look back at what it learnt of the background: whether the plate, or the room, shows what
// the frames show beside the person, and whether the plate is that of a camera which did what it was taken
// for. Internal to the stage (matte.cpp).
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/matte/learn_background.h"
#include "core/matte/matte_frames.h"
#include "core/matte/matte_report.h"

namespace likeness::matting {

// Pictures of a background, compared one after the other.
class BackgroundMeter {
 public:
  // picture, behind: 8UC3 of one size; free: 8U, not 0 where only background is seen. One with hardly any of
  // it is left out.
  void add(const cv::Mat& picture, const cv::Mat& behind, const cv::Mat& free);
  void add(const BackgroundMeter& other);
  BackgroundFit fit(bool held_out) const;

 private:
  int frames_ = 0;
  double psnr_db_ = 0, constant_db_ = 0;  // sums
};

// The plate, and the room, each beside at most a few dozen held-out frames that have it behind them, or
// training frames where there are none. cuts: of every job, at cut_size.
Result<void> judge_background(const Stage& stage, const std::vector<Job>& jobs,
                              const std::vector<cv::Mat>& cuts, const Statistics& statistics,
                              MatteReport& report);

// Whether more than a small part of a frame's background differs from the plate, whatever the frame's light,
// by more than noise and a pixel's shift can make. free: where the plate is known and the person is far.
// nullopt: too little of it to say.
std::optional<bool> differs_from_plate(const cv::Mat& picture, const cv::Mat& plate, const cv::Mat& free);

// That of at most a hundred frames before the plate.
Result<PlateLookBack> look_back_at_plate(const Stage& stage, const std::vector<Job>& jobs,
                                         const std::vector<cv::Mat>& cuts, const Statistics& statistics);

}  // namespace likeness::matting
