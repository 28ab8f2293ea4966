// Names and parts of the modes.
#include "core/train/mode.h"

#include <algorithm>

namespace likeness {
namespace {

constexpr std::array<std::string_view, kFieldModes.size()> kNames{"static", "concat", "hyper", "warp",
                                                                  "warp+hyper"};

}  // namespace

ModeParts mode_parts(FieldMode mode) {
  return {.expression = mode != FieldMode::static_,
          .ambient = mode == FieldMode::hyper || mode == FieldMode::warp_hyper,
          .warp = mode == FieldMode::warp || mode == FieldMode::warp_hyper};
}

std::string_view mode_name(FieldMode mode) { return kNames[std::size_t(mode)]; }

std::optional<FieldMode> mode_named(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return kFieldModes[std::size_t(found - kNames.begin())];
}

FieldMode mode_of(const Avatar& avatar) {
  const FieldConfig& config = avatar.head.field.config;
  const bool warp = avatar.warp_cell > 0;
  if (config.condition_count == config.local_conditions) return warp ? FieldMode::warp : FieldMode::static_;
  if (config.ambient) return warp ? FieldMode::warp_hyper : FieldMode::hyper;
  return warp ? FieldMode::warp : FieldMode::concat;
}

}  // namespace likeness
