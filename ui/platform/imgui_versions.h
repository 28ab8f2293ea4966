// What the versions of Dear ImGui do differently, in one place: 1.86 of Debian 12, which keeps keys under
// GLFW's numbers, and those from 1.89 on, which have keys of their own and a queue of events (Debian 13). On
// this side keys are always GLFW's.
#pragma once

#include <imgui.h>

#include <array>
#include <string>

namespace likeness::ui {

inline constexpr int kKeys = 349;  // GLFW_KEY_LAST + 1

// -- Input of a frame, between the backends' new frame and ImGui's
struct Keys {
  std::array<bool, kKeys> down{};
  bool ctrl = false, shift = false, alt = false;
};
struct Mouse {
  float x = -1, y = -1;
  std::array<bool, 3> down{};  // left, right, middle
  float wheel = 0;
};
// Tab is not ImGui's: walk_by_keyboard() goes where it leads. Where the keyboard shows its place, Enter
// presses.
void give_keys(const Keys& keys);
// All of it holds in the frame that follows, where ImGui would spread it over several.
void give_mouse(const Mouse& mouse, const std::string& typed);
// The frame that follows has what came from outside instead.
void leave_input_to_backend();
// Once, with the first context: what would take keys away that are the studio's.
void keep_keys_free();

// -- Keys, as ImGui has them: repeated while held, where that is asked for
bool key_pressed(int key, bool repeat = true);

// -- The item drawn last, and the mark of the keyboard's place
int last_item_flags();  // ImGuiItemFlags of imgui_internal.h
ImGuiID focus_scope();
void show_keyboard_place();  // and not what the mouse is over
void draw_keyboard_place();  // about the item drawn last

// -- Pictures
ImTextureID texture_id(unsigned gl_texture);

}  // namespace likeness::ui
