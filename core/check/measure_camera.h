// What a clip's camera does, before anything is built: the align stage's measurements without a solve.
// Internal to the check (clip_measures.cpp).
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/align_options.h"
#include "core/camera/motion.h"
#include "core/check/clip_measures.h"
#include "core/image/pixel_rect.h"
#include "core/video/decode.h"

namespace likeness {

// film: what was filmed of the clip; empty: all of it. info: of the film.
Result<CameraMeasures> measure_camera(const std::filesystem::path& video, const PersonMask& person,
                                      const PixelRect& film, const VideoInfo& info, const Progress& progress,
                                      std::stop_token stop);

}  // namespace likeness
