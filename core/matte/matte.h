// Who is person and who is background: a coarse mask before the cameras, then alpha mattes, the plate and the
// frozen evaluation regions after the track.
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
// frame.
// in_sequence: asked about the pictures of a clip in their order; a face that the detector doubts counts
// where it was a moment ago, and one that it misses is still there.
enum class Pictures { in_sequence, single };
Result<PersonMask> coarse_person_mask(const std::filesystem::path& predictor = {},
                                      Pictures pictures = Pictures::in_sequence);

// Where the person is in a training frame of a moving camera, with a margin.
struct RoughMatte {
  int frame = 0;
  Image8 alpha;  // one channel, at `size`
};
// What a moving camera would see of the room in a frame if nobody were there: 8-bit RGB at `size`; empty
// where the frame has no camera. Safe from several threads.
using RoomBehind = std::function<Image8(int frame)>;
// Learns the room from what mattes leave of their pictures: first, quickly, from generous guesses, so that it
// helps to cut the person out; then, as well as it can be shown, from those cuts. An empty function: nothing
// can be said.
enum class RoomPass { first, last };
using LearnRoom = std::function<Result<RoomBehind>(const std::vector<RoughMatte>& mattes, RoomPass pass,
                                                   const Progress& progress, std::stop_token stop)>;

struct MatteOptions {
  int size = 256;
  // Asked twice where a camera moves; its pictures then take the plate's part there. Empty: mattes of a
  // moving camera go by colour and place alone.
  LearnRoom learn_room;
  // A matting or parsing network (core/matte/matting_network.h) that is asked about every frame; empty: none.
  std::filesystem::path network;
  // What somebody painted: hard constraints of their own frame's cut and alpha. Those of training frames also
  // say what may teach the plate; those of held-out frames teach nothing. Without any, nothing changes.
  FrameStrokes strokes;
};

struct MatteResult {
  bool has_plate = false;         // static camera: the background behind the person
  double plate_coverage = 0;      // share of the plate's pixels seen unoccluded in some training frame
  std::vector<int> plate_frames;  // frames whose background the plate is: all of a static camera, the longest
                                  // rest of a camera that moves and then rests; ascending
  std::vector<std::string> warnings;
};

// What plate.json beside plate.png says. A missing file means no plate.
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
