// Words and groups: see channel_words.h.
#include "ui/studio/channel_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <numbers>

#include "core/holds/hold_words.h"

namespace likeness::ui {

namespace {

struct GroupRule {
  const char* words;
  std::array<const char*, 2> prefixes;
};
constexpr GroupRule kGroups[] = {{"Mouth", {"mouth", "tongue"}},
                                 {"Jaw", {"jaw", nullptr}},
                                 {"Brows", {"brow", nullptr}},
                                 {"Eyes", {"eye", nullptr}},
                                 {"Cheeks and nose", {"cheek", "nose"}}};

struct PoseChannel {
  const char *channel, *words;
  ChannelScale scale;
};
constexpr PoseChannel kPose[] = {
    {"head yaw", "Turn", {-kTurnLimit_deg, kTurnLimit_deg, "%.0f\u00b0"}},
    {"head pitch", "Nod", {-kTurnLimit_deg, kTurnLimit_deg, "%.0f\u00b0"}},
    {"head roll", "Tilt", {-kTurnLimit_deg, kTurnLimit_deg, "%.0f\u00b0"}},
    {"head x", "Move aside", {-0.1f, 0.1f, "%.2f m"}},
    {"head y", "Move up", {-0.1f, 0.1f, "%.2f m"}},
    {"head z", "Move forward", {-0.1f, 0.1f, "%.2f m"}},
    {"gaze yaw", "Look aside", {-kGazeLimit_deg, kGazeLimit_deg, "%.0f\u00b0"}},
    {"gaze pitch", "Look up", {-kGazeLimit_deg, kGazeLimit_deg, "%.0f\u00b0"}},
    {"camera yaw", "Orbit", {-kOrbitLimit_deg, kOrbitLimit_deg, "%.0f\u00b0"}},
    {"camera pitch", "Height", {-kOrbitPitchLimit_deg, kOrbitPitchLimit_deg, "%.0f\u00b0"}},
    {"camera distance", "Distance", {0.5f, 2, "%.2f"}},
    {"camera zoom", "Zoom", {0.5f, 4, "%.2f"}},
    {"camera shift x", "Shift aside", {-1, 1, "%.2f"}},
    {"camera shift y", "Shift down", {-1, 1, "%.2f"}}};

const PoseChannel* find_pose_channel(std::string_view channel) {
  const auto found = std::ranges::find(kPose, channel, &PoseChannel::channel);
  return found == std::end(kPose) ? nullptr : &*found;
}

bool belongs(std::string_view name, const GroupRule& rule) {
  return std::ranges::any_of(rule.prefixes, [&](const char* p) { return p && name.starts_with(p); });
}

std::string capitalised(std::string words) {
  if (!words.empty()) words[0] = char(std::toupper(static_cast<unsigned char>(words[0])));
  return words;
}

ChannelGroup pose_group(const char* words, std::string_view prefix) {
  ChannelGroup group{words, {}};
  for (const PoseChannel& channel : kPose)
    if (std::string_view(channel.channel).starts_with(prefix)) group.channels.emplace_back(channel.channel);
  return group;
}

}  // namespace

std::string action_words(std::string_view name) {
  std::string words, side;
  if (name.ends_with("_L")) side = ", left";
  if (name.ends_with("_R")) side = ", right";
  if (!side.empty()) name.remove_suffix(2);
  for (const char c : name) {
    if (std::isupper(static_cast<unsigned char>(c)) && !words.empty()) words += ' ';
    words += char(std::tolower(static_cast<unsigned char>(c)));
  }
  return capitalised(words) + side;
}

std::string channel_words(std::string_view channel) {
  if (channel.starts_with(kActionChannel)) return action_words(channel.substr(kActionChannel.size()));
  const PoseChannel* known = find_pose_channel(channel);
  return known ? known->words : std::string(channel);
}

std::string words_within(const ChannelGroup& group, std::string_view channel) {
  const std::string words = channel_words(channel), first = words.substr(0, words.find(' '));
  const bool repeats = group.words == first || group.words == first + "s";  // "Mouth", "Brows"
  if (!repeats || first == words || !channel.starts_with(kActionChannel)) return words;
  return capitalised(words.substr(first.size() + 1));
}

std::string preset_words(const Preset& preset) { return capitalised(preset.name); }

ChannelScale channel_scale(std::string_view channel) {
  const PoseChannel* known = find_pose_channel(channel);
  return known ? known->scale : ChannelScale{};
}

std::vector<ChannelGroup> group_channels(const HeadModel& model,
                                         std::span<const AttributeRegion> attributes) {
  std::vector<ChannelGroup> groups{pose_group("Head", "head "), pose_group("Gaze", "gaze ")};
  std::vector<bool> taken(model.actions.size());
  const auto take = [&](ChannelGroup group, const auto& wanted) {
    for (std::size_t a = 0; a < model.actions.size(); ++a) {
      const std::string& name = model.actions[a].name;
      if (taken[a] || name.starts_with("eyeLook") || !wanted(name)) continue;
      taken[a] = true;
      group.channels.push_back(action_channel(name));
    }
    if (!group.channels.empty()) groups.push_back(std::move(group));
  };
  for (const GroupRule& rule : kGroups)
    take({rule.words, {}}, [&](const std::string& name) { return belongs(name, rule); });
  take({"Other", {}}, [](const std::string&) { return true; });
  if (!attributes.empty()) {
    ChannelGroup& painted = groups.emplace_back(ChannelGroup{"Painted", {}});
    for (const AttributeRegion& region : attributes) painted.channels.push_back(action_channel(region.name));
  }
  groups.push_back(pose_group("Camera", "camera "));
  return groups;
}

std::vector<std::string> beyond_words(const BeyondSeen& beyond) {
  std::vector<std::string> words;
  const double deg = beyond.view * 180 / std::numbers::pi;
  if (deg > kViewMargin_deg && beyond.checked) {
    words.push_back(fmt::format("The avatar does not hold this far: {:.0f}\u00b0 less would.", deg));
    if (!beyond.sides.empty())
      words.back() += " To film: " + std::string(film_again_side(beyond.sides.front()));
  } else if (deg > kViewMargin_deg) {
    words.push_back(
        fmt::format("The head is seen {:.0f}\u00b0 from the nearest view the clip showed: details there are "
                    "guessed.",
                    deg));
  }
  std::string actions;
  for (const std::string& name : beyond.actions)
    actions += (actions.empty() ? "" : ", ") + action_words(name);
  if (actions.empty()) return words;
  if (!beyond.checked) {
    words.push_back("Further than the clip showed: " + actions + ".");
    return words;
  }
  std::string first = beyond.actions.front();
  if (first.ends_with("_L") || first.ends_with("_R")) first.resize(first.size() - 2);
  words.push_back("Further than the avatar holds: " + actions + ". To film: " + film_again_action(first));
  return words;
}

}  // namespace likeness::ui
