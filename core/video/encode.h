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
  int crf = 18;  // x264's constant rate factor; lower is better and larger
  std::vector<std::pair<std::string, std::string>> tags = {};  // of the file: key and UTF-8 text
};

// Frames go to a temporary file; finish() moves it into place. If destroyed unfinished, nothing remains.
class VideoWriter {
 public:
  static Result<VideoWriter> create(const std::filesystem::path& path, int width, int height,
                                    const EncodeOptions& options = {});
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  Result<void> add(const Image8& rgb);  // width x height x 3
  Result<void> finish();

 private:
  struct Impl;
  explicit VideoWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
