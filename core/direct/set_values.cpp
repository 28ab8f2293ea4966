// Keys and constants: see set_values.h.
#include "core/direct/set_values.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/direct/edit_keys.h"

namespace likeness {
namespace {

// The channel's key within half a frame of a time, or the place for a new one.
Key key_near(const std::vector<Key>& keys, double time_s, double frame_s) {
  const auto nearest =
      std::ranges::min_element(keys, {}, [&](const Key& key) { return std::abs(key.time_s - time_s); });
  if (nearest != keys.end() && std::abs(nearest->time_s - time_s) < 0.5 * frame_s) return *nearest;
  return {time_s, 0};
}

void set_one(Performance& performance, const std::string& channel, float value, const ValueEdit& edit) {
  const bool course = is_animated(performance, channel);
  const auto found = performance.channels.find(channel);
  const float rest = rest_value(channel);
  if (!course && !edit.record) {
    performance.channels.erase(channel);
    if (value != rest) set_key(performance, channel, {0, value});
    return;
  }
  const double frame_s = 1 / performance.frames_per_second;
  Key key{edit.time_s, value};
  if (found != performance.channels.end()) {
    key = key_near(found->second, edit.time_s, frame_s);
    key.value = value;
  } else if (edit.time_s >= 0.5 * frame_s) {
    if (value == rest) return;
    set_key(performance, channel, {0, rest});  // the start keeps its value
  }
  set_key(performance, channel, key);
}

std::vector<std::string> channels_of(const Performance& performance, ChannelPart part) {
  std::vector<std::string> names;
  for (const auto& [channel, keys] : performance.channels)
    if (part_of(channel) == part) names.push_back(channel);
  return names;
}

}  // namespace

bool is_animated(const Performance& performance, const std::string& channel) {
  const auto found = performance.channels.find(channel);
  return found != performance.channels.end() && found->second.size() > 1;
}

void set_value(Performance& performance, const std::string& channel, float value, const ValueEdit& edit) {
  set_one(performance, channel, value, edit);
  if (!edit.linked) return;
  if (const std::string partner = linked_channel(channel); !partner.empty())
    set_one(performance, partner, value, edit);
}

ChannelPart part_of(std::string_view channel) {
  return channel.starts_with("head ")     ? ChannelPart::head
         : channel.starts_with("camera ") ? ChannelPart::camera
                                          : ChannelPart::face;
}

void set_to_rest(Performance& performance, ChannelPart part, const ValueEdit& edit) {
  for (const std::string& channel : channels_of(performance, part))
    set_one(performance, channel, rest_value(channel), edit);
}

PoseValues pose_at(const Performance& performance, double time_s) {
  PoseValues pose;
  for (const auto& [channel, keys] : performance.channels) {
    const float rest = rest_value(channel), value = value_at(keys, time_s, rest);
    if (part_of(channel) != ChannelPart::camera && value != rest) pose[channel] = value;
  }
  return pose;
}

void set_pose(Performance& performance, const PoseValues& pose, const ValueEdit& edit) {
  for (const ChannelPart part : {ChannelPart::head, ChannelPart::face})
    for (const std::string& channel : channels_of(performance, part))
      if (!pose.contains(channel)) set_one(performance, channel, rest_value(channel), edit);
  for (const auto& [channel, value] : pose) set_one(performance, channel, value, edit);
}

void hold_pose(Performance& performance, double time_s) {
  std::vector<std::pair<std::string, Key>> held;
  for (const auto& [channel, keys] : performance.channels) {
    Key key = key_near(keys, time_s, 1 / performance.frames_per_second);
    key.value = value_at(keys, key.time_s, rest_value(channel));
    held.emplace_back(channel, key);
  }
  for (const auto& [channel, key] : held) set_key(performance, channel, key);
}

}  // namespace likeness
