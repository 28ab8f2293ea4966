// The performance over time: what plays, a ruler, and a row of keys for every channel that has any.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <string_view>

#include "ui/steps.h"
#include "ui/steps/timeline.h"
#include "ui/studio/channel_words.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kLabels = 142;
constexpr int kMaxRows = 7;  // before they scroll

// Two ascending lists of times as one, each time in it once.
std::vector<double> merged(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> both;
  both.reserve(std::max(a.size(), b.size()));
  std::ranges::merge(a, b, std::back_inserter(both));
  const auto same = [](double x, double y) { return y - x <= kSameTime_s; };
  both.erase(std::unique(both.begin(), both.end(), same), both.end());
  return both;
}

std::vector<TimelineRow> rows_of(const Performance& performance) {
  std::vector<TimelineRow> rows{{}};
  const auto add = [&](const std::string& channel, const std::vector<Key>& keys) {
    TimelineRow row{channel, &keys};
    const auto [low, high] = std::ranges::minmax(keys, {}, &Key::value);
    row.low = low.value, row.high = high.value;
    for (const Key& key : keys) row.times.push_back(key.time_s);
    rows.front().times = merged(rows.front().times, row.times);
    rows.push_back(std::move(row));
  };
  for (const ChannelPart part : {ChannelPart::head, ChannelPart::face, ChannelPart::camera})
    for (const auto& [channel, keys] : performance.channels)
      if (part_of(channel) == part) add(channel, keys);
  return rows;
}

// -- What plays

bool chip(const char* words, const char* id, bool on, const std::string& tip) {
  const Palette& p = theme().colours;
  if (on) {
    ImGui::PushStyleColor(ImGuiCol_Button, p.accent);
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, p.accent_hot);
    ImGui::PushStyleColor(ImGuiCol_ButtonActive, p.accent_hot);
    ImGui::PushStyleColor(ImGuiCol_Text, p.on_accent);
  }
  const bool pressed = ImGui::Button(fmt::format("{}###{}", words, id).c_str());
  if (on) ImGui::PopStyleColor(4);
  note_widget(id);
  tooltip(tip);
  return pressed;
}

void draw_length(const Performance& performance, float width, Requests& requests, const Snapshot& snapshot) {
  float length = float(performance.duration_s);
  ImGui::SetNextItemWidth(width);
  if (ImGui::DragFloat("##length", &length, 0.05f, 0.1f, float(kLongest_s), "of %.1f s",
                       ImGuiSliderFlags_AlwaysClamp)) {
    Performance edited = requests.direct.start(snapshot.direct.directing);
    edited.duration_s = std::max(1 / edited.frames_per_second, std::round(double(length) * 100) / 100);
    requests.direct.edit(std::move(edited), "length");
  }
  note_widget("length");
  if (ImGui::IsItemDeactivated()) requests.direct.finished = true;
  tooltip("How long the performance is. Drag, or double click to type.");
}

// Continues the line if there is room for `width`; false otherwise.
bool goes_on(float width) {
  ImGui::SameLine(0, px(6));
  const bool fits = ImGui::GetContentRegionAvail().x >= width;
  if (!fits) ImGui::NewLine();
  return fits;
}

float chip_width(const char* words) { return ImGui::CalcTextSize(words).x + 2 * px(8); }

void draw_transport(const Snapshot& snapshot, Requests& requests) {
  const DirectingView& directing = snapshot.direct.directing;
  const auto shortcut = [](Command c) { return std::string(command_info(c).shortcut); };
  if (chip(directing.playing ? "Stop" : "Play", "play", directing.playing, shortcut(Command::play)))
    requests.ask(Command::play);
  ImGui::SameLine(0, px(8));
  ImGui::AlignTextToFramePadding();
  ImGui::Text("%5.2f s", directing.playhead_s);
  ImGui::SameLine(0, px(4));
  draw_length(*directing.performance, px(84), requests, snapshot);
  for (const auto& [command, on] : {std::pair{Command::record_keys, directing.record_keys},
                                    std::pair{Command::repeat, directing.looping}}) {
    const CommandInfo& info = command_info(command);
    if (!goes_on(chip_width(info.words.data()))) return;
    const char* tip =
        command == Command::record_keys
            ? "On: what you set becomes a key at the playhead. Off: it holds throughout, unless "
              "it has keys already. "
            : "Start again at the end. ";
    if (chip(info.words.data(), info.words.data(), on, tip + shortcut(command))) requests.ask(command);
  }
  const Command add = Command::add_keys;
  if (!goes_on(chip_width(command_info(add).words.data()))) return;
  ImGui::BeginDisabled(!is_enabled(add, snapshot.situation));
  if (chip(command_info(add).words.data(), "Add keys here", false,
           "A key at the playhead for everything that has keys. " + shortcut(add)))
    requests.ask(add);
  ImGui::EndDisabled();
}

// -- Rows

void draw_ruler(const TimelinePlace& place, const DirectingView& directing) {
  const Palette& p = theme().colours;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  ImFont* font = theme().fonts.small;
  constexpr std::array kSteps_s{0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0, 600.0};
  const double wanted = double(px(64)) * place.span_s / double(place.at.x + place.size.x - place.left);
  const auto found = std::ranges::lower_bound(kSteps_s, wanted);
  const double step = found == kSteps_s.end() ? kSteps_s.back() : *found;
  const float end = place.x_of(directing.performance->duration_s);
  list.AddRectFilled({place.left, place.at.y},
                     {std::min(end, place.at.x + place.size.x), place.at.y + px(kRuler)}, colour(p.raised));
  for (double t = std::ceil(place.from_s / step) * step; t <= place.from_s + place.span_s; t += step) {
    const float x = place.x_of(t);
    list.AddLine({x, place.at.y + px(13)}, {x, place.at.y + px(kRuler)}, colour(p.faint));
    if (x + px(34) > place.at.x + place.size.x) break;
    const std::string words = step < 1 ? fmt::format("{:.1f}", t) : fmt::format("{:.0f} s", t);
    list.AddText(font, font->FontSize * 0.9f, {x + px(3), place.at.y + px(1)}, colour(p.faint),
                 words.c_str());
  }
  // The handle of the end.
  if (end <= place.at.x + place.size.x + 1)
    list.AddRectFilled({end - px(3), place.at.y}, {end, place.at.y + px(kRuler)}, colour(p.faint));
}

void draw_diamond(ImDrawList& list, ImVec2 c, float r, ImU32 ink) {
  list.AddQuadFilled({c.x, c.y - r}, {c.x + r, c.y}, {c.x, c.y + r}, {c.x - r, c.y}, ink);
}

bool has_time(const std::vector<double>& times, double time_s) {
  const auto found = std::ranges::lower_bound(times, time_s - kSameTime_s);
  return found != times.end() && *found <= time_s + kSameTime_s;
}

// Keys of a row; keys too close to tell apart are drawn as bars.
void draw_keys(const TimelinePlace& place, const std::vector<double>& times,
               const std::vector<double>& chosen, float middle) {
  const Palette& p = theme().colours;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float r = px(5), end = place.at.x + place.size.x;
  auto key = std::ranges::lower_bound(times, place.time_at(place.left - r));
  while (key != times.end()) {
    const float x = place.x_of(*key);
    if (x > end + r) return;
    const ImU32 ink = colour(has_time(chosen, *key) ? p.accent : p.text, has_time(chosen, *key) ? 1 : 0.75f);
    const auto next = key + 1;
    if (next != times.end() && place.x_of(*next) - x < px(4)) {
      const float to = x + px(4);
      list.AddRectFilled({x, middle - px(3)}, {to, middle + px(3)}, ink);
      key = std::ranges::lower_bound(next, times.end(), place.time_at(to));
    } else {
      draw_diamond(list, {x, middle}, r, ink);
      key = next;
    }
  }
}

void draw_curve(const TimelinePlace& place, const TimelineRow& row, float top) {
  const float span = row.high - row.low, height = px(kRow) - px(6);
  if (span <= 0) return;
  std::vector<ImVec2> line;
  for (float x = place.left; x <= place.at.x + place.size.x; x += px(4)) {
    const float v = value_at(*row.keys, place.time_at(x), rest_value(row.channel));
    line.push_back({x, top + px(3) + height * (1 - (v - row.low) / span)});
  }
  ImGui::GetWindowDrawList()->AddPolyline(line.data(), int(line.size()), colour(theme().colours.good, 0.55f),
                                          0, px(1.2f));
}

void draw_row(const TimelinePlace& place, const TimelineRow& row, int number) {
  const Palette& p = theme().colours;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float top = place.row_top(number), bottom = top + px(kRow), right = place.at.x + place.size.x;
  if (number % 2 == 0)
    list.AddRectFilled({place.at.x, top}, {right, bottom}, colour(p.raised, number == 0 ? 0.8f : 0.35f));
  const std::string words = row.keys ? channel_words(row.channel) : "All keys";
  ImFont* font = row.keys ? theme().fonts.small : theme().fonts.strong;
  const float size = theme().fonts.small->FontSize;
  ImGui::PushFont(font);
  const std::string shown = shortened(words, place.left - px(14) - place.at.x);
  ImGui::PopFont();
  list.AddText(font, size, {place.at.x + px(6), top + 0.5f * (px(kRow) - size)}, colour(p.text),
               shown.c_str());
  list.PushClipRect({place.left - px(6), top}, {right, bottom}, true);
  if (row.keys) draw_curve(place, row, top);
  draw_keys(place, row.times, row.chosen, 0.5f * (top + bottom));
  list.PopClipRect();
  note_place(row.keys ? "row " + row.channel : "row all keys", {place.left, top}, {right, bottom});
}

void draw_no_keys(const TimelinePlace& place) {
  ImFont* font = theme().fonts.small;
  const float left = place.left + px(10);
  ImGui::PushFont(font);
  const std::string words = shortened("No keys yet: turn on Record keys, choose a time, and pose the avatar.",
                                      place.at.x + place.size.x - left);
  ImGui::PopFont();
  ImGui::GetWindowDrawList()->AddText(font, font->FontSize,
                                      {left, place.row_top(0) + 0.5f * (px(kRow) - font->FontSize)},
                                      colour(theme().colours.faint), words.c_str());
}

void draw_playhead(const TimelinePlace& place, double playhead_s) {
  const float x = place.x_of(playhead_s);
  if (x < place.left - 1 || x > place.at.x + place.size.x + 1) return;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImU32 ink = colour(theme().colours.accent);
  list.AddLine({x, place.at.y + px(4)}, {x, place.at.y + place.size.y}, ink, px(1.5f));
  list.AddTriangleFilled({x - px(5), place.at.y}, {x + px(5), place.at.y}, {x, place.at.y + px(9)}, ink);
  note_place("playhead", {x - px(5), place.at.y}, {x + px(5), place.at.y + px(kRuler)});
}

}  // namespace

void find_rows(const DirectingView& directing, TimelineSight& sight) {
  if (sight.rows_of != directing.performance) {
    sight.rows = rows_of(*directing.performance);
    sight.rows_of = directing.performance;
    sight.seen.reset();
  }
  if (sight.seen == directing.selected) return;
  sight.seen = directing.selected;
  std::map<std::string_view, TimelineRow*> by_channel;
  for (TimelineRow& row : sight.rows) {
    row.chosen.clear();
    by_channel[row.channel] = &row;
  }
  for (const KeyPlace& place : *directing.selected)
    if (const auto row = by_channel.find(place.channel); row != by_channel.end())
      row->second->chosen.push_back(place.time_s);
  TimelineRow& all = sight.rows.front();
  for (TimelineRow& row : sight.rows) {
    std::ranges::sort(row.chosen);
    if (&row != &all) all.chosen = merged(all.chosen, row.chosen);
  }
}

float timeline_height(const Snapshot& snapshot, float area) {
  const int rows = 1 + std::min(kMaxRows, int(snapshot.direct.directing.performance->channels.size()));
  const float head = ImGui::GetTextLineHeight() + px(14), gap = ImGui::GetStyle().ItemSpacing.y;
  const float least = head + px(kRuler) + px(kRow) + 2 * gap;
  if (snapshot.direct.comparing) return least;  // the timeline is idle meanwhile: the picture takes the room
  return std::max(least, std::min(head + px(kRuler) + float(rows) * px(kRow) + 2 * gap, 0.36f * area));
}

void draw_timeline(const Snapshot& snapshot, Views& views, ImVec2 size, Requests& requests) {
  const DirectingView& directing = snapshot.direct.directing;
  TimelineSight& sight = views.timeline;
  ImGui::BeginChild("timeline part", size, false,
                    ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::BeginDisabled(snapshot.direct.comparing);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(8), px(3)));
  draw_transport(snapshot, requests);
  ImGui::PopStyleVar();
  find_rows(directing, sight);
  const std::vector<TimelineRow>& rows = sight.rows;
  TimelinePlace place;
  place.at = ImGui::GetCursorScreenPos();
  place.size = ImGui::GetContentRegionAvail();
  place.left = place.at.x + std::min(px(kLabels), 0.3f * place.size.x);
  place.span_s = sight.span_s > 0 ? sight.span_s : directing.performance->duration_s * 1.02;
  place.from_s = sight.span_s > 0 ? sight.from_s : 0;
  if (sight.span_s > directing.performance->duration_s * 1.5) sight.span_s = sight.from_s = 0;
  sight.scroll =
      std::clamp(sight.scroll, 0.f,
                 std::max(0.f, float(rows.size() - 1) * px(kRow) - (place.size.y - px(kRuler) - px(kRow))));
  place.scroll = sight.scroll;
  if (place.size.x > px(40) && place.size.y > px(kRuler)) {
    ImGui::InvisibleButton("timeline", place.size);
    note_view("timeline");
    note_place("ruler", {place.left, place.at.y}, {place.at.x + place.size.x, place.at.y + px(kRuler)});
    ImDrawList& list = *ImGui::GetWindowDrawList();
    draw_ruler(place, directing);
    draw_row(place, rows.front(), 0);
    if (directing.performance->channels.empty()) draw_no_keys(place);
    const float rows_top = place.row_top(0) + px(kRow), bottom = place.at.y + place.size.y;
    list.PushClipRect({place.at.x, rows_top}, {place.at.x + place.size.x, bottom}, true);
    for (int r = 1; r < int(rows.size()); ++r)
      if (place.row_top(r) < bottom && place.row_top(r) + px(kRow) > rows_top)
        draw_row(place, rows[std::size_t(r)], r);
    list.PopClipRect();
    draw_playhead(place, directing.playhead_s);
    use_timeline_mouse(place, directing, sight, requests);
  }
  ImGui::EndDisabled();
  ImGui::EndChild();
}

}  // namespace likeness::ui
