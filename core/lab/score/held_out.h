// The frames that training never saw, beside the avatar that is to be judged by them.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/image/image.h"
#include "core/matte/plate_file.h"
#include "core/matte/read_regions.h"
#include "core/project/project.h"
#include "core/render/avatar.h"
#include "core/scene/track.h"

namespace likeness {

struct HeldOutSet {
  Capture capture;
  CameraSet cameras;
  Track track;
  Avatar avatar;
  PlateInfo plate_info;
};

// An Error where nothing was trained, or where a later import or fit made the avatar one of other pictures.
Result<HeldOutSet> read_held_out(const Project& project);

// The avatar's plate behind a frame as its camera sees it; empty where it is not known.
Image8 plate_behind(const HeldOutSet& set, int frame, const Camera& camera);

// What the exposure of a held-out frame makes of the avatar's (core/train/exposure.h), told from the frame's
// own background: what was evened out before training is given back before a picture is scored. Ones where
// the avatar learnt the frames as filmed, and where the background says nothing. truth: of read_truth.
Result<Vec3f> held_out_exposure(const Project& project, const HeldOutSet& set, int frame,
                                const Camera& camera, const Image8& truth);

// The picture of a frame, as far as it was filmed: nothing else is scored.
Result<Image8> read_truth(const Project& project, const Capture& capture, int frame);

}  // namespace likeness
