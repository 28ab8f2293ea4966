// The head in one picture after the other, cheaply enough to keep up with a camera: landmarks found from
// where the last fit expects them, one fit with the last frames as its prior, and the gaze. No dense and no
// photometric step.
#pragma once

#include <filesystem>
#include <memory>

#include "core/base/result.h"
#include "core/drive/drive.h"
#include "core/image/image.h"

namespace likeness {

struct LiveTrackOptions {
  int working_size = 480;           // px, longer side of the picture examined
  int runs = 8;                     // of the landmark predictor; each costs about a millisecond
  int look_again = 12;              // frames between two runs of the detector
  std::filesystem::path predictor;  // landmark model: as landmark_source takes it
};

class LiveTracker {
 public:
  // model: must outlive the tracker.
  static Result<LiveTracker> create(const HeadModel& model, const LiveTrackOptions& options);
  ~LiveTracker();
  LiveTracker(LiveTracker&&) noexcept;

  // A lost frame says why. world_from_head is the head in the camera, whose lens is that of assumed_camera.
  TrackedFrame next(const Image8& rgb, double time_s, double focal_35mm = 0);

  // From here on, frames are kept for settle().
  void begin_rest();
  int rest_frames() const;
  // Learns the person's identity and rest from the frames since begin_rest(); later frames are fitted to
  // them. Takes a few tenths of a second. Fails if too few frames show a face.
  Result<DriveSubject> settle();

 private:
  struct Impl;
  explicit LiveTracker(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
