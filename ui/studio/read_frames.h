// Pictures of the open project's frames, read in the background into a session's own places. A place must
// live until the background has ended; what arrives after another frame or project was asked for is dropped.
#pragma once

#include <memory>
#include <string>

#include "ui/studio/face_overlay.h"
#include "ui/studio/frame_picture.h"
#include "ui/studio/session_context.h"

namespace likeness::ui {

// A frame that the import kept. key: of the background's work, one for each place. overlay: drawn on it;
// null: the frame as it is.
void read_frame(const SessionContext& context, const std::string& key, int frame,
                std::shared_ptr<const FaceOverlay> overlay, FramePicture& into);
// The first picture of the clip itself; where it cannot be read, FramePicture::missing says why and what to
// do.
void read_clip_start(const SessionContext& context, FramePicture& into);

}  // namespace likeness::ui
