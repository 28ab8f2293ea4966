// The performance over time: what plays, a ruler, and a row of keys for every channel that has any.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ui/channel_words.h"
#include "ui/steps/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kRuler = 20, kRow = 19, kLabels = 118, kReach = 6;
constexpr int kMostRows = 7;  // before they scroll
constexpr std::array kEasingWords{"Linear", "Smooth", "Hold", "Ease in", "Ease out"};

// Where things lie: rows are the channels under one of all of them.
struct Place {
  ImVec2 at, size;  // of the ruler and the rows
  float left = 0;   // of the times
  double from_s = 0, span_s = 1;
  float scroll = 0;

  float x_of(double time_s) const {
    return left + float((time_s - from_s) / span_s) * (at.x + size.x - left);
  }
  double time_at(float x) const {
    return from_s + double((x - left) / std::max(1.f, at.x + size.x - left)) * span_s;
  }
  float row_top(int row) const {  // row 0: all keys, which does not scroll
    return at.y + px(kRuler) + float(row) * px(kRow) - (row > 0 ? scroll : 0);
  }
};

struct Row {
  std::string channel;  // empty: all of them
  const std::vector<Key>* keys = nullptr;
};

std::vector<Row> rows_of(const Performance& performance) {
  std::vector<Row> rows{{}};
  const auto add = [&](ChannelPart part) {
    for (const auto& [channel, keys] : performance.channels)
      if (part_of(channel) == part) rows.push_back({channel, &keys});
  };
  for (const ChannelPart part : {ChannelPart::head, ChannelPart::face, ChannelPart::camera}) add(part);
  return rows;
}

double snapped(const Performance& performance, double time_s) {
  return std::round(time_s * performance.frames_per_second) / performance.frames_per_second;
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
    Performance edited = requests.direct.start(snapshot.directing);
    edited.duration_s = std::max(1 / edited.frames_per_second, std::round(double(length) * 100) / 100);
    requests.direct.edit(std::move(edited), "length");
  }
  note_widget("length");
  if (ImGui::IsItemDeactivated()) requests.direct.finished = true;
  tooltip("How long the performance is. Drag, or double click to type.");
}

// Goes on in the line where there is room for so many px.
bool goes_on(float width) {
  ImGui::SameLine(0, px(6));
  const bool fits = ImGui::GetContentRegionAvail().x >= width;
  if (!fits) ImGui::NewLine();
  return fits;
}

float chip_width(const char* words) { return ImGui::CalcTextSize(words).x + 2 * px(8); }

void draw_transport(const Snapshot& snapshot, Requests& requests) {
  const DirectingView& directing = snapshot.directing;
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
    const char* tip = command == Command::record_keys
                          ? "On: what you set becomes a key at the playhead. Off: it holds all the time, "
                            "unless it has keys already. "
                          : "Start again at the end. ";
    if (chip(info.words.data(), info.words.data(), on, tip + shortcut(command))) requests.ask(command);
  }
  const Command add = Command::add_keys;
  if (!goes_on(chip_width(command_info(add).words.data()))) return;
  ImGui::BeginDisabled(!is_enabled(add, snapshot.situation));
  if (chip(command_info(add).words.data(), "Add keys here", false,
           "Keys at the playhead of everything that has keys. " + shortcut(add)))
    requests.ask(add);
  ImGui::EndDisabled();
}

// -- Rows

void draw_ruler(const Place& place, const DirectingView& directing) {
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

std::vector<double> chosen_times(const std::vector<KeyPlace>& selected, const std::string& channel) {
  std::vector<double> times;
  for (const KeyPlace& place : selected)
    if (channel.empty() || place.channel == channel) times.push_back(place.time_s);
  std::ranges::sort(times);
  return times;
}

bool has_time(const std::vector<double>& times, double time_s) {
  const auto found = std::ranges::lower_bound(times, time_s - kSameTime_s);
  return found != times.end() && *found <= time_s + kSameTime_s;
}

// Keys of a row; where they stand closer than can be told, a bar of them.
void draw_keys(const Place& place, const std::vector<double>& times, const std::vector<double>& chosen,
               float middle) {
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

void draw_course(const Place& place, const Row& row, float top) {
  const auto [low, high] = std::ranges::minmax(*row.keys, {}, &Key::value);
  const float span = high.value - low.value, height = px(kRow) - px(6);
  if (span <= 0) return;
  std::vector<ImVec2> line;
  for (float x = place.left; x <= place.at.x + place.size.x; x += px(4)) {
    const float v = value_at(*row.keys, place.time_at(x), rest_value(row.channel));
    line.push_back({x, top + px(3) + height * (1 - (v - low.value) / span)});
  }
  ImGui::GetWindowDrawList()->AddPolyline(line.data(), int(line.size()), colour(theme().colours.good, 0.55f),
                                          0, px(1.2f));
}

std::vector<double> times_of(const Performance& performance, const Row& row) {
  std::vector<double> times;
  if (row.keys) {
    for (const Key& key : *row.keys) times.push_back(key.time_s);
    return times;
  }
  for (const auto& [channel, keys] : performance.channels)
    for (const Key& key : keys) times.push_back(key.time_s);
  std::ranges::sort(times);
  const auto twice = std::ranges::unique(times, [](double a, double b) { return b - a <= kSameTime_s; });
  times.erase(twice.begin(), twice.end());
  return times;
}

void draw_row(const Place& place, const Row& row, int number, const DirectingView& directing) {
  const Palette& p = theme().colours;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float top = place.row_top(number), bottom = top + px(kRow), right = place.at.x + place.size.x;
  if (number % 2 == 0)
    list.AddRectFilled({place.at.x, top}, {right, bottom}, colour(p.raised, number == 0 ? 0.8f : 0.35f));
  const std::string words = row.keys ? channel_words(row.channel) : "All keys";
  ImFont* font = row.keys ? theme().fonts.small : theme().fonts.strong;
  const float size = theme().fonts.small->FontSize;
  list.PushClipRect({place.at.x, top}, {place.left - px(8), bottom}, true);
  list.AddText(font, size, {place.at.x + px(6), top + 0.5f * (px(kRow) - size)}, colour(p.text),
               words.c_str());
  list.PopClipRect();
  list.PushClipRect({place.left - px(6), top}, {right, bottom}, true);
  if (row.keys) draw_course(place, row, top);
  draw_keys(place, times_of(*directing.performance, row), chosen_times(*directing.selected, row.channel),
            0.5f * (top + bottom));
  list.PopClipRect();
  note_place(row.keys ? "row " + row.channel : "row all keys", {place.left, top}, {right, bottom});
}

// -- The mouse

// The keys under the mouse: those of one row at one time.
std::vector<KeyPlace> keys_under(const Place& place, const std::vector<Row>& rows,
                                 const Performance& performance, ImVec2 mouse) {
  for (int r = 0; r < int(rows.size()); ++r) {
    const float top = place.row_top(r);
    if (mouse.y < top || mouse.y >= top + px(kRow)) continue;
    const std::vector<double> times = times_of(performance, rows[std::size_t(r)]);
    const auto nearest =
        std::ranges::min_element(times, {}, [&](double t) { return std::abs(place.x_of(t) - mouse.x); });
    if (nearest == times.end() || std::abs(place.x_of(*nearest) - mouse.x) > px(kReach)) return {};
    if (rows[std::size_t(r)].keys) return {{rows[std::size_t(r)].channel, *nearest}};
    std::vector<KeyPlace> all;
    for (const KeyPlace& key : all_keys(performance))
      if (std::abs(key.time_s - *nearest) <= kSameTime_s) all.push_back(key);
    return all;
  }
  return {};
}

bool is_chosen(const std::vector<KeyPlace>& selected, const KeyPlace& key) {
  return std::ranges::any_of(selected, [&](const KeyPlace& s) {
    return s.channel == key.channel && std::abs(s.time_s - key.time_s) <= kSameTime_s;
  });
}

std::vector<KeyPlace> toggled(std::vector<KeyPlace> selected, const std::vector<KeyPlace>& keys) {
  for (const KeyPlace& key : keys) {
    if (is_chosen(selected, key)) {
      std::erase(selected, key);
    } else {
      selected.push_back(key);
    }
  }
  return selected;
}

std::vector<KeyPlace> keys_in(const Place& place, const std::vector<Row>& rows, ImVec2 a, ImVec2 b) {
  std::vector<KeyPlace> keys;
  const auto [left, right] = std::minmax(a.x, b.x);
  const auto [upper, lower] = std::minmax(a.y, b.y);
  for (int r = 1; r < int(rows.size()); ++r) {
    const float top = place.row_top(r);
    if (top + px(kRow) <= upper || top >= lower) continue;
    for (const Key& key : *rows[std::size_t(r)].keys)
      if (place.x_of(key.time_s) >= left && place.x_of(key.time_s) <= right)
        keys.push_back({rows[std::size_t(r)].channel, key.time_s});
  }
  return keys;
}

// A double click on a row: a key there of what the channel is at.
void add_key(const Place& place, const std::vector<Row>& rows, const DirectingView& directing, ImVec2 mouse,
             Requests& requests) {
  Performance edited = requests.direct.start(directing);
  const double time = std::max(0.0, snapped(edited, place.time_at(mouse.x)));
  for (int r = 0; r < int(rows.size()); ++r) {
    const float top = place.row_top(r);
    if (mouse.y < top || mouse.y >= top + px(kRow)) continue;
    if (!rows[std::size_t(r)].keys) {
      hold_pose(edited, time);
    } else {
      const std::string& channel = rows[std::size_t(r)].channel;
      set_key(edited, channel, {time, value_at(edited, channel, time)});
      requests.direct.selected = std::vector<KeyPlace>{{channel, time}};
    }
    requests.direct.edit(std::move(edited), "add a key");
    requests.direct.finished = true;
    return;
  }
}

void take_hold(const Place& place, const std::vector<Row>& rows, const DirectingView& directing, ImVec2 mouse,
               TimelineSight& sight, Requests& requests) {
  using Hold = TimelineSight::Hold;
  const Performance& performance = *directing.performance;
  sight.held_s = place.time_at(mouse.x);
  sight.corner = mouse;
  sight.before = directing.performance;
  if (mouse.y < place.at.y + px(kRuler)) {
    const bool at_end = std::abs(mouse.x - place.x_of(performance.duration_s)) < px(kReach) &&
                        directing.playhead_s < performance.duration_s - 0.5 * place.span_s / 100;
    sight.hold = at_end ? Hold::end : Hold::playhead;
    return;
  }
  const std::vector<KeyPlace> keys = keys_under(place, rows, performance, mouse);
  if (keys.empty()) {
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) && mouse.x >= place.left) {
      add_key(place, rows, directing, mouse, requests);
    } else {
      sight.hold = Hold::box;
    }
    return;
  }
  sight.hold = Hold::keys;
  sight.taken = *directing.selected;
  if (ImGui::GetIO().KeyCtrl || ImGui::GetIO().KeyShift) {
    sight.taken = toggled(sight.taken, keys);
  } else if (!std::ranges::all_of(keys, [&](const KeyPlace& k) { return is_chosen(sight.taken, k); })) {
    sight.taken = keys;
  }
  requests.direct.selected = sight.taken;
}

void keep_hold(const Place& place, const std::vector<Row>& rows, const DirectingView& directing, ImVec2 mouse,
               TimelineSight& sight, Requests& requests) {
  using Hold = TimelineSight::Hold;
  const Performance& performance = *directing.performance;
  const double now = place.time_at(mouse.x);
  switch (sight.hold) {
    case Hold::nothing:
      return;
    case Hold::playhead:
      requests.direct.playhead_s = now;
      return;
    case Hold::end: {
      Performance edited = performance;
      edited.duration_s = std::clamp(snapped(edited, now), 1 / edited.frames_per_second, kLongest_s);
      if (edited.duration_s != performance.duration_s) requests.direct.edit(std::move(edited), "length");
      return;
    }
    case Hold::keys: {
      if (std::abs(mouse.x - sight.corner.x) < px(3) && performance == *sight.before) return;
      Performance edited = *sight.before;
      std::vector<KeyPlace> moved = move_keys(edited, sight.taken, snapped(edited, now - sight.held_s));
      for (const KeyPlace& key : moved) edited.duration_s = std::max(edited.duration_s, key.time_s);
      if (edited == performance) return;
      requests.direct.edit(std::move(edited), "move keys");
      requests.direct.selected = std::move(moved);
      return;
    }
    case Hold::box: {
      requests.direct.selected = keys_in(place, rows, sight.corner, mouse);
      ImDrawList& list = *ImGui::GetWindowDrawList();
      const Palette& p = theme().colours;
      list.AddRectFilled(sight.corner, mouse, colour(p.accent, 0.12f));
      list.AddRect(sight.corner, mouse, colour(p.accent));
      return;
    }
  }
}

void turn_wheel(const Place& place, float rows_height, float mouse_x, TimelineSight& sight) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.MouseWheel == 0) return;
  if (io.KeyCtrl) {
    const double under = place.time_at(mouse_x), factor = std::pow(0.85, double(io.MouseWheel));
    sight.span_s = std::clamp(place.span_s * factor, 0.2, 2 * kLongest_s);
    sight.from_s = std::max(0.0, under - (under - place.from_s) * sight.span_s / place.span_s);
  } else if (io.KeyShift) {
    sight.span_s = place.span_s;
    sight.from_s = std::max(0.0, place.from_s - double(io.MouseWheel) * 0.1 * place.span_s);
  } else {
    const float most = std::max(0.f, rows_height - (place.size.y - px(kRuler) - px(kRow)));
    sight.scroll = std::clamp(sight.scroll - io.MouseWheel * px(kRow), 0.f, most);
  }
}

void draw_key_menu(const DirectingView& directing, Requests& requests) {
  if (!ImGui::BeginPopup("key menu")) return;
  for (std::size_t e = 0; e < kEasingWords.size(); ++e) {
    const Key* first =
        directing.selected->empty() ? nullptr : find_key(*directing.performance, directing.selected->front());
    if (ImGui::MenuItem(kEasingWords[e], nullptr, first && first->easing == Easing(e))) {
      Performance edited = requests.direct.start(directing);
      set_easing(edited, *directing.selected, Easing(e));
      requests.direct.edit(std::move(edited), "easing");
      requests.direct.finished = true;
    }
    note_widget(std::string("easing ") + kEasingWords[e]);
  }
  ImGui::Separator();
  for (const Command command : {Command::copy_keys, Command::delete_keys})
    if (ImGui::MenuItem(command_info(command).words.data(), command_info(command).shortcut.data()))
      requests.ask(command);
  ImGui::EndPopup();
}

void use_mouse(const Place& place, const std::vector<Row>& rows, const DirectingView& directing,
               TimelineSight& sight, Requests& requests) {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const bool activated = ImGui::IsItemActivated() && ImGui::IsMouseClicked(ImGuiMouseButton_Left);
  const bool let_go = ImGui::IsItemDeactivated(), hovered = ImGui::IsItemHovered();
  if (activated) take_hold(place, rows, directing, mouse, sight, requests);
  if (ImGui::IsItemActive() && ImGui::IsMouseDown(ImGuiMouseButton_Left))
    keep_hold(place, rows, directing, mouse, sight, requests);
  if (let_go) {
    sight.hold = TimelineSight::Hold::nothing;
    sight.before.reset();
    requests.direct.finished = true;
  }
  if (hovered && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
    const std::vector<KeyPlace> keys = keys_under(place, rows, *directing.performance, mouse);
    if (!keys.empty()) {
      if (!is_chosen(*directing.selected, keys.front())) requests.direct.selected = keys;
      ImGui::OpenPopup("key menu");
    }
  }
  if (hovered) turn_wheel(place, float(rows.size() - 1) * px(kRow), mouse.x, sight);
}

void draw_playhead(const Place& place, double playhead_s) {
  const float x = place.x_of(playhead_s);
  if (x < place.left - 1 || x > place.at.x + place.size.x + 1) return;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImU32 ink = colour(theme().colours.accent);
  list.AddLine({x, place.at.y + px(4)}, {x, place.at.y + place.size.y}, ink, px(1.5f));
  list.AddTriangleFilled({x - px(5), place.at.y}, {x + px(5), place.at.y}, {x, place.at.y + px(9)}, ink);
  note_place("playhead", {x - px(5), place.at.y}, {x + px(5), place.at.y + px(kRuler)});
}

}  // namespace

float timeline_height(const Snapshot& snapshot, float area) {
  const int rows = 1 + std::min(kMostRows, int(snapshot.directing.performance->channels.size()));
  const float head = ImGui::GetTextLineHeight() + px(14), gap = ImGui::GetStyle().ItemSpacing.y;
  const float least = head + px(kRuler) + px(kRow) + 2 * gap;
  return std::max(least, std::min(head + px(kRuler) + float(rows) * px(kRow) + 2 * gap, 0.36f * area));
}

void draw_timeline(const Snapshot& snapshot, Views& views, ImVec2 size, Requests& requests) {
  const DirectingView& directing = snapshot.directing;
  TimelineSight& sight = views.timeline;
  ImGui::BeginChild("timeline part", size, false,
                    ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::BeginDisabled(snapshot.comparing);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(8), px(3)));
  draw_transport(snapshot, requests);
  ImGui::PopStyleVar();
  const std::vector<Row> rows = rows_of(*directing.performance);
  Place place;
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
    note_widget("timeline");
    note_place("ruler", {place.left, place.at.y}, {place.at.x + place.size.x, place.at.y + px(kRuler)});
    ImDrawList& list = *ImGui::GetWindowDrawList();
    draw_ruler(place, directing);
    draw_row(place, rows.front(), 0, directing);
    const float rows_top = place.row_top(0) + px(kRow), bottom = place.at.y + place.size.y;
    list.PushClipRect({place.at.x, rows_top}, {place.at.x + place.size.x, bottom}, true);
    for (int r = 1; r < int(rows.size()); ++r)
      if (place.row_top(r) < bottom && place.row_top(r) + px(kRow) > rows_top)
        draw_row(place, rows[std::size_t(r)], r, directing);
    list.PopClipRect();
    draw_playhead(place, directing.playhead_s);
    use_mouse(place, rows, directing, sight, requests);
    draw_key_menu(directing, requests);
  }
  ImGui::EndDisabled();
  ImGui::EndChild();
}

}  // namespace likeness::ui
