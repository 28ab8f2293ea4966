// The version number decides where a thing is done differently, the presence of a member where only its name
// changed: see imgui_versions.h.
#include "ui/platform/imgui_versions.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui_internal.h>

#include <cstdint>
#include <utility>

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

// ImGui's key for each of GLFW's; ImGuiKey_None where ImGui has no such key.
std::array<ImGuiKey, kKeys> matching_keys() {
  std::array<ImGuiKey, kKeys> keys;
  keys.fill(ImGuiKey_None);
  const auto row = [&](int first, int last, ImGuiKey to) {
    for (int key = first; key <= last; ++key) keys[std::size_t(key)] = ImGuiKey(int(to) + key - first);
  };
  row(GLFW_KEY_A, GLFW_KEY_Z, ImGuiKey_A);
  row(GLFW_KEY_0, GLFW_KEY_9, ImGuiKey_0);
  row(GLFW_KEY_F1, GLFW_KEY_F12, ImGuiKey_F1);
  row(GLFW_KEY_KP_0, GLFW_KEY_KP_9, ImGuiKey_Keypad0);
  constexpr std::pair<int, ImGuiKey> kSingle[] = {{GLFW_KEY_LEFT, ImGuiKey_LeftArrow},
                                                  {GLFW_KEY_RIGHT, ImGuiKey_RightArrow},
                                                  {GLFW_KEY_UP, ImGuiKey_UpArrow},
                                                  {GLFW_KEY_DOWN, ImGuiKey_DownArrow},
                                                  {GLFW_KEY_PAGE_UP, ImGuiKey_PageUp},
                                                  {GLFW_KEY_PAGE_DOWN, ImGuiKey_PageDown},
                                                  {GLFW_KEY_HOME, ImGuiKey_Home},
                                                  {GLFW_KEY_END, ImGuiKey_End},
                                                  {GLFW_KEY_INSERT, ImGuiKey_Insert},
                                                  {GLFW_KEY_DELETE, ImGuiKey_Delete},
                                                  {GLFW_KEY_BACKSPACE, ImGuiKey_Backspace},
                                                  {GLFW_KEY_SPACE, ImGuiKey_Space},
                                                  {GLFW_KEY_ENTER, ImGuiKey_Enter},
                                                  {GLFW_KEY_ESCAPE, ImGuiKey_Escape},
                                                  {GLFW_KEY_APOSTROPHE, ImGuiKey_Apostrophe},
                                                  {GLFW_KEY_COMMA, ImGuiKey_Comma},
                                                  {GLFW_KEY_MINUS, ImGuiKey_Minus},
                                                  {GLFW_KEY_PERIOD, ImGuiKey_Period},
                                                  {GLFW_KEY_SLASH, ImGuiKey_Slash},
                                                  {GLFW_KEY_SEMICOLON, ImGuiKey_Semicolon},
                                                  {GLFW_KEY_EQUAL, ImGuiKey_Equal},
                                                  {GLFW_KEY_LEFT_BRACKET, ImGuiKey_LeftBracket},
                                                  {GLFW_KEY_BACKSLASH, ImGuiKey_Backslash},
                                                  {GLFW_KEY_RIGHT_BRACKET, ImGuiKey_RightBracket},
                                                  {GLFW_KEY_GRAVE_ACCENT, ImGuiKey_GraveAccent},
                                                  {GLFW_KEY_KP_ADD, ImGuiKey_KeypadAdd},
                                                  {GLFW_KEY_KP_SUBTRACT, ImGuiKey_KeypadSubtract},
                                                  {GLFW_KEY_KP_MULTIPLY, ImGuiKey_KeypadMultiply},
                                                  {GLFW_KEY_KP_DIVIDE, ImGuiKey_KeypadDivide},
                                                  {GLFW_KEY_KP_DECIMAL, ImGuiKey_KeypadDecimal},
                                                  {GLFW_KEY_KP_ENTER, ImGuiKey_KeypadEnter},
                                                  {GLFW_KEY_LEFT_ALT, ImGuiKey_LeftAlt},
                                                  {GLFW_KEY_RIGHT_ALT, ImGuiKey_RightAlt}};
  for (const auto& [key, to] : kSingle) keys[std::size_t(key)] = to;
  // A key that ImGui ignores: given Tab itself, it would move to the next text field.
  keys[GLFW_KEY_TAB] = ImGuiKey_ScrollLock;
  return keys;
}

ImGuiKey imgui_key(int key) {
  static const std::array<ImGuiKey, kKeys> keys = matching_keys();
  return key >= 0 && key < kKeys ? keys[std::size_t(key)] : ImGuiKey_None;
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
