// Random keys: see random_walk.h.
#include "core/direct/random_walk.h"

#include <algorithm>
#include <random>

#include "core/base/hash.h"
#include "core/direct/edit_keys.h"
#include "core/direct/set_values.h"

namespace likeness {
namespace {

// Even a head filmed from all around must not turn like an owl's. Degrees to either side.
constexpr float kTurnMost[] = {25, 15, 12};
constexpr double kBusy = 0.2;  // share of an action's steps in which it is not at rest

// One per channel, so that adding or removing a channel changes none of the others. Standard distributions
// differ between libraries, the engine does not.
class Chance {
 public:
  Chance(std::uint64_t seed, const std::string& channel)
      : engine_(seed ^ std::stoull(hash_text(channel).substr(0, 16), nullptr, 16)) {}
  double next() { return double(engine_() >> 11) * 0x1p-53; }  // [0, 1)

 private:
  std::mt19937_64 engine_;
};

bool turns_head(const std::string& channel) {
  return std::ranges::find(kPoseChannels, kPoseChannels + 3, channel) != kPoseChannels + 3;
}

ValueRange walk_range(const std::string& channel, ValueRange range, float strength) {
  for (int axis = 0; axis < 3; ++axis)
    if (channel == kPoseChannels[axis])
      range = {std::max(range.low, -kTurnMost[axis]), std::min(range.high, kTurnMost[axis])};
  return {range.low * strength, range.high * strength};
}

}  // namespace

Performance random_walk(const std::map<std::string, ValueRange>& limits, const WalkOptions& options) {
  Performance walk;
  walk.duration_s = options.duration_s;
  walk.frames_per_second = options.frames_per_second;
  for (const auto& [channel, seen] : limits) {
    const bool action = channel.starts_with(kActionChannel);
    if (!action && !turns_head(channel)) continue;
    const ValueRange range = walk_range(channel, seen, options.strength);
    if (range.high - range.low < 1e-3f) continue;
    // Both sides draw the same numbers: those of the one that comes first in the alphabet.
    const std::string partner = linked_channel(channel);
    Chance chance(options.seed, partner.empty() ? channel : std::min(channel, partner));
    set_key(walk, channel, {0, 0});
    double t = 0;
    while (true) {
      t += options.pace_s * (0.5 + chance.next());
      const double busy = chance.next(), way = chance.next();
      if (t >= options.duration_s - 0.5 * options.pace_s) break;
      // Actions are one-sided: what is seen below rest is a by-product of others.
      const float value = action ? (busy < kBusy ? float(way) * range.high : 0)
                                 : range.low + float(way) * (range.high - range.low);
      set_key(walk, channel, {t, value});
    }
    set_key(walk, channel, {options.duration_s, 0});
  }
  return walk;
}

void set_walk(Performance& performance, const std::map<std::string, ValueRange>& limits, std::uint64_t seed) {
  std::erase_if(performance.channels,
                [](const auto& channel) { return part_of(channel.first) != ChannelPart::camera; });
  Performance walk = random_walk(limits, {.seed = seed,
                                          .duration_s = performance.duration_s,
                                          .frames_per_second = performance.frames_per_second});
  performance.channels.merge(walk.channels);
}

}  // namespace likeness
