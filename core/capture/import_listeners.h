// Who else looks at a clip while import decodes it, so that it need not be decoded again for them.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/video/decode_for.h"

namespace likeness {

// All are optional. An Error from any of them ends the import.
struct ImportListeners {
  // Of all frames, while import looks for the face in them. Asked again where bars were found in them: then
  // the frames, and the info, are of the film within (source px; empty: of the whole picture).
  std::function<Result<std::vector<FrameListener>>(const VideoInfo&, const PixelRect& film)> looking;
  // Asked once, after those, with stretches_that_serve of the clip: instead of ImportOptions::moving.
  std::function<Result<std::optional<FrameSpan>>(const std::vector<FrameSpan>&)> moving;
  // Of all frames once more, while import writes their pictures. The capture is complete but for frames/.
  std::function<Result<std::vector<FrameListener>>(const VideoInfo&, const Capture&)> writing;
};

}  // namespace likeness
