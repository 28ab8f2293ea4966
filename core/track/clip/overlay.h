// A track drawn over its clip, so that a person can judge it: head model, landmarks, gaze, and the verdict.
#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/scene/track.h"

namespace likeness {

struct OverlayOptions {
  int longer_side = 960;          // px of the film; small clips are enlarged, large ones reduced
  double frames_per_second = 25;  // of the film, whose frames have the clip's own times
};

// Draws tracked frames over their pictures. Lines of equal x and y of the head at rest lie on the skin, so
// that they show pose and expression alike; landmarks are green where the runs agree and red where they do
// not, with a line to where the model has them; gaze rays leave the eyeballs. The verdict stands below the
// picture.
class TrackOverlay {
 public:
  // The references must outlive the overlay.
  TrackOverlay(const Track& track, const HeadModel& model, const CameraSet& cameras,
               const OverlayOptions& options = {});
  ~TrackOverlay();
  TrackOverlay(TrackOverlay&&) noexcept;
  TrackOverlay& operator=(TrackOverlay&&) noexcept;

  // rgb: the frame's whole source picture. Higher than it by the line of text.
  Image8 draw(const Image8& rgb, const TrackedFrame& frame) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The whole clip as a film; frames the track does not know are shown as they are.
Result<void> write_overlay(const std::filesystem::path& video, const Track& track, const HeadModel& model,
                           const CameraSet& cameras, const std::filesystem::path& out,
                           const OverlayOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness
