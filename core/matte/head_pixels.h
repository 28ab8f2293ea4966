// The pixels of a picture that train only the head, whatever the person wears and wherever they are.
#pragma once

#include <memory>

#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/scene/track.h"

namespace likeness {

struct PersonModel;

// Of one clip: the person is posed from its track.
class HeadPixels {
 public:
  HeadPixels(const HeadModel& model, const Track& track);
  ~HeadPixels();
  HeadPixels(const HeadPixels&) = delete;
  HeadPixels& operator=(const HeadPixels&) = delete;

  // (height, width, 1) of `picture`, whose matte is `alpha`: 255 on the head with its hair above the neck,
  // and where there is certainly no person; 0 on neck, torso and hands. All 0 if the head is outside the
  // picture. source: the frame's camera, in the cameras' own unit.
  Image8 taught(const TrackedFrame& tracked, const Camera& source, const Intrinsics& picture,
                const Image8& alpha) const;

 private:
  std::unique_ptr<PersonModel> person_;
  double metres_per_unit_;
};

}  // namespace likeness
