// Actions, presets and poses: see acting.h.
#include "ui/acting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "core/direct/edit_keys.h"
#include "core/render/camera_path.h"

namespace likeness::ui {

namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kBeyond_deg = 4;
constexpr float kBeyond = 0.15f;  // of an action, before it counts as beyond what was seen

struct GroupRule {
  const char* words;
  std::array<const char*, 4> prefixes;
};
constexpr GroupRule kGroups[] = {{"Mouth", {"mouth", "tongue", nullptr, nullptr}},
                                 {"Jaw", {"jaw", nullptr, nullptr, nullptr}},
                                 {"Brows", {"brow", nullptr, nullptr, nullptr}},
                                 {"Eyes", {"eye", nullptr, nullptr, nullptr}},
                                 {"Cheeks and nose", {"cheek", "nose", nullptr, nullptr}}};

bool is_gaze(std::string_view name) { return name.starts_with("eyeLook"); }

bool belongs(std::string_view name, const GroupRule& rule) {
  return std::ranges::any_of(rule.prefixes, [&](const char* p) { return p && name.starts_with(p); });
}

void add_gaze(Articulation& articulation, const HeadModel& model, std::string_view name, double amount) {
  if (amount <= 0) return;
  if (const NamedAction* action = find_action(model, name)) add_action(articulation, *action, float(amount));
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
  if (!words.empty()) words[0] = char(std::toupper(static_cast<unsigned char>(words[0])));
  return words + side;
}

float amount_of(const Acting& acting, const std::string& action) {
  const auto found = acting.amounts.find(action);
  return found == acting.amounts.end() ? 0 : found->second;
}

void set_amount(Acting& acting, const std::string& action, float amount) {
  const auto set = [&](const std::string& name) {
    const float value = std::clamp(amount, 0.f, 1.f);
    if (value > 0) {
      acting.amounts[name] = value;
    } else {
      acting.amounts.erase(name);
    }
  };
  set(action);
  if (!acting.linked) return;
  if (const std::string other = linked_channel(action_channel(action)); !other.empty())
    set(other.substr(kActionChannel.size()));
}

std::vector<ActionGroup> group_actions(const HeadModel& model) {
  std::vector<ActionGroup> groups;
  std::vector<bool> taken(model.actions.size());
  for (const GroupRule& rule : kGroups) {
    ActionGroup group{rule.words, {}};
    for (std::size_t a = 0; a < model.actions.size(); ++a) {
      const std::string& name = model.actions[a].name;
      if (is_gaze(name)) taken[a] = true;
      if (taken[a] || !belongs(name, rule)) continue;
      taken[a] = true;
      group.actions.push_back(name);
    }
    if (!group.actions.empty()) groups.push_back(std::move(group));
  }
  ActionGroup rest{"Other", {}};
  for (std::size_t a = 0; a < model.actions.size(); ++a)
    if (!taken[a]) rest.actions.push_back(model.actions[a].name);
  if (!rest.actions.empty()) groups.push_back(std::move(rest));
  return groups;
}

const std::vector<Preset>& presets() {
  static const std::vector<Preset> kPresets{
      {"Neutral", {}},
      {"Smile",
       {{"mouthSmile_L", 0.8f}, {"mouthSmile_R", 0.8f}, {"cheekSquint_L", 0.4f}, {"cheekSquint_R", 0.4f}}},
      {"Surprise",
       {{"browInnerUp", 0.8f},
        {"browInnerUp_L", 0.8f},
        {"browInnerUp_R", 0.8f},
        {"browOuterUp_L", 0.8f},
        {"browOuterUp_R", 0.8f},
        {"eyeWide_L", 0.6f},
        {"eyeWide_R", 0.6f},
        {"jawOpen", 0.4f}}},
      {"Frown", {{"browDown_L", 0.8f}, {"browDown_R", 0.8f}, {"mouthFrown_L", 0.6f}, {"mouthFrown_R", 0.6f}}},
      {"A", {{"jawOpen", 0.6f}}},
      {"E", {{"jawOpen", 0.25f}, {"mouthStretch_L", 0.4f}, {"mouthStretch_R", 0.4f}}},
      {"I", {{"jawOpen", 0.12f}, {"mouthSmile_L", 0.4f}, {"mouthSmile_R", 0.4f}}},
      {"O", {{"jawOpen", 0.35f}, {"mouthFunnel", 0.6f}}},
      {"U", {{"jawOpen", 0.12f}, {"mouthPucker", 0.7f}}}};
  return kPresets;
}

Acting with_preset(const Acting& acting, const Preset& preset, const HeadModel& model) {
  Acting out = acting;
  out.amounts.clear();
  for (const auto& [name, amount] : preset.amounts)
    if (find_action(model, name)) out.amounts[std::string(name)] = amount;
  return out;
}

AvatarPose acting_pose(const Acting& acting, const Avatar& avatar, const AvatarRig& rig) {
  const HeadModel& model = *rig.model;
  AvatarPose pose;
  pose.world_from_head =
      turned_head(avatar.world_from_head, rig.shape.joints[kNeck].cast<double>(), acting.yaw_deg * kRadians,
                  acting.pitch_deg * kRadians, acting.roll_deg * kRadians);
  pose.world_from_torso = avatar.world_from_torso;
  pose.articulation = avatar.neutral;
  for (const auto& [name, amount] : acting.amounts)
    if (const NamedAction* action = find_action(model, name)) add_action(pose.articulation, *action, amount);
  // Looking to the subject's left turns the left eye outwards and the right one inwards.
  add_gaze(pose.articulation, model, "eyeLookOut_L", acting.gaze_side);
  add_gaze(pose.articulation, model, "eyeLookIn_R", acting.gaze_side);
  add_gaze(pose.articulation, model, "eyeLookIn_L", -acting.gaze_side);
  add_gaze(pose.articulation, model, "eyeLookOut_R", -acting.gaze_side);
  for (const char* side : {"_L", "_R"}) {
    add_gaze(pose.articulation, model, std::string("eyeLookUp") + side, acting.gaze_up);
    add_gaze(pose.articulation, model, std::string("eyeLookDown") + side, -acting.gaze_up);
  }
  return pose;
}

Camera acting_camera(const Acting& acting, const Avatar& avatar, int size) {
  const ViewPoint& view = acting.view;
  Camera camera =
      orbit_camera(avatar, avatar.world_from_head, view.yaw_deg * kRadians, view.pitch_deg * kRadians);
  Intrinsics& k = camera.intrinsics;
  const double scale = double(size) / std::max(1, k.width);
  k.fx *= scale * view.zoom, k.fy *= scale * view.zoom;
  k.cx = size * (0.5 + view.shift_x) + (k.cx * scale - 0.5 * size) * view.zoom;
  k.cy = size * (0.5 + view.shift_y) + (k.cy * scale - 0.5 * size) * view.zoom;
  k.width = k.height = size;
  return camera;
}

std::array<double, 3> relative_turn(const Avatar& avatar, const Pose& cam_from_world,
                                    const Pose& world_from_head) {
  const Eigen::Matrix3d typical = (avatar.cam_from_world * avatar.world_from_head).linear(),
                        seen = (cam_from_world * world_from_head).linear();
  const Eigen::Matrix3d turn = typical.transpose() * seen;  // Ry(yaw) Rx(pitch) Rz(roll)
  return {std::atan2(turn(0, 2), turn(2, 2)) / kRadians,
          -std::asin(std::clamp(turn(1, 2), -1.0, 1.0)) / kRadians,
          std::atan2(turn(1, 0), turn(1, 1)) / kRadians};
}

std::vector<std::string> beyond_seen(const Acting& acting, const std::vector<SeenAction>& shown,
                                     const SeenTurn& seen) {
  std::vector<std::string> words;
  // Walking round a head shows what its turning the other way shows.
  const std::array<double, 2> turn{acting.yaw_deg - acting.view.yaw_deg,
                                   acting.pitch_deg + acting.view.pitch_deg};
  double beyond = 0;
  for (std::size_t axis = 0; axis < turn.size(); ++axis)
    beyond = std::max({beyond, turn[axis] - seen.high_deg[axis], seen.low_deg[axis] - turn[axis]});
  if (beyond > kBeyond_deg)
    words.push_back(
        fmt::format("The head is seen from {:.0f}\u00b0 further aside than the clip showed it: details there "
                    "are guessed.",
                    beyond));
  std::string actions;
  for (const auto& [name, amount] : acting.amounts) {
    const auto own = std::ranges::find(shown, name, &SeenAction::name);
    if (own == shown.end() || amount <= std::max(own->high, 0.f) + kBeyond) continue;
    actions += (actions.empty() ? "" : ", ") + action_words(name);
  }
  if (!actions.empty()) words.push_back("Further than the clip showed: " + actions + ".");
  return words;
}

}  // namespace likeness::ui
