// Corners followed through the training frames by pyramidal Lucas-Kanade with a forward-backward check.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

struct PointTrackOptions {
  int corners = 1000;             // tracked at a time; cost is linear in it
  int top_up_every = 2;           // frames
  double corner_quality = 0.001;  // of the best corner
  double corner_distance_px = 3;
  double forward_backward_px = 0.3;
  int shortest = 12;  // frames; shorter tracks are dropped
};

struct PointObservation {
  int picture = 0;  // index of the picture
  Vec2d pixel;      // working px, pixel centres at +0.5
};

struct PointTrack {
  std::vector<PointObservation> seen;  // ascending picture
};

// An equalised picture (CLAHE) with its pyramid, ready for tracking with OpenCV.
class TrackPicture {
 public:
  TrackPicture() = default;
  explicit TrackPicture(const Image8& grey);
  struct Impl;
  const Impl* impl() const { return impl_.get(); }

 private:
  std::shared_ptr<const Impl> impl_;
};

// Where `points` of `from` are in `to`, nullopt if the forward-backward check fails. guesses: empty, or one
// per point.
std::vector<std::optional<Vec2d>> follow_points(const TrackPicture& from, const TrackPicture& to,
                                                std::span<const Vec2d> points, std::span<const Vec2d> guesses,
                                                double forward_backward_px);

std::vector<Vec2d> find_corners(const TrackPicture& picture, const Image8& mask, std::span<const Vec2d> taken,
                                int count, const PointTrackOptions& options);

// pictures: indices into `grey`, in order. mask(index): where corners may be taken and points must stay;
// empty = none. shots: of the pictures in `grey`; no point is followed from one shot to another. Empty: one.
Result<std::vector<PointTrack>> track_points(const std::vector<const Image8*>& grey,
                                             const std::vector<int>& pictures,
                                             const std::function<Image8(int)>& mask,
                                             const PointTrackOptions& options, const Progress& progress,
                                             std::stop_token stop, const std::vector<int>& shots = {});

}  // namespace likeness
