// FFmpeg's objects held by unique_ptr, and its error texts: shared by decoding and encoding.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/error.h>
#include <libavutil/frame.h>
}

#include <cstdint>
#include <string>

namespace likeness {

struct FreeCodec {
  void operator()(AVCodecContext* c) const { avcodec_free_context(&c); }
};
struct FreePacket {
  void operator()(AVPacket* p) const { av_packet_free(&p); }
};
struct FreeFrame {
  void operator()(AVFrame* f) const { av_frame_free(&f); }
};

// The index first, so that a film plays while it still loads; tags under any key.
inline constexpr const char* kMovFlags = "+faststart+use_metadata_tags";

// Bytes of a decoded frame as it lies in memory.
inline std::uint64_t frame_bytes(const AVFrame& frame) {
  std::uint64_t bytes = 0;
  for (const AVBufferRef* buffer : frame.buf)
    if (buffer) bytes += buffer->size;
  return bytes;
}

inline std::string av_text(int error) {
  char buffer[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, buffer, sizeof buffer);
  return buffer;
}

}  // namespace likeness
