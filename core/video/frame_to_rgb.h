// A decoded FFmpeg frame as upright 8-bit RGB. Internal to core/video: FFmpeg's types stay in its .cpp files.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/image/image.h"

struct AVFrame;
struct SwsContext;

namespace likeness {

// One of the eight ways a picture can lie: output pixel (x, y) shows the coded pixel whose coordinates are
// (x, y), or (y, x) if transposed, each counted from the other end if flipped.
struct Orientation {
  bool transposed = false, flip_x = false, flip_y = false;  // flips count in coded coordinates
  int clockwise_deg = 0;                                    // for the user; without mirroring
};

// From a display matrix as MP4 stores it (16.16 fixed point, row-major 3 x 3), rounded to quarter turns.
Orientation orientation_from_matrix(const std::array<int, 9>& matrix);

Image8 oriented(const Image8& coded, const Orientation& orientation);

bool has_alpha(const AVFrame& frame);  // by its pixel format

class FrameConverter {
 public:
  FrameConverter();
  ~FrameConverter();
  FrameConverter(FrameConverter&&) noexcept;
  FrameConverter& operator=(FrameConverter&&) noexcept;

  // Colour matrix and range follow the frame's tags; untagged frames count as BT.709 from 1280 x 720 up, else
  // BT.601. HLG and PQ frames are mapped to display-referred sRGB. Empty on failure. Size of the result:
  // width x height.
  Image8 to_rgb(const AVFrame& frame, int width, int height);
  // The same with alpha, straight.
  Image8 to_rgba(const AVFrame& frame, int width, int height);
  // Full-range luma, one channel; for HLG and PQ frames with the tones of to_rgb.
  Image8 to_luma(const AVFrame& frame, int width, int height);

 private:
  // Fills pixels_ with rows of stride_bytes_; false on failure.
  bool convert(const AVFrame& frame, int width, int height, int format, int bytes_per_pixel);

  std::vector<std::uint16_t> pixels_;  // of the last conversion; 16-bit words so that RGB48 is aligned
  std::size_t stride_bytes_ = 0;
  struct Free {
    void operator()(SwsContext* context) const;
  };
  std::unique_ptr<SwsContext, Free> context_;
};

}  // namespace likeness
