// What the mouse does to the timeline: see timeline.h.
#include "ui/steps/timeline.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kReach = 6;  // units from a key within which the mouse hits it
constexpr std::array kEasingWords{"Linear", "Smooth", "Hold", "Ease in", "Ease out"};

double snapped(const Performance& performance, double time_s) {
  return std::round(time_s * performance.frames_per_second) / performance.frames_per_second;
}

// The keys under the mouse: those of one row at one time.
std::vector<KeyPlace> keys_under(const TimelinePlace& place, const std::vector<TimelineRow>& rows,
                                 const Performance& performance, ImVec2 mouse) {
  for (int r = 0; r < int(rows.size()); ++r) {
    const float top = place.row_top(r);
    if (mouse.y < top || mouse.y >= top + px(kRow)) continue;
    const std::vector<double>& times = rows[std::size_t(r)].times;
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

std::vector<KeyPlace> keys_in(const TimelinePlace& place, const std::vector<TimelineRow>& rows, ImVec2 a,
                              ImVec2 b) {
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

// A double click on a row: a key there with the channel's current value.
void add_key(const TimelinePlace& place, const std::vector<TimelineRow>& rows, const DirectingView& directing,
             ImVec2 mouse, Requests& requests) {
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

void take_hold(const TimelinePlace& place, const std::vector<TimelineRow>& rows,
               const DirectingView& directing, ImVec2 mouse, TimelineSight& sight, Requests& requests) {
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

void keep_hold(const TimelinePlace& place, const std::vector<TimelineRow>& rows,
               const DirectingView& directing, ImVec2 mouse, TimelineSight& sight, Requests& requests) {
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

void turn_wheel(const TimelinePlace& place, float rows_height, float mouse_x, TimelineSight& sight) {
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

}  // namespace

void use_timeline_mouse(const TimelinePlace& place, const DirectingView& directing, TimelineSight& sight,
                        Requests& requests) {
  const std::vector<TimelineRow>& rows = sight.rows;
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
  draw_key_menu(directing, requests);
  if (hovered) turn_wheel(place, float(rows.size() - 1) * px(kRow), mouse.x, sight);
}

}  // namespace likeness::ui
