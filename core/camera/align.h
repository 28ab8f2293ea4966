// Cameras of a clip: one static camera where nothing outside the person moves, otherwise structure from
// motion by the `colmap` program on person-masked frames.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/align_options.h"
#include "core/camera/align_result.h"

namespace likeness {

// work: folder for colmap's database and images; kept, so that an interrupted solve continues.
Result<AlignResult> align_clip(const std::filesystem::path& video, const PersonMask& person,
                               const std::filesystem::path& work, const AlignOptions& options,
                               const Progress& progress, std::stop_token stop);

// The same for a folder of photographs with no masking beyond what `person` says.
Result<AlignResult> align_photos(const std::filesystem::path& folder, const PersonMask& person,
                                 const std::filesystem::path& work, const AlignOptions& options,
                                 const Progress& progress, std::stop_token stop);

}  // namespace likeness
