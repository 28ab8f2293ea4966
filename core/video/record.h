// A clip recorded in place, from a webcam or whatever else gives pictures one after the other.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

struct LivePicture {
  double time_s = 0;  // when it was taken, from any start; never falls
  Image8 rgb;
};

class PictureSource {
 public:
  virtual ~PictureSource() = default;
  // The next picture, as soon as there is one; nullopt when no more will come.
  virtual Result<std::optional<LivePicture>> next() = 0;
};

struct Webcam {
  std::string device;  // "/dev/video0"
  std::string name;    // as it calls itself
};
std::vector<Webcam> list_webcams();  // in order of their numbers; none where the system has none
// Asks for 1280 x 720 at 30 a second; the camera gives what it can.
Result<std::unique_ptr<PictureSource>> open_webcam(const std::string& device);

struct RecordOptions {
  double frames_per_second = 30;  // of the file; a picture that came late is repeated, one too many left out
  double longest_s = 180;
  int crf = 16;
};
struct Recording {
  int frames = 0;
  double seconds = 0;
  int repeated = 0, left_out = 0;
  std::optional<Error> broken_off;  // why it ended before it was asked to; what was filmed until then is kept
};
// Records until the source ends, the time is up, or `stop`, which is how a recording usually ends: the clip
// is kept. seen: every picture as it comes, to be shown; may be empty. An existing file is never
// replaced; a source that fails after its first picture leaves what it gave.
Result<Recording> record_clip(PictureSource& source, const std::filesystem::path& path,
                              const RecordOptions& options,
                              const std::function<void(const LivePicture&)>& seen, std::stop_token stop);

}  // namespace likeness
