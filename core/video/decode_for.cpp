// Frames handed to several listeners: see decode_for.h.
#include "core/video/decode_for.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/parallel.h"

namespace likeness {

VideoPixels pixels_for(std::span<const FrameListener> listeners) {
  const auto wanted = [&](VideoPixels pixels) {
    return std::ranges::any_of(listeners, [&](const FrameListener& each) { return each.pixels == pixels; });
  };
  if (!wanted(VideoPixels::luma)) return VideoPixels::rgb;
  return wanted(VideoPixels::rgb) ? VideoPixels::both : VideoPixels::luma;
}

Result<void> decode_for(VideoReader& reader, std::span<const FrameListener> listeners, std::stop_token stop) {
  std::vector<Result<void>> results(listeners.size());
  while (true) {
    if (stop.stop_requested()) return cancelled_error();
    auto next = reader.next();
    if (!next) return next.error();
    if (!next->has_value()) return {};
    VideoFrame& frame = **next;
    VideoFrame luma;  // as a reader of luma would give it
    if (!frame.luma.empty()) luma = {frame.index, frame.time_s, std::move(frame.luma), {}, {}, frame.shape};
    parallel_for(listeners.size(), [&](std::size_t i) {
      const bool own_luma = listeners[i].pixels == VideoPixels::luma && !luma.rgb.empty();
      results[i] = listeners[i].look(own_luma ? luma : frame);
    });
    for (const Result<void>& result : results)
      if (!result) return result.error();
  }
}

}  // namespace likeness
