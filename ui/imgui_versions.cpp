// By version where a thing is done in another way, by what is there where only its name changed: see imgui_versions.h.
#include "ui/imgui_versions.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui_internal.h>

#include <cstdint>

namespace likeness::ui {

static_assert(kKeys == GLFW_KEY_LAST + 1);

#if IMGUI_VERSION_NUM < 18700

void give_keys(const Keys& keys) {
  ImGuiIO& io = ImGui::GetIO();
  for (int key = 0; key < kKeys; ++key) io.KeysDown[key] = keys.down[std::size_t(key)];
  io.KeyCtrl = keys.ctrl, io.KeyShift = keys.shift, io.KeyAlt = keys.alt;
  if (io.NavVisible && !io.WantTextInput && !io.KeyCtrl &&
      (keys.down[GLFW_KEY_ENTER] || keys.down[GLFW_KEY_KP_ENTER]))
    io.NavInputs[ImGuiNavInput_Activate] = 1;
}

void give_mouse(const Mouse& mouse, const std::string& typed) {
  ImGuiIO& io = ImGui::GetIO();
  io.MousePos = {mouse.x, mouse.y};
  for (std::size_t b = 0; b < 3; ++b) io.MouseDown[b] = mouse.down[b];
  io.MouseWheel = mouse.wheel;
  io.AddInputCharactersUTF8(typed.c_str());
}

void leave_input_to_backend() {}

void keep_keys_free() { ImGui::GetIO().KeyMap[ImGuiKey_Tab] = -1; }

bool key_pressed(int key, bool repeat) { return key >= 0 && ImGui::IsKeyPressed(key, repeat); }

ImGuiID focus_scope() { return ImGui::GetCurrentWindow()->DC.NavFocusScopeIdCurrent; }

#else

namespace {

// ImGui's key in that place of the keyboard; ImGuiKey_None: it has none.
ImGuiKey imgui_key(int key) {
  const auto after = [&](ImGuiKey first, int from) { return ImGuiKey(int(first) + key - from); };
  if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z) return after(ImGuiKey_A, GLFW_KEY_A);
  if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9) return after(ImGuiKey_0, GLFW_KEY_0);
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12) return after(ImGuiKey_F1, GLFW_KEY_F1);
  if (key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_9) return after(ImGuiKey_Keypad0, GLFW_KEY_KP_0);
  switch (key) {
    // One that ImGui does nothing with: with Tab itself it would go to the next field that is typed in.
    case GLFW_KEY_TAB: return ImGuiKey_ScrollLock;
    case GLFW_KEY_LEFT: return ImGuiKey_LeftArrow;
    case GLFW_KEY_RIGHT: return ImGuiKey_RightArrow;
    case GLFW_KEY_UP: return ImGuiKey_UpArrow;
    case GLFW_KEY_DOWN: return ImGuiKey_DownArrow;
    case GLFW_KEY_PAGE_UP: return ImGuiKey_PageUp;
    case GLFW_KEY_PAGE_DOWN: return ImGuiKey_PageDown;
    case GLFW_KEY_HOME: return ImGuiKey_Home;
    case GLFW_KEY_END: return ImGuiKey_End;
    case GLFW_KEY_INSERT: return ImGuiKey_Insert;
    case GLFW_KEY_DELETE: return ImGuiKey_Delete;
    case GLFW_KEY_BACKSPACE: return ImGuiKey_Backspace;
    case GLFW_KEY_SPACE: return ImGuiKey_Space;
    case GLFW_KEY_ENTER: return ImGuiKey_Enter;
    case GLFW_KEY_ESCAPE: return ImGuiKey_Escape;
    case GLFW_KEY_APOSTROPHE: return ImGuiKey_Apostrophe;
    case GLFW_KEY_COMMA: return ImGuiKey_Comma;
    case GLFW_KEY_MINUS: return ImGuiKey_Minus;
    case GLFW_KEY_PERIOD: return ImGuiKey_Period;
    case GLFW_KEY_SLASH: return ImGuiKey_Slash;
    case GLFW_KEY_SEMICOLON: return ImGuiKey_Semicolon;
    case GLFW_KEY_EQUAL: return ImGuiKey_Equal;
    case GLFW_KEY_LEFT_BRACKET: return ImGuiKey_LeftBracket;
    case GLFW_KEY_BACKSLASH: return ImGuiKey_Backslash;
    case GLFW_KEY_RIGHT_BRACKET: return ImGuiKey_RightBracket;
    case GLFW_KEY_GRAVE_ACCENT: return ImGuiKey_GraveAccent;
    case GLFW_KEY_KP_ADD: return ImGuiKey_KeypadAdd;
    case GLFW_KEY_KP_SUBTRACT: return ImGuiKey_KeypadSubtract;
    case GLFW_KEY_KP_MULTIPLY: return ImGuiKey_KeypadMultiply;
    case GLFW_KEY_KP_DIVIDE: return ImGuiKey_KeypadDivide;
    case GLFW_KEY_KP_DECIMAL: return ImGuiKey_KeypadDecimal;
    case GLFW_KEY_KP_ENTER: return ImGuiKey_KeypadEnter;
    case GLFW_KEY_LEFT_ALT: return ImGuiKey_LeftAlt;
    case GLFW_KEY_RIGHT_ALT: return ImGuiKey_RightAlt;
    default: return ImGuiKey_None;
  }
}

}  // namespace

void give_keys(const Keys& keys) {
  ImGuiIO& io = ImGui::GetIO();
  io.AddKeyEvent(ImGuiMod_Ctrl, keys.ctrl);
  io.AddKeyEvent(ImGuiMod_Shift, keys.shift);
  io.AddKeyEvent(ImGuiMod_Alt, keys.alt);
  for (int key = 0; key < kKeys; ++key)
    if (const ImGuiKey own = imgui_key(key); own != ImGuiKey_None)
      io.AddKeyEvent(own, keys.down[std::size_t(key)]);
}

void give_mouse(const Mouse& mouse, const std::string& typed) {
  ImGuiIO& io = ImGui::GetIO();
  io.ConfigInputTrickleEventQueue = false;
  io.AddMousePosEvent(mouse.x, mouse.y);
  for (std::size_t b = 0; b < 3; ++b) io.AddMouseButtonEvent(int(b), mouse.down[b]);
  if (mouse.wheel != 0) io.AddMouseWheelEvent(0, mouse.wheel);
  io.AddInputCharactersUTF8(typed.c_str());
}

void leave_input_to_backend() { ImGui::GetIO().ConfigInputTrickleEventQueue = true; }

void keep_keys_free() {
  ImGuiContext& g = *ImGui::GetCurrentContext();
  g.ConfigNavWindowingKeyNext = g.ConfigNavWindowingKeyPrev = 0;
}

bool key_pressed(int key, bool repeat) {
  const ImGuiKey own = imgui_key(key);
  return own != ImGuiKey_None && ImGui::IsKeyPressed(own, repeat);
}

ImGuiID focus_scope() { return ImGui::GetCurrentContext()->CurrentFocusScopeId; }

#endif

namespace {

template <typename Item>
int flags_of(const Item& item) {
  if constexpr (requires { item.ItemFlags; }) {
    return item.ItemFlags;
  } else {
    return item.InFlags;
  }
}

template <typename Context>
void show_place(Context& g) {
  if constexpr (requires { g.NavCursorVisible; }) {
    g.NavCursorVisible = true;
    g.NavHighlightItemUnderNav = true;
  } else {
    g.NavDisableHighlight = false;
    g.NavDisableMouseHover = true;
  }
}

}  // namespace

int last_item_flags() { return flags_of(ImGui::GetCurrentContext()->LastItemData); }

void show_keyboard_place() { show_place(*ImGui::GetCurrentContext()); }

void draw_keyboard_place() {
  const ImGuiLastItemData& last = ImGui::GetCurrentContext()->LastItemData;
#if IMGUI_VERSION_NUM < 19140
  ImGui::RenderNavHighlight(last.Rect, last.ID);
#else
  ImGui::RenderNavCursor(last.Rect, last.ID);
#endif
}

// A pointer before 1.91.4, a number since.
ImTextureID texture_id(unsigned gl_texture) { return (ImTextureID)(std::uintptr_t(gl_texture)); }

}  // namespace likeness::ui
