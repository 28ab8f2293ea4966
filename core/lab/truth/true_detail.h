// The detail maps that a perfect estimator would give for a demo capture: how far the true face, with all
// that its person plays beyond the head model's expressions, lies off the tracked head, along its normals.
// What they bring to held-out pictures (likeness study, no-displacement) is a bound on what any maps can.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/project/project.h"

namespace likeness {

struct TrueDetailOptions {
  int person = 0;  // of `likeness demo --person`
  int side = 256;  // texels of a map
};

struct TrueDetailReport {
  int frames = 0;
  double rms_mm = 0;      // of the heights, over the face's vertices and all frames
  double varying_mm = 0;  // of what is left of them when each vertex's mean over the frames is taken out
};

// Writes out/000360.npy for every frame that is tracked. The project must be fitted to demo/demo.mp4 with the
// demo's head model, whose vertices are then the same skin on both. Maps that lie there are replaced.
Result<TrueDetailReport> write_true_detail(const Project& project, const std::filesystem::path& demo,
                                           const std::filesystem::path& out, const TrueDetailOptions& options,
                                           const Progress& progress, std::stop_token stop);

}  // namespace likeness
