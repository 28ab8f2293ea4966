// Recording a clip from a webcam or another source of pictures.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "core/base/result.h"
#include "core/video/frame_source.h"

namespace likeness {

struct RecordOptions {
  double frames_per_second = 30;  // of the file; late pictures are replaced by repeats, surplus ones dropped,
                                  // and where none comes for more than a second, the file has none either
  double longest_s = 180;
  int crf = 16;
};
struct Recording {
  int frames = 0;
  double seconds = 0;
  int repeated = 0, left_out = 0;
  std::optional<Error> interruption;  // why it ended prematurely; what was filmed until then is kept
};
// Records until the source ends, the time is up, or `stop`, the usual end of a recording: the clip is kept.
// seen: called with every picture as it arrives, for display; may be empty. An existing file is never
// replaced; if a source fails after its first picture, what it delivered is kept.
Result<Recording> record_clip(FrameSource& source, const std::filesystem::path& path,
                              const RecordOptions& options,
                              const std::function<void(const CapturedFrame&)>& seen, std::stop_token stop);

}  // namespace likeness
