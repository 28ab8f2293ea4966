// What is person and what is background: alpha mattes, the plate and the frozen evaluation regions, after the
// track.
#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/head/head_model.h"
#include "core/matte/matte_result.h"
#include "core/matte/room_behind.h"
#include "core/matte/strokes.h"
#include "core/scene/track.h"

namespace likeness {

class KeptWork;  // core/base/kept_work.h
class PersonNetwork;

struct MatteOptions {
  int size = 256;
  // Called twice if the camera moves; its pictures then serve as the plate there. Empty: mattes of a moving
  // camera use only colour and place.
  LearnRoom learn_room;
  // A matting or parsing network (core/matte/matting_network.h) that is run on every frame; empty: none.
  std::filesystem::path network;
  // The person network (core/matte/person_network.h), the prior of every frame's cut; null: none. Not asked
  // where there is a `network`.
  std::shared_ptr<const PersonNetwork> person_network;
  // What the user painted: hard constraints on their own frame's cut and alpha. Those of training frames also
  // decide what the plate is learnt from; nothing is learnt from those of held-out frames.
  FrameStrokes strokes;
  // Where the work is kept until it is done, for it to go on if it is killed; null: nowhere. Changes no
  // result.
  std::shared_ptr<KeptWork> kept;
};

// What was not filmed of the pictures (Capture::inside) is unknown: 0 in the mattes and in plate_known.
//
// Reads frames/NNNNNN.png of `folder`, writes masks/NNNNNN.png (alpha, 8 bit) and, where the camera rests for
// a second or longer, plate.png with plate.json and plate_known.png (core/matte/plate.h: known), all size x
// size in the crop; regions/NNNNNN.png for the held-out frames in source pixels (red person, green head
// without neck, blue face), unless regions already exist; matte_report.json. The
// plate uses training frames only. A room that does not show the background (core/matte/matte_report.h) has
// still helped to cut the person out, as far as it agrees with the pictures; it is for learn_room's caller
// not to show it.
Result<MatteResult> matte_clip(const std::filesystem::path& folder, const Capture& capture,
                               const CameraSet& cameras, const Track& track, const HeadModel& model,
                               const MatteOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness
