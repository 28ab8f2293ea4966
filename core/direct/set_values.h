// Setting what channels are at, as sliders, presets and a pasted pose do.
//
// A channel with two keys or more has a course: a value set at a time is a key there. Any other channel is
// constant, and stays so unless the value is to be recorded: then it becomes a key at that time, and what was
// there before stays until then.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "core/direct/performance.h"

namespace likeness {

struct ValueEdit {
  double time_s = 0;    // >= 0
  bool record = false;  // constant channels become courses
  bool linked = false;  // the channel of the face's other side does the same
};

bool is_animated(const Performance& performance, const std::string& channel);

// A key within half a frame of the time is changed; its easing stays. A constant at rest needs no key.
void set_value(Performance& performance, const std::string& channel, float value, const ValueEdit& edit);

enum class ChannelPart { head, face, camera };  // face: actions and gaze
ChannelPart part_of(std::string_view channel);
// Every channel of a part that is anywhere else, to rest.
void set_to_rest(Performance& performance, ChannelPart part, const ValueEdit& edit);

// Head and face at a time, by channel; those at rest are left out.
using PoseValues = std::map<std::string, float>;
PoseValues pose_at(const Performance& performance, double time_s);
// Head and face as copied; their other channels rest.
void set_pose(Performance& performance, const PoseValues& pose, const ValueEdit& edit);

// Keys at a time of every channel that has any: what is there stays, whatever changes around it.
void hold_pose(Performance& performance, double time_s);

}  // namespace likeness
