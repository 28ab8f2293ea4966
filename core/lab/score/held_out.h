// The frames that training never saw, beside the avatar that is to be judged by them.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/image/image.h"
#include "core/matte/plate_file.h"
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

// Where a frame is scored. One channel at the picture's size, 255 inside.
struct Regions {
  Image8 person, head, face;
};

// The picture of a frame, as far as it was filmed: nothing else is scored.
Result<Image8> read_truth(const Project& project, const Capture& capture, int frame);
// The same part of FOLDER/000360.png, in source pixels: red person, green head, blue face.
Result<Regions> read_regions(const std::filesystem::path& folder, const Capture& capture, int frame);

}  // namespace likeness
