// See withheld_points.h.
#include "core/track/points/withheld_points.h"

#include <algorithm>

#include "core/base/quantile.h"
#include "core/track/points/camera_scale.h"
#include "core/track/points/lone_point.h"

namespace likeness {
bool is_withheld(std::size_t index, double share) {
  std::uint32_t bits = std::uint32_t(index) * 2654435761u;
  bits ^= bits >> 15, bits *= 2246822519u, bits ^= bits >> 13;
  return bits < share * 4294967296.0;
}

WithheldScore score_withheld(const WithheldPoints& points, const Track& track, const CameraSet& cameras) {
  WithheldScore score;
  std::vector<double> residuals;
  for (const WithheldTrack& withheld : points.tracks) {
    std::vector<PointView> views;
    for (const WithheldObservation& o : withheld.seen) {
      const TrackedFrame* frame = find_tracked(track, o.frame);
      const Camera* camera = find_camera(cameras, o.frame);
      if (!frame || !camera || frame->status == FrameStatus::lost) continue;
      const Pose cam_from_world = metric_camera(camera->cam_from_world, track.metres_per_unit);
      views.push_back({cam_from_world * frame->pose.world_from_head, o.ray, o.focal_px});
    }
    if (views.size() < kFewestPointViews) continue;
    ++score.tracks;
    const std::vector<double> errors = foreseen_errors(views, withheld.start);
    if (errors.empty()) continue;
    ++score.on_head;
    residuals.insert(residuals.end(), errors.begin(), errors.end());
  }
  score.observations = int(residuals.size());
  score.median_px = quantile(residuals, 0.5);
  score.p90_px = quantile(std::move(residuals), 0.9);
  return score;
}

}  // namespace likeness
