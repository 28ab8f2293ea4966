// What several steps draw in the same way: see steps.h.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>

#include "ui/keyboard.h"
#include "ui/platform/imgui_versions.h"
#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

void draw_step_state(const StepView& view) {
  if (view.state == StepState::running) {
    progress_bar(float(view.fraction));
    const std::string left = time_left(view.seconds_left);
    faint_text(view.text + (left.empty() || view.text.empty() ? "" : "  \u00b7  ") + left);
    ImGui::Dummy({0, px(4)});
  }
  if (view.error) note("error", Tone::bad, view.error->what, view.error->fix);
  int number = 0;
  for (const std::string& warning : view.warnings) {
    ImGui::PushID(number++);
    note("warning", Tone::warn, warning);
    ImGui::PopID();
  }
}

bool group_heading(const char* words, bool& open) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float line = ImGui::GetTextLineHeight();
  ImGui::PushFont(theme().fonts.strong);
  if (ImGui::Selectable(fmt::format("      {}", words).c_str(), false)) open = !open;
  ImGui::PopFont();
  note_widget(words);
  const ImVec2 c{at.x + 0.5f * line, at.y + 0.52f * line};
  const float r = 0.2f * line;
  const ImU32 ink = colour(theme().colours.faint);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (open) {
    list.AddTriangleFilled({c.x - r, c.y - 0.6f * r}, {c.x + r, c.y - 0.6f * r}, {c.x, c.y + 0.8f * r}, ink);
  } else {
    list.AddTriangleFilled({c.x - 0.6f * r, c.y - r}, {c.x + 0.8f * r, c.y}, {c.x - 0.6f * r, c.y + r}, ink);
  }
  return open;
}

void draw_verdict_note(const CaptureVerdict& verdict, const std::string& why) {
  const Tone tone = verdict.verdict == Verdict::ready    ? Tone::good
                    : verdict.verdict == Verdict::usable ? Tone::warn
                                                         : Tone::bad;
  note("verdict", tone, std::string(verdict_words(verdict)), why);
}

void draw_make_buttons(const Snapshot& snapshot, Requests& requests, float width) {
  const Situation& now = snapshot.situation;
  const JobState run = snapshot.project.pipeline.job.state;
  const bool goes_on = run == JobState::stopped || (run != JobState::failed && now.interrupted);
  std::string words = goes_on                   ? "Continue"
                      : run == JobState::failed ? "Try again"
                      : now.film_again          ? "Make it anyway"
                                                : "Make the avatar";
  const std::string name = words;
  if (goes_on && snapshot.project.contents && snapshot.project.contents->plan.seconds > 0)
    words += fmt::format(" ({})", time_left(snapshot.project.contents->plan.seconds));
  if (now.film_again) {
    if (primary_button("Open another clip", is_enabled(Command::open_clip, now), width))
      requests.ask(Command::open_clip);
    if (now.faceless) return;
    if (width == 0) (void)same_line_if_fits(words.c_str());
  }
  const bool can = is_enabled(Command::make_avatar, now);
  if (now.film_again ? plain_button(words.c_str(), can, width) : primary_button(words.c_str(), can, width))
    requests.ask(Command::make_avatar);
  note_view(name);
}

bool is_low() { return ImGui::GetContentRegionAvail().y < px(390); }

void draw_nothing_yet(const char* words) {
  const ImVec2 area = ImGui::GetContentRegionAvail();
  const float wrap = std::min(area.x * 0.8f, px(460));
  const ImVec2 size = ImGui::CalcTextSize(words, nullptr, false, wrap);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float x = at.x + 0.5f * (area.x - size.x), y = at.y + std::max(px(16), 0.42f * area.y - size.y);
  ImGui::GetWindowDrawList()->AddText(ImGui::GetFont(), ImGui::GetFontSize(), {x, y},
                                      colour(theme().colours.faint), words, nullptr, wrap);
  ImGui::Dummy({area.x, std::max(px(20), area.y - px(4))});
}

namespace {

// The frame that the arrow keys lead to.
std::optional<int> stepped(const std::vector<StripBar>& bars, int chosen) {
  const int step = int(key_pressed(GLFW_KEY_RIGHT)) - int(key_pressed(GLFW_KEY_LEFT));
  const auto own = std::ranges::find(bars, chosen, &StripBar::frame);
  if (step == 0 || own == bars.end()) return std::nullopt;
  const auto to = own - bars.begin() + step;
  if (to < 0 || to >= std::ptrdiff_t(bars.size())) return std::nullopt;
  return bars[std::size_t(to)].frame;
}

// Pressing the mouse on one frame and dragging it to another marks these and all between.
void mark_span(StripSpan& span, const std::vector<StripBar>& bars, bool held, bool let_go,
               std::size_t under) {
  const int frame = bars[under].frame;
  if (held && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) span = {frame, std::nullopt};
  if (held && span.pressed && (frame != *span.pressed || span.span))
    span.span = RefitSpan{std::min(frame, *span.pressed), std::max(frame, *span.pressed)};
  if (let_go || !held) span.pressed.reset();
  if (span.span && key_pressed(GLFW_KEY_ESCAPE)) span = {};
}

}  // namespace

std::optional<int> draw_frame_strip(const char* name, const std::vector<StripBar>& bars, int chosen,
                                    float height, const std::function<std::string(std::size_t)>& words,
                                    StripSpan* span) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const bool pressed = ImGui::InvisibleButton(name, {width, height});
  note_widget(name);
  if (bars.empty()) return std::nullopt;
  const bool keys = keyboard_is_at_it();
  const bool hovered = ImGui::IsItemHovered() && !keys, held = ImGui::IsItemActive() && !keys;
  draw_keyboard_ring();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Palette& p = theme().colours;
  list.AddRectFilled(at, {at.x + width, at.y + height}, colour(p.raised), px(5));
  const auto count = bars.size();
  const float column = width / float(count), inset = px(3);
  const auto index_at = [&](float x) {
    return std::min(count - 1, std::size_t(std::max(0.f, (x - at.x) / width) * float(count)));
  };
  const auto draw_bar = [&](float x0, float x1, const StripBar& bar) {
    const float tall = std::clamp(bar.height, 0.06f, 1.f) * (height - 2 * inset);
    list.AddRectFilled({x0, at.y + height - inset - tall}, {x1, at.y + height - inset}, bar.ink);
    if (bar.struck)
      list.AddRectFilled({x0, at.y + 0.5f * height - px(1)}, {x1, at.y + 0.5f * height + px(1)},
                         colour(p.text));
    if (bar.again) list.AddRectFilled({x0, at.y + height - inset}, {x1, at.y + height}, colour(p.accent));
  };
  if (span && !keys) mark_span(*span, bars, held, pressed, index_at(ImGui::GetIO().MousePos.x));
  if (column >= 2) {
    const float gap = column > 4 ? 1.f : 0.f;
    for (std::size_t i = 0; i < count; ++i)
      draw_bar(at.x + column * float(i), at.x + column * float(i + 1) - gap, bars[i]);
  } else {
    for (float x = 0; x + 2 <= width; x += 2) {
      const std::size_t first = index_at(at.x + x), last = std::max(first + 1, index_at(at.x + x + 2));
      const auto tallest =
          std::max_element(bars.begin() + std::ptrdiff_t(first), bars.begin() + std::ptrdiff_t(last),
                           [](const StripBar& a, const StripBar& b) { return a.height < b.height; });
      draw_bar(at.x + x, at.x + x + 2, *tallest);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (bars[i].frame != chosen) continue;
    const float x = at.x + column * (float(i) + 0.5f);
    list.AddLine({x, at.y - px(2)}, {x, at.y + height + px(2)}, colour(p.text), px(2));
    list.AddTriangleFilled({x - px(5), at.y - px(6)}, {x + px(5), at.y - px(6)}, {x, at.y + px(1)},
                           colour(p.text));
  }
  if (span && span->span) {
    float low = width, high = 0;
    for (std::size_t i = 0; i < count; ++i)
      if (bars[i].frame >= span->span->first && bars[i].frame <= span->span->last)
        low = std::min(low, column * float(i)), high = std::max(high, column * float(i + 1));
    list.AddRectFilled({at.x + low, at.y}, {at.x + high, at.y + height}, colour(p.accent, 0.22f));
    list.AddRect({at.x + low, at.y}, {at.x + high, at.y + height}, colour(p.accent), px(2), 0, px(1.5f));
  }
  if (keys) return stepped(bars, chosen);
  if (!hovered) return std::nullopt;
  const std::size_t under = index_at(ImGui::GetIO().MousePos.x);
  tooltip(words(under));
  if ((held || pressed) && bars[under].frame != chosen) return bars[under].frame;
  return std::nullopt;
}

}  // namespace likeness::ui
