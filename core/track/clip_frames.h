// One pass over the video: the grey working pictures and the main person's landmarks of every frame.
//
// A training frame's result depends on training frames only, so that held-out pictures leak nowhere.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/face/landmarks.h"
#include "core/image/image.h"
#include "core/track/track_options.h"

namespace likeness {

struct ClipFrame {
  int frame = 0;
  double time_s = 0;
  bool held_out = false;
  Image8 grey;                         // (h, w, 1) of the region, longer side = working size
  bool detected = false;               // the detector itself saw the face, no neighbour helped
  bool scanned = false;                // the whole picture was searched, not only the face's surroundings
  bool rival = false;                  // another face of nearly the main person's size was found
  FaceBox box;                         // smoothed over time, source px; width 0 where there is none
  std::optional<Landmarks> landmarks;  // source px
};

struct ClipFrames {
  TrackRegion region;  // source px, clipped to the picture
  double scale = 1;    // working px per source px
  std::vector<ClipFrame> frames;
};

Result<ClipFrames> read_clip_frames(const std::filesystem::path& video, const TrackRegion& region,
                                    const std::set<int>& held_out, const TrackOptions& options,
                                    const Progress& progress, std::stop_token stop);

// The grey working pictures of the frames first..last (numbers in the source) alone: nobody is sought in
// them.
Result<ClipFrames> read_grey_frames(const std::filesystem::path& video, const TrackRegion& region,
                                    const std::set<int>& held_out, const TrackOptions& options, int first,
                                    int last, const Progress& progress, std::stop_token stop);

}  // namespace likeness
