// The head model's net and the landmarks over a frame's picture.
#pragma once

#include <memory>

#include "core/image/image.h"
#include "core/track/clip/overlay.h"
#include "ui/studio/project_contents.h"

namespace likeness::ui {

// A project's track in the terms of its cropped pictures, so that it can be drawn over them.
class FaceOverlay {
 public:
  // Null where something that it takes is absent, or the track is of another head model.
  static std::shared_ptr<const FaceOverlay> make(std::shared_ptr<const ProjectContents> contents);

  // rgb: the picture of this frame in frames/. Where the frame has no track it comes back as it is.
  Image8 draw(const Image8& rgb, int frame) const;

 private:
  std::shared_ptr<const ProjectContents> contents_;
  Track track_;
  CameraSet cameras_;
  std::unique_ptr<TrackOverlay> overlay_;
};

}  // namespace likeness::ui
