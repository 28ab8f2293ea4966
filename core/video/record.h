// A clip recorded in place, from a webcam or whatever else gives pictures one after the other.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "core/base/result.h"
#include "core/video/frame_source.h"

namespace likeness {

struct RecordOptions {
  double frames_per_second = 30;  // of the file; a picture that came late is repeated, one too many left out
  double longest_s = 180;
  int crf = 16;
};
struct Recording {
  int frames = 0;
  double seconds = 0;
  int repeated = 0, left_out = 0;
  std::optional<Error>
      interruption;  // why it ended before it was asked to; what was filmed until then is kept
};
// Records until the source ends, the time is up, or `stop`, which is how a recording usually ends: the clip
// is kept. seen: every picture as it comes, to be shown; may be empty. An existing file is never
// replaced; a source that fails after its first picture leaves what it gave.
Result<Recording> record_clip(FrameSource& source, const std::filesystem::path& path,
                              const RecordOptions& options,
                              const std::function<void(const CapturedFrame&)>& seen, std::stop_token stop);

}  // namespace likeness
