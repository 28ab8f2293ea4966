// The built-in demo capture: a rendered person in a textured room, filmed as a user should film (first the
// camera moves and the head rests, then the camera rests and the head moves) or with the faults of a phone's
// films, with its ground truth. Embree traces it.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/synth/demo_options.h"

namespace likeness {

// Writes folder/demo.mp4, cameras_truth.json, track_truth.json and masks_truth/NNNNNN.png. track_truth.json
// is in the built-in head's terms: poses, the coefficients of the named actions performed, and the person,
// whose identity and offsets give the true neutral surface. A person's performance beyond the head's
// expressions (core/synth/personal_shape.h: a crooked smile, folds, one raised brow) is in the picture and in
// `landmarks`, the true places in the picture, but in no coefficient. With `habit` also habit_truth.json: its
// amount in every frame; and habit_truth/NNNNNN.png, the skin it moves, for the frames that show none and
// those that show the most. With a camera other than the guided one also wall_truth/NNNNNN.png: the room
// without the person, of every tenth frame and of the first of every shot. cameras_truth.json then says which
// camera it was, and with cuts, which shots there are (core/synth/demo_truth.h). With `drift` also
// drift_truth.json, a value for every frame: gains of red, green and blue on linear light, and what face and
// room are blurred by, px.
Result<void> write_demo_capture(const std::filesystem::path& folder, const DemoOptions& options,
                                const Progress& progress, std::stop_token stop);

}  // namespace likeness
