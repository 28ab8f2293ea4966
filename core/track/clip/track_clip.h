// The track of a clip: landmarks -> one identity and per-frame pose and expression -> dense rigid bundle
// adjustment -> identity and expression refitted -> the person's own shape where asked for, expression again
// -> pictures -> torso.
#pragma once

#include <filesystem>
#include <set>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/scene/track.h"
#include "core/track/track_options.h"

namespace likeness {

// held_out: source frames whose pictures must not influence anything shared between frames (identity,
// neutral, track points); they are tracked on their own picture against the frozen shared quantities.
Result<Track> track_clip(const std::filesystem::path& video, const TrackRegion& region,
                         const CameraSet& cameras, const std::set<int>& held_out, const HeadModel& model,
                         const TrackOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness
