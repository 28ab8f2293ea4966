// Step 6: the avatar in a large view, and everything it can be asked to do.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "ui/steps/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kDegreesAPixel = 0.35f, kPlateFade_deg = 8;
constexpr double kLeastZoom = 0.5, kMostZoom = 4;

// What the mouse does to the view: left orbits, right or middle pans, wheel zooms.
void move_view(const Snapshot& snapshot, const Fitted& place, bool hovered, bool active, Requests& requests) {
  const ImGuiIO& io = ImGui::GetIO();
  Acting acting = requests.acting.value_or(snapshot.acting);
  const ViewPoint before = acting.view;
  ViewPoint& view = acting.view;
  if (active && ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0) && !snapshot.comparing) {
    view.yaw_deg = std::clamp(view.yaw_deg - double(io.MouseDelta.x * kDegreesAPixel / theme().scale),
                              -kOrbitLimit_deg, kOrbitLimit_deg);
    view.pitch_deg = std::clamp(view.pitch_deg + double(io.MouseDelta.y * kDegreesAPixel / theme().scale),
                                -kOrbitPitchLimit_deg, kOrbitPitchLimit_deg);
  }
  if (active && (ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0) ||
                 ImGui::IsMouseDragging(ImGuiMouseButton_Middle, 0))) {
    view.shift_x =
        std::clamp(view.shift_x + double(io.MouseDelta.x / std::max(1.f, place.size.x)), -1.0, 1.0);
    view.shift_y =
        std::clamp(view.shift_y + double(io.MouseDelta.y / std::max(1.f, place.size.y)), -1.0, 1.0);
  }
  if (hovered && io.MouseWheel != 0)
    view.zoom = std::clamp(view.zoom * std::pow(1.12, double(io.MouseWheel)), kLeastZoom, kMostZoom);
  if (view == before) return;
  requests.acting = acting;
}

void draw_wipe(const FramePicture& picture, Views& views, const Fitted& place) {
  views.truth.follow(picture);
  if (views.truth.texture.empty()) return;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float x = place.at.x + views.wipe * place.size.x;
  const ImVec2 end{place.at.x + place.size.x, place.at.y + place.size.y};
  list.PushClipRect({x, place.at.y}, end, true);
  list.AddImage(views.truth.texture.imgui_id(), place.at, end);
  list.PopClipRect();
  list.AddLine({x, place.at.y}, {x, end.y}, colour({1, 1, 1, 1}), px(2));
  list.AddCircleFilled({x, 0.5f * (place.at.y + end.y)}, px(9), colour({1, 1, 1, 1}));
  const auto label = [&](const char* words, float at, bool right) {
    const ImVec2 size = ImGui::CalcTextSize(words);
    const float left = right ? at - size.x - px(20) : at;
    list.AddRectFilled({left, place.at.y + px(10)}, {left + size.x + px(20), place.at.y + px(18) + size.y},
                       colour({0, 0, 0, 0.55f}), px(5));
    list.AddText({left + px(10), place.at.y + px(14)}, colour({1, 1, 1, 1}), words);
  };
  if (views.wipe > 0.12f) label("Avatar", place.at.x + px(10), false);
  if (views.wipe < 0.88f) label("Clip", end.x - px(10), true);
}

void draw_view(const Snapshot& snapshot, Views& views, ImVec2 area, Requests& requests) {
  const AvatarPicture* picture = snapshot.picture.get();
  const Fitted place = fit_into(ImGui::GetCursorScreenPos(), area, 1, 1);
  requests.view_px = int(place.size.x);
  ImGui::SetCursorScreenPos(place.at);
  ImGui::InvisibleButton("avatar view", {std::max(1.f, place.size.x), std::max(1.f, place.size.y)},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  note_widget("avatar view");
  const bool hovered = ImGui::IsItemHovered(), active = ImGui::IsItemActive(),
             let_go = ImGui::IsItemDeactivated();
  if (!picture) {
    const char* words = "Rendering\u2026";
    const ImVec2 size = ImGui::CalcTextSize(words);
    ImGui::GetWindowDrawList()->AddText(
        {place.at.x + 0.5f * (place.size.x - size.x), place.at.y + 0.5f * (place.size.y - size.y)},
        colour(theme().colours.faint), words);
    return;
  }
  const Avatar& avatar = snapshot.contents->avatar->avatar;
  if (views.rendered.get() != picture) {
    views.render->set_picture(picture->rgba);
    views.rendered = snapshot.picture;
  }
  if (!avatar.plate.empty()) views.plate.follow(avatar.plate, snapshot.contents->avatar);
  const ViewPoint& seen = picture->acting.view;
  Backdrop backdrop;
  const Palette& p = theme().colours;
  const float grey[4] = {p.raised.x, p.raised.y, p.raised.z, 1};
  std::copy_n(grey, 4, backdrop.colour);
  if (!avatar.plate.empty()) {
    backdrop.plate = &views.plate.texture;
    // The plate was seen from one place; it fades as the view leaves that.
    const double away = picture->frame >= 0 ? 0 : std::hypot(seen.yaw_deg, seen.pitch_deg);
    backdrop.plate_share = std::clamp(1 - float(away) / kPlateFade_deg, 0.f, 1.f);
    if (picture->frame < 0) {
      backdrop.scale = float(seen.zoom);
      backdrop.shift_x = float(seen.shift_x), backdrop.shift_y = float(seen.shift_y);
    }
  }
  backdrop.exposure = std::exp2(views.exposure_ev);
  const ImTextureID shown = views.render->draw(int(place.size.x), int(place.size.y), backdrop);
  const ImVec2 end{place.at.x + place.size.x, place.at.y + place.size.y};
  ImGui::GetWindowDrawList()->AddImageRounded(shown, place.at, end, {0, 0}, {1, 1}, IM_COL32_WHITE, px(6));
  if (snapshot.comparing) {
    draw_wipe(snapshot.compare_picture, views, place);
    if (active && ImGui::IsMouseDown(ImGuiMouseButton_Left))
      views.wipe = std::clamp((ImGui::GetIO().MousePos.x - place.at.x) / place.size.x, 0.f, 1.f);
  } else {
    move_view(snapshot, place, hovered, active, requests);
  }
  if (let_go || (hovered && ImGui::GetIO().MouseWheel != 0)) requests.acting_finished = true;
}

class Sliders {
 public:
  Sliders(const Snapshot& snapshot, Requests& requests)
      : acting_(requests.acting.value_or(snapshot.acting)), requests_(requests) {}

  void row(const std::string& words, const std::string& id, float value, const SliderRange& range,
           const char* format, const std::function<void(Acting&, float)>& set) {
    const float start = ImGui::GetCursorPosX(), width = ImGui::GetContentRegionAvail().x,
                label = 0.42f * width;
    ImGui::AlignTextToFramePadding();
    clipped_text(words, label - px(6));
    ImGui::SameLine(start + label);
    if (slider(("##" + id).c_str(), &value, range, format, width - label)) {
      set(acting_, value);
      requests_.acting = acting_;
    }
    if (ImGui::IsItemDeactivated()) requests_.acting_finished = true;
  }
  const Acting& acting() const { return acting_; }

 private:
  Acting acting_;
  Requests& requests_;
};

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

void draw_presets(const Snapshot& snapshot, Requests& requests) {
  const float width = ImGui::GetContentRegionAvail().x, gap = px(6);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(4), ImGui::GetStyle().FramePadding.y));
  float widest = 0;
  for (const Preset& preset : presets())
    widest = std::max(widest, ImGui::CalcTextSize(preset.words.data()).x + px(10));
  const int wide = std::clamp(int((width + gap) / (widest + gap)), 1, 4), narrow = 5;
  int in_row = 0;
  bool vowels = false;
  for (const Preset& preset : presets()) {
    const bool vowel = preset.words.size() == 1;
    if (vowel && !vowels) in_row = 0, vowels = true;
    const int columns = vowel ? narrow : wide == 3 ? 2 : wide;
    if (in_row++ % columns != 0) ImGui::SameLine(0, gap);
    if (plain_button(preset.words.data(), true, (width - float(columns - 1) * gap) / float(columns))) {
      requests.acting = with_preset(snapshot.acting, preset, *snapshot.contents->model);
      requests.acting_finished = true;
    }
  }
  ImGui::PopStyleVar();
}

void draw_head_sliders(const SeenTurn& seen, Sliders& sliders) {
  const Acting a = sliders.acting();
  const float turn = float(kTurnLimit_deg);
  const auto range = [&](int axis) {
    return SliderRange{-turn, turn, float(seen.low_deg[axis]), float(seen.high_deg[axis])};
  };
  const SliderRange gaze{-1, 1};
  sliders.row("Turn", "turn", float(a.yaw_deg), range(0), "%.0f\u00b0",
              [](Acting& acting, float v) { acting.yaw_deg = v; });
  sliders.row("Nod", "nod", float(a.pitch_deg), range(1), "%.0f\u00b0",
              [](Acting& acting, float v) { acting.pitch_deg = v; });
  sliders.row("Tilt", "tilt", float(a.roll_deg), range(2), "%.0f\u00b0",
              [](Acting& acting, float v) { acting.roll_deg = v; });
  sliders.row("Look aside", "look aside", float(a.gaze_side), gaze, "%.2f",
              [](Acting& acting, float v) { acting.gaze_side = v; });
  sliders.row("Look up", "look up", float(a.gaze_up), gaze, "%.2f",
              [](Acting& acting, float v) { acting.gaze_up = v; });
}

void draw_action_sliders(const ActionGroup& group, const std::vector<SeenAction>& shown, Sliders& sliders) {
  for (const std::string& name : group.actions) {
    // Linked halves are one slider.
    const bool left = name.ends_with("_L"), right = name.ends_with("_R");
    if (sliders.acting().linked && right) continue;
    std::string words = action_words(name);
    if (sliders.acting().linked && left) words = words.substr(0, words.find(", left"));
    const auto seen = std::ranges::find(shown, name, &SeenAction::name);
    const bool known = seen != shown.end();
    const SliderRange range{0, 1, known ? std::max(0.f, seen->low) : 0,
                            known ? std::max(0.f, seen->high) : 0};
    sliders.row(words, name, amount_of(sliders.acting(), name), range, "%.2f",
                [&name](Acting& acting, float v) { set_amount(acting, name, v); });
  }
}

void draw_controls(const Snapshot& snapshot, Views& views, Requests& requests) {
  const DirectedAvatar& directed = *snapshot.contents->avatar;
  const Situation& now = snapshot.situation;
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - px(6));
  if (command_button(Command::undo, now, false, half)) requests.ask(Command::undo);
  ImGui::SameLine(0, px(6));
  if (command_button(Command::redo, now, false, half)) requests.ask(Command::redo);
  ImGui::BeginDisabled(snapshot.comparing);
  draw_presets(snapshot, requests);
  bool linked = snapshot.acting.linked;
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(3), px(2)));
  const bool relinked = ImGui::Checkbox("Link both sides", &linked);
  ImGui::PopStyleVar();
  if (relinked) {
    Acting acting = requests.acting.value_or(snapshot.acting);
    acting.linked = linked;
    requests.acting = acting;
    requests.acting_finished = true;
  }
  note_widget("Link both sides");
  Sliders sliders(snapshot, requests);
  std::size_t number = 0;
  if (group_heading("Head and gaze", views.open_groups[number]))
    draw_head_sliders(snapshot.contents->seen_turn, sliders);
  for (const ActionGroup& group : group_actions(*directed.model)) {
    number = std::min(number + 1, views.open_groups.size() - 1);
    ImGui::PushID(int(number));
    if (group_heading(group.words.c_str(), views.open_groups[number]))
      draw_action_sliders(group, directed.seen, sliders);
    ImGui::PopID();
  }
  ImGui::EndDisabled();
  ImGui::Dummy({0, px(4)});
  faint_text("Green under a slider: what the clip showed. Double click: back to none.");
}

// One line; what does not fit is in the menu Edit.
void draw_bar(const Snapshot& snapshot, Requests& requests) {
  const Situation& now = snapshot.situation;
  if (command_button(Command::compare, now, snapshot.comparing)) requests.ask(Command::compare);
  for (const Command command : {Command::reset_view, Command::reset_head, Command::reset_face}) {
    if (!same_line_if_fits(command_info(command).words.data())) break;
    if (command_button(command, now)) requests.ask(command);
  }
}

// Below the view: what the mouse does, and the brightness of the view.
void draw_foot(const Snapshot& snapshot, Views& views, float width) {
  const float start = ImGui::GetCursorPosX(), tuner = std::min(px(230), 0.5f * width);
  ImGui::AlignTextToFramePadding();
  ImGui::PushFont(theme().fonts.small);
  ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
  const std::string words =
      std::string(snapshot.comparing ? "Drag: wipe between avatar and clip"
                                     : "Drag: orbit  \u00b7  right: pan  \u00b7  wheel: zoom") +
      (snapshot.rendering ? "  \u00b7  refining\u2026" : "");
  const bool narrow = width < px(420);
  clipped_text(words, narrow ? width : width - tuner - px(70));
  ImGui::PopStyleColor();
  ImGui::PopFont();
  if (narrow) return;
  ImGui::SameLine(start + width - tuner - px(64));
  ImGui::TextUnformatted("Exposure");
  tooltip("Brightness of this view only. Double click: as filmed.");
  ImGui::SameLine(start + width - tuner + px(10));
  slider("##exposure", &views.exposure_ev, {.low = -2, .high = 2}, "%+.1f", tuner - px(10));
}

void draw_compare_strip(const Snapshot& snapshot, Requests& requests) {
  const std::vector<int> frames = shown_frames(*snapshot.contents, false);
  const Palette& p = theme().colours;
  std::vector<StripBar> bars;
  for (const int frame : frames) {
    const auto found = std::ranges::find(snapshot.contents->capture->frames, frame, &CaptureFrame::frame);
    const bool held_out = found->held_out;
    bars.push_back(
        {frame, 1, colour(held_out ? p.good : p.accent, 0.75f),
         fmt::format("Frame {}{}", frame, held_out ? ", held out: the training never saw it" : "")});
  }
  if (const auto clicked = draw_frame_strip("compare strip", bars, snapshot.compare_picture.frame, px(26)))
    requests.compare_frame = clicked;
}

}  // namespace

void draw_direct_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  if (!snapshot.contents || !snapshot.contents->avatar || !snapshot.contents->model) {
    draw_nothing_yet(
        "Here the avatar will turn its head, speak and smile. Make it first: the steps above lead there.");
    return;
  }
  const ImVec2 area = ImGui::GetContentRegionAvail();
  const float side = std::min(px(330), 0.42f * area.x);
  const float left = area.x - side - px(16);
  ImGui::BeginChild("stage", {left, area.y}, false,
                    ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  draw_bar(snapshot, requests);
  for (const std::string& words :
       beyond_seen(snapshot.acting, snapshot.contents->avatar->seen, snapshot.contents->seen_turn)) {
    if (snapshot.comparing) break;
    note(words.c_str(), Tone::warn, words);
  }
  if (snapshot.comparing) draw_compare_strip(snapshot, requests);
  const float foot = ImGui::GetFrameHeightWithSpacing();
  draw_view(snapshot, views, {left, std::max(px(100), ImGui::GetContentRegionAvail().y - foot)}, requests);
  draw_foot(snapshot, views, left);
  ImGui::EndChild();
  ImGui::SameLine(0, px(16));
  begin_card("controls", {side, area.y}, true);
  draw_controls(snapshot, views, requests);
  end_card();
}

}  // namespace likeness::ui
