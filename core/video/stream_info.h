// What a container says about its video stream, and what it does not say but shows. Internal to core/video,
// as frame_to_rgb.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "core/base/result.h"
#include "core/video/frame_to_rgb.h"

extern "C" {
#include <libavformat/avformat.h>
}

namespace likeness {

struct CloseFormat {
  void operator()(AVFormatContext* c) const;
};

// A damaged header may claim any size; FFmpeg itself would take gigabytes for it before the first frame
// fails.
inline constexpr std::int64_t kMaxPixels = std::int64_t(8192) * 8192;

// Opens a film's container for reading, of the kinds that phones, cameras, calls and editors write, and
// nothing that leads to other files or to the network, such as a playlist, whatever its name. FFmpeg's error,
// or 0 and more.
int open_container(AVFormatContext*& format, const std::filesystem::path& path);
// What the file is, and what to do, where it is none of these kinds; nullopt: it is one, or nothing known.
std::optional<Error> refused_container(const std::filesystem::path& path);
// The same of how its pictures are coded.
bool is_opened_codec(AVCodecID codec);

int find_stream_info(AVFormatContext& format);  // FFmpeg's error, or 0 and more

// What a player shows or plays: of the streams of this kind that `serves` takes, the first that the file
// marks as default, else the first; null: there is none. FFmpeg's own choice goes by bit rate and size. A
// cover is no picture.
AVStream* default_stream(AVFormatContext& format, AVMediaType kind,
                         const std::function<bool(const AVStream&)>& serves);
// FFmpeg's own readers of VP8 and VP9 pass over the alpha that such a stream may have.
const AVCodec* find_decoder(const AVStream& stream);
// That of a film's pictures: one that can be decoded here, if there is any.
AVStream* picture_stream(AVFormatContext& format);
Orientation orientation_of(const AVStream& stream);

// Of the stream alone, where the container says it; else the container's, which may be its sound's. 0: not
// known.
struct StreamLength {
  double seconds = 0;
  int frames = 0;
  bool own = false;  // seconds: of the stream alone
};
// rate: frames a second, where the container does not count them. Neither seconds nor frames where it claims
// more pictures than the file has room for.
StreamLength length_of(const AVFormatContext& format, const AVStream& stream, double rate);
double rate_of(const std::filesystem::path& path, AVFormatContext& format, AVStream& stream);  // frames/s

}  // namespace likeness
