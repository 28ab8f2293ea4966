// The splits' names: see split.h.
#include "core/capture/split.h"

#include <algorithm>
#include <cstddef>

namespace likeness {
namespace {

constexpr std::array<std::string_view, kSplits.size()> kNames{"tail", "views", "random30", "sides"};

}  // namespace

std::string_view split_name(Split split) { return kNames[std::size_t(split)]; }

std::optional<Split> split_named(std::string_view name) {
  const auto at = std::ranges::find(kNames, name);
  if (at == kNames.end()) return std::nullopt;
  return kSplits[std::size_t(at - kNames.begin())];
}

}  // namespace likeness
