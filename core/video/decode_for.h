// One decoding of a clip for several who look at its frames.
#pragma once

#include <functional>
#include <span>
#include <stop_token>

#include "core/base/result.h"
#include "core/video/decode.h"

namespace likeness {

// Looks at every frame that a reader gives, in order; called by one thread at a time.
struct FrameListener {
  VideoPixels pixels = VideoPixels::rgb;                  // rgb or luma: what VideoFrame::rgb then holds
  std::function<Result<void>(const VideoFrame&)> look{};  // an Error ends the decoding
};

// What a reader has to be opened with for them.
VideoPixels pixels_for(std::span<const FrameListener> listeners);

// The rest of the reader's frames. The listeners look at a frame side by side; of several Errors the first
// listener's counts. reader: opened, or rewound, with pixels_for(listeners).
Result<void> decode_for(VideoReader& reader, std::span<const FrameListener> listeners, std::stop_token stop);

}  // namespace likeness
