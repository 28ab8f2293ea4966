// Live pictures, to be recorded or to drive an avatar.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

struct CapturedFrame {
  Image8 rgb;         // 3 channels
  double time_s = 0;  // since the first; never falls
  std::chrono::steady_clock::time_point captured;
  double focal_35mm = 0;  // of the lens, as recorded in a file (lens_tag.h); 0: not known
};

// Used by one thread, picture by picture.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Waits for the next picture, no longer than the source takes between two; nullopt at the end, and when
  // asked to stop. A late caller misses the pictures in between: a source never falls behind its own time.
  virtual Result<std::optional<CapturedFrame>> next(std::stop_token stop) = 0;
  virtual std::string name() const = 0;  // for the user
};

// A file at its own pace, as if filmed live.
Result<std::unique_ptr<FrameSource>> open_clip_source(const std::filesystem::path& video);

}  // namespace likeness
