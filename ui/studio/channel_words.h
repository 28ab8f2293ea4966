// The channels of a performance as the window shows them: their words, their sliders' ranges, their groups.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/direct/beyond_seen.h"
#include "core/direct/presets.h"
#include "core/head/head_model.h"
#include "core/render/attribute.h"

namespace likeness::ui {

inline constexpr float kTurnLimit_deg = 45, kGazeLimit_deg = 30, kOrbitLimit_deg = 60,
                       kOrbitPitchLimit_deg = 35;

// "mouthSmile_L" -> "Mouth smile, left".
std::string action_words(std::string_view name);
// "head yaw" -> "Turn", "action jawOpen" -> "Jaw open".
std::string channel_words(std::string_view channel);
// "smile" -> "Smile".
std::string preset_words(const Preset& preset);

// How far a channel's slider goes, and how its value is written.
struct ChannelScale {
  float low = 0, high = 1;
  const char* format = "%.2f";
};
ChannelScale channel_scale(std::string_view channel);

// Channels that stand together. Of actions: those of one part of the face, in the model's order; gaze has
// channels of its own, so that eyeLook* is not among them.
struct ChannelGroup {
  std::string words;  // "Head", "Gaze", "Mouth", ..., "Camera"
  std::vector<std::string> channels;
};
// A channel's words under its group's heading, which need not be said again: "Smile, left" under "Mouth".
std::string words_within(const ChannelGroup& group, std::string_view channel);
// attributes: the avatar's, which come before the camera under "Painted".
std::vector<ChannelGroup> group_channels(const HeadModel& model,
                                         std::span<const AttributeRegion> attributes = {});

// What a moment asks for beyond what holds, and what to film for it; where that is not known, beyond what the
// capture showed. Empty: nothing.
std::vector<std::string> beyond_words(const BeyondSeen& beyond);

}  // namespace likeness::ui
