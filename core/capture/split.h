// The split: which frames of a capture are held out of training, to measure on.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace likeness {

// What each takes of a clip: core/capture/hold_out.h.
enum class Split {
  tail,     // the last tenth of the frames
  views,    // a run of a tenth of those filmed by a moving camera
  random30  // three tenths, at random
};
inline constexpr std::array kSplits{Split::tail, Split::views, Split::random30};

std::string_view split_name(Split split);  // tail, views, random30
std::optional<Split> split_named(std::string_view name);

}  // namespace likeness
