// What a container says about its video stream, and what it does not say but shows. Internal to core/video,
// as frame_to_rgb.h.
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/video/frame_to_rgb.h"

struct AVFormatContext;
struct AVStream;

namespace likeness {

struct CloseFormat {
  void operator()(AVFormatContext* c) const;
};

// A damaged header may claim any size; FFmpeg itself would take gigabytes for it before the first frame
// fails.
inline constexpr std::int64_t kMaxPixels = std::int64_t(8192) * 8192;

int find_stream_info(AVFormatContext& format);  // FFmpeg's error, or 0 and more
Orientation orientation_of(const AVStream& stream);
double rate_of(const std::filesystem::path& path, AVFormatContext& format, AVStream& stream);  // frames/s

}  // namespace likeness
