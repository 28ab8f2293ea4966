// The capture check on one page: the verdict, curves over time, the angles and expressions seen, and for each
// remark the moment that shows it and what to do.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/check/clip_measures.h"
#include "core/check/verdict.h"
#include "core/image/image.h"

namespace likeness {

// The number of the frame that shows a remark best: of the looks that show it, the one nearest the middle of
// its stretch. -1 if the clip has no looks at all.
int remark_frame(const ClipMeasures& measures, const Remark& remark);

// 1240 px wide, as high as needed. Reads the frames it shows from `video`, the measured clip.
Result<Image8> draw_check_page(const std::filesystem::path& video, const ClipMeasures& measures,
                               const CaptureVerdict& verdict, const Progress& progress, std::stop_token stop);

}  // namespace likeness
