// Values between keys: see performance.h.
#include "core/direct/performance.h"

#include <algorithm>
#include <cmath>

namespace likeness {
namespace {

float slope(const Key& a, const Key& b) { return (b.value - a.value) / float(b.time_s - a.time_s); }

// Tangent at key i of the cubic through the keys: zero at both ends and at turning points, elsewhere the
// weighted harmonic mean of both slopes, which keeps the curve between its keys (Fritsch & Butland 1984).
float tangent(const std::vector<Key>& keys, std::size_t i) {
  if (i == 0 || i + 1 == keys.size()) return 0;
  const float before = slope(keys[i - 1], keys[i]), after = slope(keys[i], keys[i + 1]);
  if (before * after <= 0) return 0;
  const float left = float(keys[i].time_s - keys[i - 1].time_s);
  const float right = float(keys[i + 1].time_s - keys[i].time_s);
  return 3 * (left + right) / ((2 * right + left) / before + (right + 2 * left) / after);
}

float hermite(const std::vector<Key>& keys, std::size_t i, float u) {
  const float length = float(keys[i + 1].time_s - keys[i].time_s);
  const float u2 = u * u, u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * keys[i].value + (3 * u2 - 2 * u3) * keys[i + 1].value +
         length * ((u3 - 2 * u2 + u) * tangent(keys, i) + (u3 - u2) * tangent(keys, i + 1));
}

}  // namespace

std::string action_channel(std::string_view action) {
  return std::string(kActionChannel) + std::string(action);
}

bool is_channel(std::string_view name) {
  return std::ranges::find(kPoseChannels, name) != std::end(kPoseChannels) ||
         (name.starts_with(kActionChannel) && name.size() > kActionChannel.size());
}

float rest_value(std::string_view channel) {
  return channel == "camera distance" || channel == "camera zoom" ? 1.0f : 0.0f;
}

float value_at(const std::vector<Key>& keys, double time_s, float rest) {
  if (keys.empty()) return rest;
  const auto next = std::ranges::upper_bound(keys, time_s, {}, &Key::time_s);
  if (next == keys.begin()) return keys.front().value;
  if (next == keys.end()) return keys.back().value;
  const auto i = std::size_t(next - keys.begin()) - 1;
  const Key &from = keys[i], &to = keys[i + 1];
  const float u = float((time_s - from.time_s) / (to.time_s - from.time_s));
  switch (from.easing) {
    case Easing::linear:
      return from.value + u * (to.value - from.value);
    case Easing::smooth:
      return hermite(keys, i, u);
    case Easing::hold:
      return from.value;
    case Easing::ease_in:
      return from.value + u * u * u * (to.value - from.value);
    case Easing::ease_out:
      return to.value + (1 - u) * (1 - u) * (1 - u) * (from.value - to.value);
  }
  return from.value;
}

float value_at(const Performance& performance, const std::string& channel, double time_s) {
  const auto found = performance.channels.find(channel);
  const float rest = rest_value(channel);
  return found == performance.channels.end() ? rest : value_at(found->second, time_s, rest);
}

int frame_count(const Performance& performance) {
  return std::max(1, int(std::lround(performance.duration_s * performance.frames_per_second)));
}

}  // namespace likeness
