// What a clip's camera does, before anything is built: the align stage's measurements without a solve.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/frame_span.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/align_options.h"
#include "core/camera/camera.h"
#include "core/camera/motion.h"
#include "core/image/pixel_rect.h"
#include "core/video/decode.h"

namespace likeness {

struct CameraMeasures {
  bool rests = false;  // kind is resting
  double motion = 0;   // length of the background's path, in 1/1000 of the width (core/camera/motion.h)
  double travel = 0;   // the same without small shaking
  Sway sway;           // what distinguishes shaking from deliberate movement
  double tracks = 0;   // background features this is based on
  // As the align stage decides it, but that no path is solved: walking is what is left where no other kind
  // explains the background, and not sure.
  CameraKind kind = CameraKind::resting;
  bool sure = true;
  std::string evidence{};  // in a sentence or two, with figures
};

// film: what was filmed of the clip; empty: all of it. info: of the film. stretches: as AlignOptions has
// them.
Result<CameraMeasures> measure_camera(const std::filesystem::path& video, const PersonMask& person,
                                      const PixelRect& film, const VideoInfo& info,
                                      const std::vector<FrameSpan>& stretches, const Progress& progress,
                                      std::stop_token stop);

}  // namespace likeness
