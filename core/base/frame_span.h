// Stretches of a film by the numbers of its frames: of several, none overlaps another and all ascend.
#pragma once

#include <cstddef>
#include <vector>

namespace likeness {

// Frames first..last (numbers in the source).
struct FrameSpan {
  int first = 0, last = 0;
  bool operator==(const FrameSpan&) const = default;
};

// Which of the spans holds the frame; -1: none. Without any span the whole film is one: 0.
inline int span_of(const std::vector<FrameSpan>& spans, int frame) {
  if (spans.empty()) return 0;
  for (std::size_t i = 0; i < spans.size(); ++i)
    if (frame >= spans[i].first && frame <= spans[i].last) return int(i);
  return -1;
}

}  // namespace likeness
