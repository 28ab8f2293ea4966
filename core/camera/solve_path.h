// The path of a camera that walks: keyframes, structure from motion, the frames between, the rests.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/align_options.h"
#include "core/camera/align_result.h"
#include "core/camera/motion.h"
#include "core/video/decode.h"

namespace likeness {

// An Error where colmap finds no path, or one that must not be believed (core/camera/judge_solve.h); with
// `believe`, any path is taken. info: of the clip's whole pictures. work:
// as align_clip takes it.
Result<AlignResult> solve_path(const std::filesystem::path& video, const PersonMask& person,
                               const std::filesystem::path& work, const AlignOptions& options,
                               const BackgroundMotion& motion, const VideoInfo& info, bool believe,
                               const Progress& progress, std::stop_token stop);

}  // namespace likeness
