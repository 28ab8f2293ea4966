// By what ImGui records about its last item: see keyboard.h.
#include "ui/keyboard.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "ui/platform/imgui_versions.h"

namespace likeness::ui {

namespace {

struct Item {
  ImGuiID id = 0, scope = 0;
  ImGuiWindow* window = nullptr;
  ImRect place;  // on the screen
  bool typed = false;
};

std::vector<Item> reachable;
Item first_menu;

Item last_item() {
  const ImGuiContext& g = *ImGui::GetCurrentContext();
  const ImGuiLastItemData& last = g.LastItemData;
  return {last.ID, focus_scope(), g.CurrentWindow, last.Rect,
          (last_item_flags() & ImGuiItemFlags_Inputable) != 0};
}

void go_to(const Item& item, ImGuiNavLayer layer) {
  ImGuiContext& g = *ImGui::GetCurrentContext();
  ImGui::ClearActiveID();
  ImGui::FocusWindow(item.window);
  ImGui::SetNavID(item.id, layer, item.scope, ImGui::WindowRectAbsToRel(item.window, item.place));
  show_keyboard_place();
  if (layer == ImGuiNavLayer_Main) ImGui::ScrollToBringRectIntoView(item.window, item.place);
  if (item.typed) {
    g.NavNextActivateId = item.id;
    g.NavNextActivateFlags = ImGuiActivateFlags_PreferInput;
  }
}

}  // namespace

void forget_reachable() {
  reachable.clear();
  first_menu = {};
}

void note_reachable() {
  const Item item = last_item();
  const ImGuiItemFlags flags = last_item_flags();
  if (item.id == 0 || (flags & (ImGuiItemFlags_Disabled | ImGuiItemFlags_NoNav)) != 0) return;
  if (!reachable.empty() && reachable.back().id == item.id) return;
  reachable.push_back(item);
}

void note_first_menu() { first_menu = last_item(); }

void walk_by_keyboard() {
  const ImGuiContext& g = *ImGui::GetCurrentContext();
  const ImGuiIO& io = g.IO;
  // While a question or a menu is open, only what is in it can be reached.
  const ImGuiWindow* top = g.OpenPopupStack.empty() ? nullptr : g.OpenPopupStack.back().Window;
  if (key_pressed(GLFW_KEY_F10, false) && !top && first_menu.id != 0)
    return go_to(first_menu, ImGuiNavLayer_Menu);
  if (!key_pressed(GLFW_KEY_TAB) || io.KeyCtrl) return;
  if (top)
    std::erase_if(reachable,
                  [&](const Item& item) { return item.window != top && item.window->RootWindow != top; });
  if (reachable.empty()) return;
  const auto count = std::ptrdiff_t(reachable.size());
  const auto found = std::ranges::find(reachable, g.NavId, &Item::id);
  std::ptrdiff_t next = io.KeyShift ? count - 1 : 0;
  if (found != reachable.end()) next = (found - reachable.begin() + (io.KeyShift ? count - 1 : 1)) % count;
  go_to(reachable[std::size_t(next)], ImGuiNavLayer_Main);
}

void scroll_by_keys() {
  const float most = ImGui::GetScrollMaxY();
  if (most <= 0 || ImGui::IsWindowFocused()) return;  // ImGui scrolls a focused window itself
  const float line = ImGui::GetTextLineHeightWithSpacing(), page = ImGui::GetWindowHeight() - line;
  float to = ImGui::GetScrollY();
  for (const auto& [key, step] : {std::pair{GLFW_KEY_DOWN, line},
                                  {GLFW_KEY_UP, -line},
                                  {GLFW_KEY_PAGE_DOWN, page},
                                  {GLFW_KEY_PAGE_UP, -page},
                                  {GLFW_KEY_END, most},
                                  {GLFW_KEY_HOME, -most}})
    if (key_pressed(key)) to += step;
  if (to = std::clamp(to, 0.f, most); to != ImGui::GetScrollY()) ImGui::SetScrollY(to);
}

bool keyboard_is_at_it() { return ImGui::GetIO().NavVisible && ImGui::IsItemFocused(); }

void draw_keyboard_ring() { draw_keyboard_place(); }

}  // namespace likeness::ui
