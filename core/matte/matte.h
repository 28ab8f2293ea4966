// What is person and what is background: a coarse mask before the cameras, then alpha mattes, the plate and
// the frozen evaluation regions after the track.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/align.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/matte/strokes.h"
#include "core/scene/track.h"

namespace likeness {

// Landmark-free person mask for the cameras: head ellipse and the shoulders below it, dilated. Detects per
// frame. in_sequence: called for the pictures of a clip in order; an uncertain detection counts if a face was
// there a moment ago, and a missed face is taken to be still there.
enum class Pictures { in_sequence, single };
Result<PersonMask> coarse_person_mask(const std::filesystem::path& predictor = {},
                                      Pictures pictures = Pictures::in_sequence);

// Where the person is in a training frame of a moving camera, with a margin.
struct RoughMatte {
  int frame = 0;
  Image8 alpha;  // one channel, at `size`
};
// What a moving camera would see of the room in a frame without the person: 8-bit RGB at `size`; empty where
// the frame has no camera. Safe from several threads.
using RoomBehind = std::function<Image8(int frame)>;
// Learns the room from the pictures outside the mattes: first, quickly, from generous guesses, to help cut
// the person out; then, at full quality, from those cuts. An empty function: no room is known.
enum class RoomPass { first, last };
using LearnRoom = std::function<Result<RoomBehind>(const std::vector<RoughMatte>& mattes, RoomPass pass,
                                                   const Progress& progress, std::stop_token stop)>;

struct MatteOptions {
  int size = 256;
  // Called twice if the camera moves; its pictures then serve as the plate there. Empty: mattes of a moving
  // camera use only colour and place.
  LearnRoom learn_room;
  // A matting or parsing network (core/matte/matting_network.h) that is run on every frame; empty: none.
  std::filesystem::path network;
  // What the user painted: hard constraints on their own frame's cut and alpha. Those of training frames also
  // decide what the plate is learnt from; nothing is learnt from those of held-out frames.
  FrameStrokes strokes;
};

struct MatteResult {
  bool has_plate = false;         // static camera: the background behind the person
  double plate_coverage = 0;      // share of the plate's pixels seen unoccluded in some training frame
  std::vector<int> plate_frames;  // frames whose background the plate shows: all of a static camera, the
                                  // longest rest of a camera that moves and then rests; ascending
  std::vector<std::string> warnings;
};

// The contents of plate.json beside plate.png. A missing file means no plate.
struct PlateInfo {
  double coverage = 0;
  std::vector<int> frames;
};
Result<void> write_plate_info(const std::filesystem::path& path, const PlateInfo& info);
Result<PlateInfo> read_plate_info(const std::filesystem::path& path);

// Reads frames/NNNNNN.png of `folder`, writes masks/NNNNNN.png (alpha, 8 bit) and, where the camera rests for
// a second or longer, plate.png with plate.json and plate_known.png (core/matte/plate.h: known), all size x
// size in the crop; regions/NNNNNN.png for the held-out frames in source pixels (red person, green head
// without neck, blue face), unless regions already exist. The plate uses training frames only.
Result<MatteResult> matte_clip(const std::filesystem::path& folder, const Capture& capture,
                               const CameraSet& cameras, const Track& track, const HeadModel& model,
                               const MatteOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness
