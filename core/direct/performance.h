// A performance: what an artist directs, as keys on a timeline, a sparse list of them for each channel.
//
// Channels are named:
//
// - "head yaw", "head pitch", "head roll": degrees from the typical pose, about the neck's top (turned_head).
// - "head x", "head y", "head z": m from the typical place, along the typical head's axes.
// - "gaze yaw", "gaze pitch": degrees; positive to the subject's left, and up.
// - "camera yaw", "camera pitch": degrees of orbit, as orbit_camera.
// - "camera distance": times the typical distance from the head; rests at 1.
// - "camera zoom": times the typical focal length; rests at 1.
// - "camera shift x", "camera shift y": of the picture, in picture widths; positive right and down.
// - "action NAME": amount of a named action on top of rest, 1 = full.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace likeness {

// The way from a key to the next one.
enum class Easing {
  linear,
  smooth,   // a cubic through the neighbouring keys, without corners or overshoot
  hold,     // stays, then jumps
  ease_in,  // starts slowly
  ease_out  // ends slowly
};
inline constexpr const char* kEasings[] = {"linear", "smooth", "hold", "ease_in", "ease_out"};

struct Key {
  double time_s = 0;  // >= 0
  float value = 0;    // in the channel's unit
  Easing easing = Easing::smooth;
  bool operator==(const Key&) const = default;
};

inline constexpr double kSameTime_s = 1e-4;  // keys of one channel are further apart than this
inline constexpr double kLongest_s = 3600;

struct Performance {
  double duration_s = 4;  // > 0
  double frames_per_second = 25;
  std::map<std::string, std::vector<Key>> channels;  // keys ascending in time; no channel is without keys
  bool operator==(const Performance&) const = default;
};

inline constexpr std::string_view kActionChannel = "action ";
// The channels that every head has, in the order above.
inline constexpr const char* kPoseChannels[] = {
    "head yaw",        "head pitch",  "head roll",      "head x",        "head y",
    "head z",          "gaze yaw",    "gaze pitch",     "camera yaw",    "camera pitch",
    "camera distance", "camera zoom", "camera shift x", "camera shift y"};
std::string action_channel(std::string_view action);
// Of the list above, or of an action.
bool is_channel(std::string_view name);
// The value of a channel without keys.
float rest_value(std::string_view channel);

// keys: ascending. Before the first key, its value; after the last, that one's; `rest` if there are no keys.
float value_at(const std::vector<Key>& keys, double time_s, float rest);
float value_at(const Performance& performance, const std::string& channel, double time_s);

// At least 1; the first picture is at time 0.
int frame_count(const Performance& performance);

// performance.json: versioned. Reading is strict: what is unknown, missing, out of order or not a number is
// an Error that names the field. Written whole or not at all.
Result<void> write_performance(const std::filesystem::path& path, const Performance& performance);
Result<Performance> read_performance(const std::filesystem::path& path);

}  // namespace likeness
