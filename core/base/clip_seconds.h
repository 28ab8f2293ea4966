// The seconds of a clip that are read.
#pragma once

#include <algorithm>
#include <string>

#include <fmt/format.h>

namespace likeness {

// From from_s up to to_s, which is not in it, by the clip's own clock.
struct ClipSeconds {
  double from_s = 0;
  double to_s = 0;  // 0: to the end
  bool whole() const { return from_s <= 0 && to_s <= 0; }
  bool operator==(const ClipSeconds&) const = default;
};

// Less than half a frame of any film; clocks that count in ticks are off by as much.
inline constexpr double kSameSecond = 1e-3;

inline bool overlap(const ClipSeconds& a, const ClipSeconds& b) {
  const auto ends_before = [](const ClipSeconds& one, const ClipSeconds& other) {
    return one.to_s > 0 && one.to_s <= other.from_s + kSameSecond;
  };
  return !ends_before(a, b) && !ends_before(b, a);
}

// How many of them a clip of this length has.
inline double length_within(const ClipSeconds& seconds, double clip_s) {
  const double end_s = seconds.to_s > 0 ? std::min(seconds.to_s, clip_s) : clip_s;
  return std::max(0.0, end_s - seconds.from_s);
}

// "from 3 s to 8.5 s", "from 3 s on", "up to 8.5 s"; empty: all of them.
inline std::string seconds_words(const ClipSeconds& seconds) {
  const auto& [from_s, to_s] = seconds;
  if (seconds.whole()) return "";
  if (to_s <= 0) return fmt::format("from {:.6g} s on", from_s);
  if (from_s <= 0) return fmt::format("up to {:.6g} s", to_s);
  return fmt::format("from {:.6g} s to {:.6g} s", from_s, to_s);
}

}  // namespace likeness
