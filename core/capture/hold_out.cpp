// See hold_out.h.
#include "core/capture/hold_out.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace likeness {
namespace {

std::size_t count_of(std::size_t frames, double share) {
  if (frames == 0 || share <= 0) return 0;
  return std::clamp<std::size_t>(std::size_t(std::lround(share * double(frames))), 1, frames);
}

// Spreads the bits of a number (the finaliser of splitmix64).
std::uint64_t scrambled(std::uint64_t v) {
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}

}  // namespace

void hold_out_tail(std::vector<CaptureFrame>& frames, double share) {
  const std::size_t count = count_of(frames.size(), share);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].held_out = i + count >= frames.size();
}

void hold_out_views(std::vector<CaptureFrame>& frames, const FrameSpan& moving, double share) {
  std::vector<CaptureFrame*> inside;
  for (CaptureFrame& frame : frames) {
    frame.held_out = false;
    if (frame.frame >= moving.first && frame.frame <= moving.last) inside.push_back(&frame);
  }
  const std::size_t count = count_of(inside.size(), share);
  const std::size_t begin = (inside.size() - count) / 2;
  for (std::size_t i = begin; i < begin + count; ++i) inside[i]->held_out = true;
}

void hold_out_sides(std::vector<CaptureFrame>& frames, const SideRange& sides, double share) {
  std::vector<CaptureFrame*> inside;
  for (CaptureFrame& frame : frames) {
    frame.held_out = frame.apart = false;
    frame.refused.clear();
    const double off_deg = frame.view ? angle_deg(*frame.view) : 0;
    if (frame.view && off_deg <= sides.inside_deg) {
      inside.push_back(&frame);
    } else if (frame.view && off_deg > sides.beyond_deg) {
      frame.held_out = true;
    } else {
      frame.apart = true;
      frame.refused = frame.view ? "Seen from between the sides that train and those that are held out."
                                 : "From which side it sees the head is not known.";
    }
  }
  const std::size_t count = count_of(inside.size(), share);
  for (std::size_t i = inside.size() - count; i < inside.size(); ++i) inside[i]->held_out = true;
}

void hold_out_random(std::vector<CaptureFrame>& frames, double share) {
  std::vector<std::size_t> order(frames.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [](std::size_t i) { return scrambled(i + 0x9e3779b97f4a7c15ull); });
  const std::size_t count = count_of(frames.size(), share);
  for (std::size_t i = 0; i < order.size(); ++i) frames[order[i]].held_out = i < count;
}

}  // namespace likeness
