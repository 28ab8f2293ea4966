// Inserting, moving and carrying over keys: see edit_keys.h.
#include "core/direct/edit_keys.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace likeness {
namespace {

// First key not before time_s, within kSameTime_s of it.
template <class Keys>
auto at_or_after(Keys& keys, double time_s) {
  return std::ranges::lower_bound(keys, time_s - kSameTime_s, {}, &Key::time_s);
}

template <class Iterator>
bool is_at(Iterator key, Iterator end, double time_s) {
  return key != end && std::abs(key->time_s - time_s) <= kSameTime_s;
}

std::map<std::string, std::vector<Key>> take_out(const Performance& performance,
                                                 std::span<const KeyPlace> places) {
  std::map<std::string, std::vector<Key>> taken;
  for (const KeyPlace& place : places)
    if (const Key* key = find_key(performance, place)) taken[place.channel].push_back(*key);
  for (auto& [channel, keys] : taken) {
    std::ranges::sort(keys, {}, &Key::time_s);
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  }
  return taken;
}

double earliest(const std::map<std::string, std::vector<Key>>& channels) {
  double first = kLongest_s;
  for (const auto& [channel, keys] : channels) first = std::min(first, keys.front().time_s);
  return first;
}

std::vector<KeyPlace> put_in(Performance& performance,
                             const std::map<std::string, std::vector<Key>>& channels, double by_s) {
  std::vector<KeyPlace> places;
  for (const auto& [channel, keys] : channels) {
    for (Key key : keys) {
      key.time_s = std::clamp(key.time_s + by_s, 0.0, kLongest_s);
      set_key(performance, channel, key);
      places.push_back({channel, key.time_s});
    }
  }
  return places;
}

}  // namespace

const Key* find_key(const Performance& performance, const KeyPlace& place) {
  const auto found = performance.channels.find(place.channel);
  if (found == performance.channels.end()) return nullptr;
  const auto key = at_or_after(found->second, place.time_s);
  return is_at(key, found->second.end(), place.time_s) ? &*key : nullptr;
}

std::vector<KeyPlace> all_keys(const Performance& performance) {
  std::vector<KeyPlace> places;
  for (const auto& [channel, keys] : performance.channels)
    for (const Key& key : keys) places.push_back({channel, key.time_s});
  return places;
}

void set_key(Performance& performance, const std::string& channel, const Key& key) {
  LIKENESS_CHECK(is_channel(channel), "no channel: %s", channel.c_str());
  LIKENESS_CHECK(key.time_s >= 0 && std::isfinite(key.value), "key at %g s of %g", key.time_s,
                 double(key.value));
  std::vector<Key>& keys = performance.channels[channel];
  // Two keys may lie less than twice kSameTime_s apart, and the new one between them: both are its time.
  const auto first = at_or_after(keys, key.time_s);
  auto last = first;
  while (is_at(last, keys.end(), key.time_s)) ++last;
  keys.insert(keys.erase(first, last), key);
}

void erase_keys(Performance& performance, std::span<const KeyPlace> places) {
  for (const KeyPlace& place : places) {
    const auto found = performance.channels.find(place.channel);
    if (found == performance.channels.end()) continue;
    std::vector<Key>& keys = found->second;
    const auto key = at_or_after(keys, place.time_s);
    if (is_at(key, keys.end(), place.time_s)) keys.erase(key);
    if (keys.empty()) performance.channels.erase(found);
  }
}

std::vector<KeyPlace> move_keys(Performance& performance, std::span<const KeyPlace> places, double by_s) {
  const auto moved = take_out(performance, places);
  if (moved.empty()) return {};
  erase_keys(performance, places);
  return put_in(performance, moved, std::max(by_s, -earliest(moved)));
}

void set_easing(Performance& performance, std::span<const KeyPlace> places, Easing easing) {
  for (const KeyPlace& place : places) {
    const Key* found = find_key(performance, place);
    if (!found) continue;
    Key key = *found;
    key.easing = easing;
    set_key(performance, place.channel, key);
  }
}

KeyClip copy_keys(const Performance& performance, std::span<const KeyPlace> places) {
  KeyClip clip{take_out(performance, places)};
  const double start = earliest(clip.channels);
  for (auto& [channel, keys] : clip.channels)
    for (Key& key : keys) key.time_s -= start;
  return clip;
}

std::vector<KeyPlace> paste_keys(Performance& performance, const KeyClip& clip, double at_s) {
  const auto places = put_in(performance, clip.channels, at_s);
  for (const KeyPlace& place : places)
    performance.duration_s = std::max(performance.duration_s, place.time_s);
  return places;
}

void lay_over(Performance& performance, const Performance& take, double at_s) {
  if (at_s >= kLongest_s) return;
  const double frame_s = 1 / performance.frames_per_second;
  const double end_s = std::min(at_s + take.duration_s, kLongest_s);
  performance.duration_s = std::max(performance.duration_s, end_s);
  std::map<std::string, std::vector<Key>> laid;
  for (const auto& [channel, keys] : performance.channels) {
    if (channel.starts_with("camera ")) continue;
    const float rest = rest_value(channel);
    std::vector<Key>& out = laid[channel];
    // Existing keys hold up to the take's edges; within it, channels that the take does not have are at rest.
    for (const Key& key : keys)
      if (key.time_s < at_s - frame_s) out.push_back(key);
    if (at_s > frame_s) out.push_back({at_s - frame_s, value_at(keys, at_s - frame_s, rest), Easing::linear});
    if (!take.channels.contains(channel))
      out.push_back({at_s, rest, Easing::hold}), out.push_back({end_s, rest, Easing::linear});
  }
  for (const auto& [channel, keys] : take.channels) {
    std::vector<Key>& out = laid[channel];
    if (out.empty() && at_s > frame_s) out.push_back({at_s - frame_s, rest_value(channel), Easing::linear});
    for (Key key : keys) {
      key.time_s = std::min(key.time_s + at_s, kLongest_s);
      if (out.empty() || key.time_s > out.back().time_s + 2 * kSameTime_s) out.push_back(key);
    }
    // The last key holds to the take's end.
    if (!out.empty() && out.back().time_s < end_s - frame_s)
      out.push_back({end_s, out.back().value, Easing::linear});
  }
  for (auto& entry : laid) {
    const std::string& channel = entry.first;
    std::vector<Key>& out = entry.second;
    if (out.empty()) continue;  // a take's channel without keys
    const auto before = performance.channels.find(channel);
    const float rest = rest_value(channel);
    const double after_s = end_s + frame_s;
    const auto add = [&](const Key& key) {
      if (key.time_s <= kLongest_s && key.time_s > out.back().time_s + 2 * kSameTime_s) out.push_back(key);
    };
    add({after_s, before == performance.channels.end() ? rest : value_at(before->second, after_s, rest)});
    if (before != performance.channels.end())
      for (const Key& key : before->second)
        if (key.time_s > after_s) add(key);
    performance.channels[channel] = std::move(out);
  }
}

std::string linked_channel(std::string_view channel) {
  if (!channel.starts_with(kActionChannel)) return {};
  std::string partner(channel);
  if (partner.ends_with("_L")) {
    partner.back() = 'R';
  } else if (partner.ends_with("_R")) {
    partner.back() = 'L';
  } else {
    return {};
  }
  if (const std::size_t in = partner.find("eyeLookIn"); in != std::string::npos) {
    partner.replace(in, 9, "eyeLookOut");
  } else if (const std::size_t out = partner.find("eyeLookOut"); out != std::string::npos) {
    partner.replace(out, 10, "eyeLookIn");
  }
  return partner;
}

}  // namespace likeness
