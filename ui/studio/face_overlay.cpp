// See face_overlay.h.
#include "ui/studio/face_overlay.h"

#include <algorithm>
#include <utility>

#include "core/project/project_views.h"

namespace likeness::ui {

std::shared_ptr<const FaceOverlay> FaceOverlay::make(std::shared_ptr<const ProjectContents> contents) {
  if (!contents || !contents->capture || !contents->cameras || !contents->track || !contents->model ||
      !check_track_fits(*contents->track, *contents->model))
    return nullptr;
  auto made = std::make_shared<FaceOverlay>();
  const Capture& capture = *contents->capture;
  const SquareCrop& crop = capture.crop;
  const double scale = double(capture.size) / std::max(1, crop.side);
  made->track_ = *contents->track;
  for (TrackedFrame& frame : made->track_.frames)
    for (std::size_t i = 0; i < frame.landmarks.size(); ++i) {
      if (frame.landmarks[i] != Vec2d::Zero())
        frame.landmarks[i] = (frame.landmarks[i] - Vec2d(crop.x, crop.y)) * scale;
      frame.landmark_spread[i] *= scale;
    }
  made->cameras_ = *contents->cameras;
  for (Camera& camera : made->cameras_.cameras)
    camera.intrinsics = crop_intrinsics(camera.intrinsics, crop.x, crop.y, crop.side, capture.size);
  made->overlay_ = std::make_unique<TrackOverlay>(made->track_, *contents->model, made->cameras_,
                                                  OverlayOptions{.longer_side = 768});
  made->contents_ = std::move(contents);
  return made;
}

Image8 FaceOverlay::draw(const Image8& rgb, int frame) const {
  const TrackedFrame* tracked = find_tracked(track_, frame);
  if (!tracked) return rgb;
  const Image8 drawn = overlay_->draw(rgb, *tracked);
  return crop(drawn, 0, 0, drawn.width, drawn.width * rgb.height / rgb.width);  // without its line of text
}

}  // namespace likeness::ui
