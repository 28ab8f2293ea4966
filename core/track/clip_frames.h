// One pass over the video: the grey working pictures and the main person's landmarks of every frame.
//
// A training frame's result depends on training frames only, so that held-out pictures leak nowhere.
#pragma once

#include <filesystem>
#include <memory>
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
  int shot = 0;                        // index of TrackOptions::shots; -1: in none, no face is sought
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

struct VideoInfo;
struct VideoFrame;

// The same, fed by another's decoding: of every frame that it reads, RGB, in order.
class ClipFollower {
 public:
  static Result<ClipFollower> create(const VideoInfo& info, const std::filesystem::path& video,
                                     const TrackRegion& region, const std::set<int>& held_out,
                                     const TrackOptions& options);
  ~ClipFollower();
  ClipFollower(ClipFollower&&) noexcept;
  ClipFollower& operator=(ClipFollower&&) noexcept;

  void add(const VideoFrame& frame, const std::stop_token& stop);
  // The working picture of the frame just added, which then is not among finish()'s.
  Image8 take_grey();
  // Once all frames have been added.
  Result<ClipFrames> finish(const std::stop_token& stop);
  const ClipFrames& so_far() const;  // landmarks follow some frames later

 private:
  struct State;
  explicit ClipFollower(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// The grey working pictures of the frames first..last (numbers in the source) alone, without
// looking for faces.
Result<ClipFrames> read_grey_frames(const std::filesystem::path& video, const TrackRegion& region,
                                    const std::set<int>& held_out, const TrackOptions& options, int first,
                                    int last, const Progress& progress, std::stop_token stop);

}  // namespace likeness
