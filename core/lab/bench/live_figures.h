// Driving live, measured: a file fed at its own pace, every driven frame rendered, newest first, as the
// studio does it, but without a window.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/drive/live_tracker.h"
#include "core/render/pose_avatar.h"

namespace likeness {

struct LiveFigures {
  double seconds = 0;                              // from the first driven picture to the last
  int captured = 0, dropped = 0;                   // pictures of the clip, all of it
  int driven = 0, lost = 0;                        // after the rest was learnt; of those, with no face
  int shown = 0;                                   // rendered
  double frames_per_second = 0;                    // rendered
  double latency_median_s = 0, latency_p95_s = 0;  // from capture to the rendered picture
  double render_median_s = 0;                      // of one picture, its pose included
};

struct LiveStudyOptions {
  LiveTrackOptions track;
  RenderQuality quality = RenderQuality::preview;
};

// model: the avatar's. Takes as long as the clip.
Result<LiveFigures> measure_live(const Avatar& avatar, const HeadModel& model,
                                 const std::filesystem::path& clip, const LiveStudyOptions& options,
                                 const Progress& progress, std::stop_token stop);

}  // namespace likeness
