// Before a project is open: recent ones, and the ways to begin.
#include <fmt/format.h>

#include "ui/keyboard.h"
#include "ui/shell.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

// A head in outline with a path round it: the program's mark.
void draw_logo(ImVec2 at, float side) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Palette& p = theme().colours;
  const ImVec2 c{at.x + 0.5f * side, at.y + 0.46f * side};
  list.AddRectFilled(at, {at.x + side, at.y + side}, colour(p.accent), 0.24f * side);
  const ImU32 ink = IM_COL32_WHITE;
  const float r = 0.2f * side, thick = 0.055f * side;
  list.AddCircle({c.x, c.y - 0.06f * side}, r, ink, 0, thick);
  list.PathArcTo({c.x, c.y + 0.5f * side}, 0.3f * side, 3.6f, 5.82f);
  list.PathStroke(ink, 0, thick);
}

// compact: in a window too low for all of them, what each does is only its tooltip.
struct Choices {
  float width = 0;
  bool compact = false;
};

bool big_choice(const char* words, const char* what, bool primary, bool enabled, const Choices& choices) {
  const Palette& p = theme().colours;
  const ImVec2 at = ImGui::GetCursorScreenPos(), size{choices.width, px(choices.compact ? 46 : 86)};
  ImGui::BeginDisabled(!enabled);
  const bool pressed = ImGui::InvisibleButton(words, size);
  note_widget(words);
  draw_keyboard_ring();
  if (choices.compact) tooltip(what);
  const bool hot = enabled && (ImGui::IsItemHovered() || ImGui::IsItemFocused());
  ImGui::EndDisabled();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec4 ground = primary ? (hot ? p.accent_hot : p.accent) : (hot ? p.raised : p.panel);
  const float alpha = enabled ? 1 : 0.5f;
  list.AddRectFilled(at, {at.x + size.x, at.y + size.y}, colour(ground, alpha), px(10));
  if (!primary) list.AddRect(at, {at.x + size.x, at.y + size.y}, colour(p.line, alpha), px(10));
  ImFont* strong = theme().fonts.strong;
  list.AddText(strong, strong->FontSize * 1.08f, {at.x + px(20), at.y + px(choices.compact ? 14 : 18)},
               colour(primary ? p.on_accent : p.text, alpha), words);
  if (choices.compact) return pressed && enabled;
  ImFont* body = theme().fonts.small;
  list.AddText(body, body->FontSize, {at.x + px(20), at.y + px(48)},
               primary ? colour(p.on_accent, 0.85f * alpha) : colour(p.faint, alpha), what, nullptr,
               choices.width - px(36));
  return pressed && enabled;
}

void draw_ways(const Snapshot& snapshot, Requests& requests) {
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const Choices choices{room.x, 5 * (px(86) + ImGui::GetStyle().ItemSpacing.y) > room.y};
  const Situation& now = snapshot.situation;
  const bool free = is_enabled(Command::open_clip, now);
  if (big_choice("Open a clip", "A minute of one person, filmed with a phone. Or drop it here.", true, free,
                 choices))
    requests.ask(Command::open_clip);
  if (big_choice("Record a clip", "With the webcam. It shows you what to do as you go.", false,
                 is_enabled(Command::record_clip, now), choices))
    requests.ask(Command::record_clip);
  if (big_choice("Open a project", "Go on where you left off.", false, free, choices))
    requests.ask(Command::open_project);
  if (big_choice("Try the demo", "Films a person who does not exist, in about two minutes.", false, free,
                 choices))
    requests.ask(Command::try_demo);
  if (big_choice("How to film", "What makes a clip that becomes a good avatar.", false, true, choices))
    requests.ask(Command::film_guide);
}

void draw_recent(const Snapshot& snapshot, Requests& requests) {
  heading("Recent projects");
  ImGui::Dummy({0, px(2)});
  if (snapshot.settings.recent.empty()) {
    faint_text("Projects you open are listed here.");
    return;
  }
  const float line = ImGui::GetTextLineHeight(), height = 2 * line + px(18);
  int number = 0;
  for (const std::filesystem::path& folder : snapshot.settings.recent) {
    ImGui::PushID(number++);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::SetItemAllowOverlap();
    if (ImGui::Selectable("##recent", false, ImGuiSelectableFlags_AllowItemOverlap, {0, height}))
      requests.open = folder;
    note_widget("recent " + folder.filename().string());
    if (ImGui::BeginPopupContextItem("forget")) {
      if (ImGui::MenuItem("Remove from this list")) requests.forget_recent = folder;
      ImGui::EndPopup();
    }
    ImGui::SetCursorScreenPos({at.x + px(12), at.y + px(7)});
    ImGui::PushFont(theme().fonts.strong);
    clipped_text(folder.stem().string(), width - px(24));
    ImGui::PopFont();
    ImGui::SetCursorScreenPos({at.x + px(12), at.y + px(9) + line});
    ImGui::PushFont(theme().fonts.small);
    ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
    clipped_text(folder.parent_path().string(), width - px(24));
    ImGui::PopStyleColor();
    ImGui::PopFont();
    ImGui::SetCursorScreenPos({at.x, at.y + height + ImGui::GetStyle().ItemSpacing.y});
    ImGui::PopID();
  }
}

}  // namespace

void draw_start_screen(const Snapshot& snapshot, Requests& requests) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  draw_logo(at, px(58));
  ImGui::SetCursorScreenPos({at.x + px(76), at.y - px(4)});
  ImGui::BeginGroup();
  ImGui::PushFont(theme().fonts.title);
  ImGui::TextUnformatted("Likeness");
  ImGui::PopFont();
  faint_text("From one phone video to a head you can direct.");
  ImGui::EndGroup();
  ImGui::Dummy({0, px(18)});
  const ImVec2 area = ImGui::GetContentRegionAvail();
  const float gap = px(28), left = std::min(px(430), 0.5f * (area.x - gap));
  ImGui::BeginChild("ways", {left, area.y}, false);
  if (is_working(snapshot.project.demo)) {
    begin_card("demo", {0, px(130)});
    ImGui::PushFont(theme().fonts.strong);
    ImGui::TextUnformatted("Filming the demo person");
    ImGui::PopFont();
    progress_bar(float(snapshot.project.demo.fraction));
    const std::string remaining = time_left(snapshot.project.demo.seconds_left);
    faint_text(snapshot.project.demo.text +
               (remaining.empty() || snapshot.project.demo.text.empty() ? "" : "  \u00b7  ") + remaining);
    if (command_button(Command::stop_work, snapshot.situation)) requests.ask(Command::stop_work);
    end_card();
  }
  draw_ways(snapshot, requests);
  ImGui::EndChild();
  ImGui::SameLine(0, gap);
  begin_card("recent", {0, area.y}, true);
  draw_recent(snapshot, requests);
  end_card();
}

void draw_licences() {
  heading("Licences and privacy");
  ImGui::Dummy({px(560), 0});
  body_text("Nothing leaves this computer. Likeness opens no connection and needs none.");
  ImGui::Dummy({0, px(4)});
  body_text(
      "Likeness itself is under the Apache-2.0 licence, as are the networks for person and face, which are "
      "MediaPipe's. The built-in head is part of Likeness. The face landmark model comes with dlib; its "
      "training data (iBUG 300-W) is for research use only. Another model of the same kind can be given on "
      "the command line with --landmark-model.");
  ImGui::Dummy({0, px(4)});
  body_text(
      "Head models that are not part of Likeness, such as FLAME, keep their own licences, most of them for "
      "research only. They can be given with --head-model and are never needed.");
}

}  // namespace likeness::ui
