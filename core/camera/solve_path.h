// The path of a camera that walks: keyframes, structure from motion, the frames between, the rests.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/align.h"
#include "core/camera/motion.h"

namespace likeness {

// An Error where colmap finds no path, or one that must not be believed (core/camera/judge_solve.h); with
// `believe`, any path is taken. focal_35mm: of the lens, as the clip's file says; 0: it says nothing. work:
// as align_clip takes it.
Result<AlignResult> solve_path(const std::filesystem::path& video, const PersonMask& person,
                               const std::filesystem::path& work, const AlignOptions& options,
                               const BackgroundMotion& motion, double focal_35mm, bool believe,
                               const Progress& progress, std::stop_token stop);

}  // namespace likeness
