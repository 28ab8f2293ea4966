// What the matte stage writes: masks, evaluation regions, the plate.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/matte/learn_background.h"
#include "core/matte/matte_frames.h"
#include "core/matte/matte_result.h"

namespace likeness::matting {

Result<void> write_masks(const Stage& stage, const std::vector<Job>& jobs, const std::vector<cv::Mat>& cuts,
                         const Statistics& statistics, const std::filesystem::path& folder,
                         const Progress& progress);

// Whether every held-out frame has its region.
bool regions_complete(const Stage& stage);
// masks: the folder with the masks just written.
Result<void> write_regions(const Stage& stage, const std::vector<Job>& jobs,
                           const std::filesystem::path& masks, const Progress& progress);

// The plate, its seen part and plate.json; without a plate all are removed. Recorded in the result.
Result<void> write_plate(const Stage& stage, const std::vector<Job>& jobs, const Statistics& statistics,
                         MatteResult& result);

}  // namespace likeness::matting
