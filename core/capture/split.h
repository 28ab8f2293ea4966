// The split: which frames of a capture are held out of training, to measure on.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace likeness {

// What each takes of a clip: core/capture/hold_out.h.
enum class Split {
  tail,      // the last tenth of the frames
  views,     // a run of a tenth of those filmed by a moving camera
  random30,  // three tenths, at random
  sides      // all that see the head far from its typical side, and a tenth of those near it
};
inline constexpr std::array kSplits{Split::tail, Split::views, Split::random30, Split::sides};

// Of Split::sides, degrees off the typical side of the head: frames nearer than the first train, those
// farther than the second are held out, and those between are kept apart.
struct SideRange {
  double inside_deg = 10, beyond_deg = 20;
  bool operator==(const SideRange&) const = default;
};

std::string_view split_name(Split split);  // tail, views, random30, sides
std::optional<Split> split_named(std::string_view name);

}  // namespace likeness
