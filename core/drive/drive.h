// Carrying a performance over from one person's track to another person's avatar.
//
// What is carried over is the difference from each person's own rest: expression and jaw through named
// actions, gaze as eyeball turns, the head's motion relative to its typical pose about the neck. The driver
// at rest gives the avatar at rest; nothing of the driver's looks is copied.
#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/drive/drive_options.h"
#include "core/drive/drive_subject.h"
#include "core/drive/driven_frame.h"
#include "core/scene/track.h"

namespace likeness {

// One frame per frame of the track. Fails on an unknown action in `gains`, a track without a usable frame, or
// a track made with a model other than the driver's.
Result<std::vector<DrivenFrame>> drive(const Track& track, const DriveSubject& driver,
                                       const DriveSubject& avatar, const DriveOptions& options);

}  // namespace likeness
