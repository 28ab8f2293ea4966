// Usual expressions as named actions: see presets.h.
#include "core/direct/presets.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

namespace likeness {
namespace {

struct Share {
  std::string_view action;  // X* stands for X_L and X_R
  float amount;
};

constexpr Share kSmile[]{
    {"mouthSmile*", 0.8f}, {"cheekSquint*", 0.5f}, {"eyeSquint*", 0.2f}, {"mouthDimple*", 0.15f}};
constexpr Share kSurprise[]{
    {"browInnerUp*", 0.8f}, {"browOuterUp*", 0.8f}, {"eyeWide*", 0.7f}, {"jawOpen", 0.35f}};
constexpr Share kFrown[]{
    {"browDown*", 0.9f}, {"mouthFrown*", 0.6f}, {"eyeSquint*", 0.3f}, {"noseSneer*", 0.2f}};
constexpr Share kA[]{{"jawOpen", 0.7f}, {"mouthLowerDown*", 0.3f}, {"mouthUpperUp*", 0.15f}};
constexpr Share kE[]{
    {"jawOpen", 0.3f}, {"mouthStretch*", 0.4f}, {"mouthSmile*", 0.2f}, {"mouthLowerDown*", 0.3f}};
constexpr Share kI[]{
    {"jawOpen", 0.12f}, {"mouthStretch*", 0.4f}, {"mouthSmile*", 0.4f}, {"mouthUpperUp*", 0.15f}};
constexpr Share kO[]{{"jawOpen", 0.4f}, {"mouthFunnel", 0.7f}, {"mouthPucker", 0.2f}};
constexpr Share kU[]{{"jawOpen", 0.12f}, {"mouthPucker", 0.8f}, {"mouthFunnel", 0.2f}};

struct Recipe {
  const char* name;
  std::span<const Share> shares;
};
constexpr std::array<Recipe, 9> kRecipes{{{"neutral", {}},
                                          {"smile", kSmile},
                                          {"surprise", kSurprise},
                                          {"frown", kFrown},
                                          {"A", kA},
                                          {"E", kE},
                                          {"I", kI},
                                          {"O", kO},
                                          {"U", kU}}};

std::vector<std::string> names_of(std::string_view action) {
  if (!action.ends_with('*')) return {std::string(action)};
  const std::string stem(action.substr(0, action.size() - 1));
  return {stem + "_L", stem + "_R"};
}

}  // namespace

std::vector<Preset> presets(const HeadModel& model, const std::vector<SeenAction>& seen) {
  std::vector<Preset> list;
  for (const Recipe& recipe : kRecipes) {
    Preset preset{recipe.name, {}, 1};
    float wanted = 0, given = 0;
    for (const Share& share : recipe.shares) {
      for (const std::string& name : names_of(share.action)) {
        if (!find_action(model, name)) continue;
        const auto range = std::ranges::find(seen, name, &SeenAction::name);
        const float amount = range == seen.end() ? 0 : std::min(share.amount, range->high);
        preset.actions.emplace_back(name, amount);
        wanted += share.amount, given += amount;
      }
    }
    if (!recipe.shares.empty()) preset.seen = wanted > 0 ? given / wanted : 0;
    list.push_back(std::move(preset));
  }
  return list;
}

void apply_preset(Performance& performance, const Preset& preset, const ValueEdit& edit) {
  const ValueEdit alone{edit.time_s, edit.record};  // a preset names both sides itself
  std::vector<std::string> others;
  for (const auto& [channel, keys] : performance.channels)
    if (channel.starts_with(kActionChannel)) others.push_back(channel);
  for (const std::string& channel : others) {
    const auto own = std::ranges::find_if(
        preset.actions, [&](const auto& action) { return action_channel(action.first) == channel; });
    if (own == preset.actions.end()) set_value(performance, channel, 0, alone);
  }
  for (const auto& [action, amount] : preset.actions)
    set_value(performance, action_channel(action), amount, alone);
}

}  // namespace likeness
