// Writing video: H.264 in mp4 (even sizes; odd ones are padded), whole or not at all.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

struct EncodeOptions {
  double frames_per_second = 25;
  int crf = 18;        // x264's constant rate factor; lower is better and larger
  bool timed = false;  // every frame has a time of its own; the last is shown for 1 / frames_per_second
  std::vector<std::pair<std::string, std::string>> tags = {};  // of the file: key and UTF-8 text
  // Written in pieces of a second, so that a kill leaves all but the last ones (finish_film.h).
  bool survives = false;
};

// Frames go to a temporary file; finish() moves it into place. If destroyed unfinished, nothing remains.
class VideoWriter {
 public:
  static Result<VideoWriter> create(const std::filesystem::path& path, int width, int height,
                                    const EncodeOptions& options = {});
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  Result<void> add(const Image8& rgb);  // width x height x 3; at the steady rate
  // Of a timed film: time_s from its start on, rising by at least 1/90000 s, which an earlier one is moved
  // to; to at most 1e7 s.
  Result<void> add(const Image8& rgb, double time_s);
  Result<void> finish();

 private:
  struct Impl;
  explicit VideoWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
