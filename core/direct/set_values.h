// Setting the values of channels, as sliders, presets and a pasted pose do.
//
// A channel with two or more keys is animated: a value set at a time becomes a key there. Any other channel
// is constant, and stays so unless the value is to be recorded: then it becomes a key at that time, and the
// previous value stays until then.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "core/direct/performance.h"

namespace likeness {

struct ValueEdit {
  double time_s = 0;    // >= 0
  bool record = false;  // constant channels become animated
  bool linked = false;  // the channel of the face's other side does the same
};

bool is_animated(const Performance& performance, const std::string& channel);

// A key within half a frame of the time is changed; its easing stays. A constant at rest needs no key.
void set_value(Performance& performance, const std::string& channel, float value, const ValueEdit& edit);

enum class ChannelPart { head, face, camera };  // face: actions and gaze
ChannelPart part_of(std::string_view channel);
// Sets every channel of a part to rest.
void set_to_rest(Performance& performance, ChannelPart part, const ValueEdit& edit);

// Head and face at a time, by channel; those at rest are left out.
using PoseValues = std::map<std::string, float>;
PoseValues pose_at(const Performance& performance, double time_s);
// Sets head and face as copied; their other channels rest.
void set_pose(Performance& performance, const PoseValues& pose, const ValueEdit& edit);

// Adds keys at a time to every channel that has any: the pose there stays, whatever changes around it.
void hold_pose(Performance& performance, double time_s);

}  // namespace likeness
