// The difference in frame number between consecutive pictures of a clip. Of a clip with a high frame rate, or
// with very many frames, only every n-th is read (core/video/decode.h: sampled), and keeps its number in the
// source; in a folder of photographs, no picture follows another.
#pragma once

#include <algorithm>
#include <cmath>

namespace likeness {

// frames: anything with members `frame`, ascending, and `time_s`. The smallest difference of two numbers: 1
// if there are fewer than two frames, 0 if even those are too far apart in time to be related.
template <class Frames>
int frame_spacing(const Frames& frames) {
  constexpr double kFollows = 0.25;  // s
  int spacing = 0;
  double gap = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const int apart = frames[i].frame - frames[i - 1].frame;
    if (apart <= 0 || (spacing != 0 && apart > spacing)) continue;
    const double time = std::abs(frames[i].time_s - frames[i - 1].time_s);
    gap = apart == spacing ? std::min(gap, time) : time;  // the least: a clip may pause
    spacing = apart;
  }
  if (spacing == 0) return 1;
  return gap > kFollows ? 0 : spacing;
}

}  // namespace likeness
