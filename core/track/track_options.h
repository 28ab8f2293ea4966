// Options of the tracker, and the region of a clip's pictures that it uses.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/frame_span.h"
#include "core/head/head_model.h"
#include "core/track/stage_clock.h"

namespace likeness {

class KeptWork;         // core/base/kept_work.h
struct WithheldPoints;  // core/track/points/withheld_points.h

struct TrackOptions {
  int working_size = 512;    // px, the longer side of the region tracked; raising it costs time quadratically
  bool every_frame = false;  // also of fast and long clips, of which otherwise some are tracked
                             // (core/video/decode.h: sampled)
  bool own_shape = false;    // the person's own surface on top of the identity: a truer face at rest, no
                             // clearly better pictures so far; not of a person who is given
  // Known from another clip, so that both have one head frame, or from elsewhere (core/head/read_person.h):
  // held to the last bit.
  std::optional<PersonShape> person;
  std::vector<int> rest_frames;  // that show the person's resting face, by the user's word; empty: found
  bool photometric = true;       // pose, jaw and expression refined on the pictures, after the dense fit
  bool gaze = true;              // measure where the eyes look; off: straight ahead
  bool dense = true;             // point tracks and bundle adjustment after the landmark fit
  // Of a film that was cut: the shots that are tracked, with one identity, neutral and cloud of points, but
  // nothing passed from a frame of one to a frame of another. What lies outside is lost, and costs no time.
  // Empty: the whole clip is one.
  std::vector<FrameSpan> shots{};
  std::optional<FrameSpan> part{};  // of the clip that is read: the track has no other frames; empty: all
  std::filesystem::path predictor;  // landmark model: as landmark_source takes it
  // Where import kept what its decoding showed for this (core/track/kept_frames.h); empty: nowhere. Changes
  // no result.
  std::filesystem::path kept{};
  // Where the work itself is kept until the track is done, for it to go on if it is killed; null: nowhere.
  // Changes no result.
  std::shared_ptr<KeptWork> kept_work{};
  std::shared_ptr<WithheldPoints> withheld;  // for studies: takes point tracks away from the dense step
  std::shared_ptr<std::vector<StageSeconds>> seconds;  // receives the time of each stage, or null
};

// What of the source picture to track: a rectangle in source pixels.
struct TrackRegion {
  int x = 0, y = 0, width = 0, height = 0;
};

}  // namespace likeness
