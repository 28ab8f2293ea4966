// Drawn with ImGui's draw lists: see widgets.h.
#include "ui/widgets.h"

#include <fmt/format.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ui/keyboard.h"
#include "ui/letters.h"
#include "ui/theme.h"

namespace likeness::ui {

namespace {

std::map<std::string, Rectangle> noted;

bool coloured_button(const char* asked, bool enabled, float width, bool primary) {
  const std::string letters = for_window(asked);
  const char* words = letters.c_str();
  const Palette& p = theme().colours;
  // A button that cannot be pressed is not emphasised.
  primary =
      primary && enabled && (ImGui::GetCurrentContext()->CurrentItemFlags & ImGuiItemFlags_Disabled) == 0;
  if (primary) {
    ImGui::PushStyleColor(ImGuiCol_Button, p.accent);
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, p.accent_hot);
    ImGui::PushStyleColor(ImGuiCol_ButtonActive, p.accent_hot);
    ImGui::PushStyleColor(ImGuiCol_Text, p.on_accent);
    ImGui::PushFont(theme().fonts.strong);
  }
  // Words too long for a button of a fixed width get less padding, then smaller letters.
  const bool tight = width > 0 && ImGui::CalcTextSize(words).x + 2 * ImGui::GetStyle().FramePadding.x > width;
  if (tight) ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(4), ImGui::GetStyle().FramePadding.y));
  const bool small = tight && ImGui::CalcTextSize(words).x + 2 * px(4) > width;
  if (small) ImGui::PushFont(theme().fonts.small);
  ImGui::BeginDisabled(!enabled);
  const bool pressed = ImGui::Button(words, {width, 0});
  ImGui::EndDisabled();
  if (small) ImGui::PopFont();
  if (tight) ImGui::PopStyleVar();
  if (primary) {
    ImGui::PopFont();
    ImGui::PopStyleColor(4);
  }
  note_widget(asked);
  return pressed && enabled;
}

}  // namespace

const std::map<std::string, Rectangle>& noted_widgets() { return noted; }

void forget_widgets() {
  noted.clear();
  forget_reachable();
}

void note_widget(const std::string& name) {
  note_view(name);
  note_reachable();
}

void note_view(const std::string& name) { noted[name] = {ImGui::GetItemRectMin(), ImGui::GetItemRectMax()}; }

void note_place(const std::string& name, ImVec2 low, ImVec2 high) { noted[name] = {low, high}; }

void draw_mark(ImDrawList& list, ImVec2 c, float diameter, StepMark mark, int number) {
  const Palette& p = theme().colours;
  const float r = diameter / 2, thick = diameter / 11;
  switch (mark) {
    case StepMark::number: {
      list.AddCircle(c, r - thick / 2, colour(p.faint, 0.6f), 0, thick * 0.7f);
      const std::string digits = std::to_string(number);
      const float size = diameter * 0.56f;
      ImFont* font = theme().fonts.strong;
      const ImVec2 extent = font->CalcTextSizeA(size, 1e9f, 0, digits.c_str());
      list.AddText(font, size, {c.x - extent.x / 2, c.y - extent.y / 2}, colour(p.faint), digits.c_str());
      break;
    }
    case StepMark::running: {
      const float turn = float(std::fmod(ImGui::GetTime() * 3.0, 6.283));
      list.AddCircle(c, r - thick, colour(p.line), 0, thick);
      list.PathArcTo(c, r - thick, turn, turn + 2.2f);
      list.PathStroke(colour(p.accent), 0, thick * 1.3f);
      break;
    }
    case StepMark::done: {
      list.AddCircleFilled(c, r, colour(p.good));
      const ImVec2 tick[3] = {{c.x - 0.42f * r, c.y + 0.02f * r},
                              {c.x - 0.1f * r, c.y + 0.34f * r},
                              {c.x + 0.46f * r, c.y - 0.34f * r}};
      list.AddPolyline(tick, 3, colour(p.ground), 0, thick * 1.4f);
      break;
    }
    case StepMark::attention:
    case StepMark::failed: {
      list.AddCircleFilled(c, r, colour(mark == StepMark::failed ? p.bad : p.warn));
      list.AddLine({c.x, c.y - 0.5f * r}, {c.x, c.y + 0.12f * r}, colour(p.ground), thick * 1.5f);
      list.AddCircleFilled({c.x, c.y + 0.45f * r}, thick * 0.95f, colour(p.ground));
      break;
    }
  }
}

void heading(const char* words) {
  ImGui::PushFont(theme().fonts.heading);
  ImGui::TextUnformatted(words);
  ImGui::PopFont();
}

void faint_text(const std::string& words) {
  ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
  body_text(words);
  ImGui::PopStyleColor();
}

void body_text(const std::string& words) {
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(for_window(words).c_str());
  ImGui::PopTextWrapPos();
}

bool primary_button(const char* words, bool enabled, float width) {
  return coloured_button(words, enabled, width, true);
}

bool plain_button(const char* words, bool enabled, float width) {
  return coloured_button(words, enabled, width, false);
}

bool command_button(Command command, const Situation& situation, bool primary, float width) {
  const CommandInfo& info = command_info(command);
  const bool pressed = coloured_button(info.words.data(), info.enabled(situation), width, primary);
  if (!info.shortcut.empty()) tooltip(std::string(info.shortcut));
  return pressed;
}

bool same_line_if_fits(const char* words) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float end = ImGui::GetWindowPos().x + ImGui::GetContentRegionMax().x;
  const float wanted = ImGui::CalcTextSize(words).x + 2.2f * style.FramePadding.x + style.ItemSpacing.x;
  if (ImGui::GetItemRectMax().x + wanted >= end) return false;
  ImGui::SameLine();
  return true;
}

void choice_label(const char* words, float width) {
  const float start = ImGui::GetCursorPosX();
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(3), px(2)));
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(for_window(words).c_str());
  ImGui::PopStyleVar();
  ImGui::SameLine(start + width);
}

namespace {

// Slim, with a border: the fill of an unchosen box alone is hardly distinguishable from the card's.
void push_choice_style() {
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(3), px(2)));
  ImGui::PushStyleVar(ImGuiStyleVar_FrameBorderSize, px(1));
  ImGui::PushStyleColor(ImGuiCol_Border, theme().colours.faint);
  ImGui::PushStyleColor(ImGuiCol_BorderShadow, {});
}

void pop_choice_style() {
  ImGui::PopStyleColor(2);
  ImGui::PopStyleVar(2);
}

}  // namespace

bool choice(const char* words, bool chosen) {
  push_choice_style();
  const bool pressed = ImGui::RadioButton(for_window(words).c_str(), chosen);
  pop_choice_style();
  note_widget(words);
  return pressed;
}

bool tick_box(const char* words, bool* on) {
  push_choice_style();
  const bool changed = ImGui::Checkbox(words, on);
  pop_choice_style();
  note_widget(words);
  return changed;
}

bool slider(const char* id, float* value, const SliderRange& range, const char* format, float width) {
  const Palette& p = theme().colours;
  const float words = px(62), full = ImGui::GetFrameHeight(), slim = px(4);
  const ImVec2 top = ImGui::GetCursorPos();
  ImGui::BeginGroup();
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(slim, slim));
  ImGui::SetCursorPosY(top.y + 0.5f * (full - ImGui::GetFrameHeight()));
  ImGui::SetNextItemWidth(std::max(px(30), width - words));
  // Its number stands beside it and cannot be typed.
  bool changed = ImGui::SliderFloat(id, value, range.low, range.high, "",
                                    ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput);
  ImGui::PopStyleVar();
  note_widget(id);
  // While the mouse button of the double click is held, ImGui would set the value under the mouse again.
  static ImGuiID resetting = 0;
  const ImGuiID own = ImGui::GetID(id);
  if (ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) resetting = own;
  if (resetting == own) {
    *value = range.rest;
    changed = true;
    if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) resetting = 0;
  }
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (range.seen_high > range.seen_low) {
    const float inset = px(3), span = b.x - a.x - 2 * inset;
    const auto at = [&](float v) {
      return a.x + inset + span * std::clamp((v - range.low) / (range.high - range.low), 0.f, 1.f);
    };
    const float from = at(range.seen_low), to = std::max(from + px(2), at(range.seen_high));
    list.AddRectFilled({from, b.y + px(1)}, {to, b.y + px(4)}, colour(p.good), px(1.5f));
  }
  char shown[32];
  std::snprintf(shown, sizeof shown, format, double(*value));
  const ImVec2 size = ImGui::CalcTextSize(shown);
  list.AddText({b.x + words - size.x, 0.5f * (a.y + b.y - size.y)}, colour(p.faint), shown);
  ImGui::SetCursorPos(top);
  ImGui::Dummy({b.x - a.x + words, full});
  ImGui::EndGroup();  // one item, deactivated when the slider is
  return changed;
}

void progress_bar(float fraction, float height) {
  const Palette& p = theme().colours;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, h = px(height);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, {at.x + width, at.y + h}, colour(p.line), h / 2);
  if (fraction < 0) {
    const float phase = float(std::fmod(ImGui::GetTime() * 0.6, 1.0)), from = at.x + width * phase * 0.8f;
    list.AddRectFilled({from, at.y}, {from + 0.2f * width, at.y + h}, colour(p.accent), h / 2);
  } else if (fraction > 0) {
    const float to = at.x + std::max(h, width * std::min(1.f, fraction));
    list.AddRectFilled(at, {to, at.y + h}, colour(p.accent), h / 2);
  }
  ImGui::Dummy({width, h});
}

std::string duration(double seconds) {
  const auto s = std::int64_t(std::lround(std::max(0.0, seconds)));
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

std::string time_left(double seconds) {
  if (seconds < 0) return {};
  if (seconds < 50) return fmt::format("about {} s left", std::max(5, int(std::ceil(seconds / 5)) * 5));
  if (seconds < 5400) return fmt::format("about {} min left", int(std::lround(std::max(60.0, seconds) / 60)));
  return fmt::format("about {:.1f} h left", seconds / 3600);
}

bool begin_card(const char* id, ImVec2 size, bool scrolls) {
  ImGui::PushStyleColor(ImGuiCol_ChildBg, theme().colours.panel);
  const ImGuiWindowFlags flags =
      ImGuiWindowFlags_AlwaysUseWindowPadding |
      (scrolls ? 0 : ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  return ImGui::BeginChild(id, size, true, flags);
}

void end_card() {
  ImGui::EndChild();
  ImGui::PopStyleColor();
}

void note(const char* id, Tone tone, const std::string& asked_what, const std::string& asked_fix) {
  const std::string what = for_window(asked_what), fix = for_window(asked_fix);
  const Palette& p = theme().colours;
  const ImVec4& ink = tone == Tone::bad    ? p.bad
                      : tone == Tone::warn ? p.warn
                      : tone == Tone::good ? p.good
                                           : p.accent;
  const float pad = px(12), mark = px(18), left = pad + mark + px(10);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, wrap = std::max(px(40), width - left - pad);
  const ImVec2 first = ImGui::CalcTextSize(what.c_str(), nullptr, false, wrap);
  const ImVec2 second = fix.empty() ? ImVec2{} : ImGui::CalcTextSize(fix.c_str(), nullptr, false, wrap);
  const float gap = fix.empty() ? 0 : px(4), height = 2 * pad * 0.8f + first.y + gap + second.y;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, {at.x + width, at.y + height}, colour(ink, 0.13f), px(6));
  list.AddRectFilled(at, {at.x + px(3), at.y + height}, colour(ink), px(6));
  const ImVec2 centre{at.x + pad + mark / 2, at.y + pad * 0.8f + ImGui::GetTextLineHeight() / 2};
  if (tone == Tone::good) {
    draw_mark(list, centre, mark, StepMark::done, 0);
  } else if (tone == Tone::plain) {
    list.AddCircleFilled(centre, px(4), colour(ink));
  } else {
    draw_mark(list, centre, mark, tone == Tone::bad ? StepMark::failed : StepMark::attention, 0);
  }
  ImFont* font = ImGui::GetFont();
  const float size = ImGui::GetFontSize(), x = at.x + left, y = at.y + pad * 0.8f;
  list.AddText(font, size, {x, y}, colour(p.text), what.c_str(), nullptr, wrap);
  if (!fix.empty())
    list.AddText(font, size, {x, y + first.y + gap}, colour(p.faint), fix.c_str(), nullptr, wrap);
  ImGui::PushID(id);
  ImGui::Dummy({width, height});
  ImGui::PopID();
  note_widget(id);
}

std::string shortened(const std::string& asked, float width) {
  const std::string words = for_window(asked);
  std::string shown = words;
  while (shown.size() > 1 && ImGui::CalcTextSize((shown + "…").c_str()).x > width &&
         ImGui::CalcTextSize(words.c_str()).x > width) {
    do {
      shown.pop_back();
    } while (!shown.empty() && (static_cast<unsigned char>(shown.back()) & 0xC0) == 0x80);
  }
  return shown.size() < words.size() ? shown + "…" : words;
}

void clipped_text(const std::string& words, float width) {
  const std::string shown = shortened(words, width);
  ImGui::TextUnformatted(shown.c_str());
  if (shown != for_window(words)) tooltip(words);
}

void tooltip(const std::string& words) {
  if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(px(420));
  ImGui::TextUnformatted(for_window(words).c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void strong_text(const char* words) {
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted(words);
  ImGui::PopFont();
}

}  // namespace likeness::ui
