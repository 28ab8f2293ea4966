// Plate, hull and colour statistics from samples of the training frames, alternating cuts and learning.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/matte/matte_frames.h"
#include "core/matte/segment.h"

namespace likeness::matting {

struct Statistics {
  Plate plate, small_plate;
  ColourModel upper, lower;  // colours above and below the neck's base
  PersonHull hull;           // empty before the first cut
  cv::Mat still;             // cut_size, empty without a plate that is the frames' own picture
  bool has_plate = false;
};

Result<Statistics> learn_in_rounds(const Stage& stage, const std::vector<Job>& jobs,
                                   const Progress& progress);

// A frame's person at the cut's size. room: of the frame, empty where it is not known.
cv::Mat cut(const Stage& stage, const Job& job, const cv::Mat& small, const PersonPrior& prior,
            const Plate& room, const cv::Mat& network, const Statistics& statistics);

}  // namespace likeness::matting
