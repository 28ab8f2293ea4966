// What an artist asks of an avatar: where the head turns, what the face does, from where it is seen. Plain
// data, edited by sliders, kept in the undo history, and turned into a pose for the renderer.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/render/avatar.h"
#include "core/render/pose_avatar.h"
#include "core/track/drive.h"

namespace likeness::ui {

// From where the avatar is seen, relative to its typical camera.
struct ViewPoint {
  double yaw_deg = 0,
         pitch_deg = 0;             // of the camera about the head; positive: towards the subject's left, up
  double zoom = 1;                  // of the picture about its middle
  double shift_x = 0, shift_y = 0;  // of the picture, in picture widths; positive: right, down
  bool operator==(const ViewPoint&) const = default;
};

struct Acting {
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;  // of the head about the neck's top
  double gaze_side = 0, gaze_up = 0;     // -1..1 of the eyes' looks; positive: the subject's left, up
  std::map<std::string, float> amounts;  // of named actions without gaze, 0 none .. 1 full; absent = 0
  bool linked = true;                    // the two halves of an action move together
  ViewPoint view;
  bool operator==(const Acting&) const = default;
};

inline constexpr double kTurnLimit_deg = 45, kOrbitLimit_deg = 60, kOrbitPitchLimit_deg = 35;

// From which sides the clip showed the head: its turn before the camera, from the avatar's typical one.
struct SeenTurn {
  std::array<double, 3> low_deg{}, high_deg{};  // yaw, pitch, roll as in Acting: 2nd and 98th percentile
};
// Yaw, pitch and roll, deg, of the head in a camera, from the typical head in the typical camera.
std::array<double, 3> relative_turn(const Avatar& avatar, const Pose& cam_from_world,
                                    const Pose& world_from_head);

// "mouthSmile_L" -> "Mouth smile, left".
std::string action_words(std::string_view name);

float amount_of(const Acting& acting, const std::string& action);
// Sets an action, and its other half where the halves are linked. Clamped to 0..1.
void set_amount(Acting& acting, const std::string& action, float amount);

// Actions of one part of the face, in the model's order. Gaze (eyeLook*) is not among them.
struct ActionGroup {
  std::string words;  // "Brows", "Eyes", "Mouth", ...
  std::vector<std::string> actions;
};
std::vector<ActionGroup> group_actions(const HeadModel& model);

struct Preset {
  std::string_view words;
  std::vector<std::pair<std::string_view, float>> amounts;
};
// Neutral, Smile, Surprise, Frown and the vowels.
const std::vector<Preset>& presets();
// The face of a preset; head, gaze and view stay. Actions the model does not have are left out.
Acting with_preset(const Acting& acting, const Preset& preset, const HeadModel& model);

// Where the avatar is and what it does. Beyond what the model knows, actions are left out.
AvatarPose acting_pose(const Acting& acting, const Avatar& avatar, const AvatarRig& rig);
// The camera of the view for pictures of `size` px.
Camera acting_camera(const Acting& acting, const Avatar& avatar, int size);

// What the acting asks for beyond what the capture showed, in words; empty: nothing.
std::vector<std::string> beyond_seen(const Acting& acting, const std::vector<SeenAction>& shown,
                                     const SeenTurn& seen);

}  // namespace likeness::ui
