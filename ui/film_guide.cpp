// How to film: drawings with a line each, in as many columns as there is room for.
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "ui/film_drawings.h"
#include "ui/keyboard.h"
#include "ui/shell.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kStrip = 92, kGap = 20;  // units: height of the drawings, gap between the rules

struct Rule {
  const char* what;
  const char* how;
  std::vector<FilmDrawing> drawings;
};

const std::vector<Rule>& rules() {
  using enum FilmDrawing;
  static const std::vector<Rule> all{
      {"About a minute",
       "of one person, head and shoulders in the picture, held upright or across.",
       {framing}},
      {"Even light", "from the front: a window or an overcast sky. No lamp behind the head.", {light}},
      {"Rest the camera", "on something, at the height of the eyes.", {camera_rests}},
      {"Turn the head slowly",
       "to both sides, up and down.",
       {turn_left, turn_right, raise_chin, lower_chin}},
      {"Speak and play",
       "smile, frown, raise the brows, blink, open the mouth wide: what is not seen is not learnt.",
       {smile, open_mouth, raise_brows, close_eyes}},
      {"Or walk round first",
       "half a circle round the resting head, then rest the camera and do the same.",
       {camera_walks}}};
  return all;
}

constexpr const char* kRemarks[] = {
    "A room in which nothing else moves and nobody else is seen; for the walk, one with shelves or plants.",
    "Hair and glasses stay as they are. Hands stay away from the face."};

float wrapped_height(const char* words, float width) {
  return ImGui::CalcTextSize(words, nullptr, false, width).y;
}

float rule_height(const Rule& rule, float width) {
  return px(kStrip) + px(8) + ImGui::GetTextLineHeight() + px(3) + wrapped_height(rule.how, width);
}

void draw_rule(const Rule& rule, ImVec2 at, float width) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float height = px(kStrip), count = float(rule.drawings.size());
  list.AddRectFilled(at, {at.x + width, at.y + height}, colour(theme().colours.raised), px(8));
  const float side = std::min(height - px(8), (width - px(8)) / count);
  const float between = (width - count * side) / (count + 1);
  ImVec2 corner{at.x + between, at.y + 0.5f * (height - side)};
  for (const FilmDrawing drawing : rule.drawings) {
    draw_film_drawing(list, corner, side, drawing);
    corner.x += side + between;
  }
  const Fonts& fonts = theme().fonts;
  const ImVec2 words{at.x, at.y + height + px(8)};
  list.AddText(fonts.strong, fonts.strong->FontSize, words, colour(theme().colours.text), rule.what);
  list.AddText(fonts.body, fonts.body->FontSize, {words.x, words.y + ImGui::GetTextLineHeight() + px(3)},
               colour(theme().colours.faint), rule.how, nullptr, width);
  note_place(std::string("rule ") + rule.what, at, {at.x + width, at.y + rule_height(rule, width)});
}

}  // namespace

void draw_film_guide() {
  heading("How to film");
  const ImVec2 screen = ImGui::GetMainViewport()->WorkSize;
  const float width = std::min(px(1000), 0.86f * screen.x), gap = px(kGap),
              bar = ImGui::GetStyle().ScrollbarSize;
  const std::size_t columns = width >= px(900) ? 3 : width >= px(480) ? 2 : 1;
  const float column = (width - bar - float(columns - 1) * gap) / float(columns);
  // As high as its content, or scrolled on a lower screen.
  std::vector<float> heights;  // of the rows
  float high = 0;
  for (std::size_t i = 0; i < rules().size(); i += columns) {
    heights.push_back(0);
    for (std::size_t j = i; j < std::min(i + columns, rules().size()); ++j)
      heights.back() = std::max(heights.back(), rule_height(rules()[j], column));
    high += heights.back() + gap;
  }
  for (const char* remark : kRemarks)
    high += wrapped_height(remark, width - bar) + ImGui::GetStyle().ItemSpacing.y;
  ImGui::BeginChild("film guide", {width, std::min(high, 0.68f * screen.y)});
  scroll_by_keys();
  for (std::size_t row = 0; row < heights.size(); ++row) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    for (std::size_t j = 0; j < columns && row * columns + j < rules().size(); ++j)
      draw_rule(rules()[row * columns + j], {at.x + float(j) * (column + gap), at.y}, column);
    ImGui::Dummy({width - bar, heights[row]});
    ImGui::SetCursorScreenPos({at.x, at.y + heights[row] + gap});
  }
  for (const char* remark : kRemarks) body_text(remark);
  ImGui::EndChild();
  note_widget("film guide");
}

}  // namespace likeness::ui
