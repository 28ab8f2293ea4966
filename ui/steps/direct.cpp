// Step 6: the avatar in a large view, and every control of it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/direct/soft_limit.h"
#include "ui/steps.h"
#include "ui/studio/channel_words.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kDegreesAPixel = 0.35f, kPlateFade_deg = 8;
constexpr float kRounding = 6;         // px, of the view's corners
constexpr float kNothingSeen = 0.02f;  // of a preset: less counts as not shown by the clip
constexpr float kMaxCovered = 0.2f;    // of the picture's height, by the note on it
constexpr const char* kBeyondInShort = "Beyond what the clip showed.";
constexpr const char* kNotHeldInShort = "Further than the avatar holds.";
constexpr double kFadeADistance = 40;  // degrees of turn that doubling the distance counts as

// A value that is dragged stops where the avatar stops to hold, unless Shift is held; a second drag goes on.
// Limits that were merely seen do not resist.
float resisted(const Snapshot& snapshot, Views& views, const std::string& channel, float before,
               float wanted) {
  const float began = views.drag_began.try_emplace(channel, before).first->second;
  const ProjectAvatar& avatar = *snapshot.project.contents->avatar;
  const auto limits = avatar.limits.find(channel);
  if (limits == avatar.limits.end() || !limits_hold(avatar.avatar, channel)) return wanted;
  return softly_limited(began, wanted, limits->second, ImGui::GetIO().KeyShift);
}

// What the mouse does to the camera: left orbits, right or middle pans, wheel zooms, with Ctrl it dollies.
void move_view(const Snapshot& snapshot, Views& views, const Fitted& place, bool hovered, bool active,
               Requests& requests) {
  const ImGuiIO& io = ImGui::GetIO();
  const DirectingView& directing = snapshot.direct.directing;
  Performance edited = requests.direct.start(directing);
  const ValueEdit at{directing.playhead_s, directing.record_keys};
  bool moved = false;
  const auto move = [&](const char* channel, const auto& change) {
    const ChannelScale scale = channel_scale(channel);
    const float before = value_at(edited, channel, at.time_s),
                after = resisted(snapshot, views, channel, before,
                                 std::clamp(change(before), scale.low, scale.high));
    if (after == before) return;
    set_value(edited, channel, after, at);
    moved = true;
  };
  if (active && ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0)) {
    const float turn = kDegreesAPixel / theme().scale;
    move("camera yaw", [&](float v) { return v - io.MouseDelta.x * turn; });
    move("camera pitch", [&](float v) { return v + io.MouseDelta.y * turn; });
  }
  if (active && (ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0) ||
                 ImGui::IsMouseDragging(ImGuiMouseButton_Middle, 0))) {
    const float width = std::max(1.f, place.size.x);
    move("camera shift x", [&](float v) { return v + io.MouseDelta.x / width; });
    move("camera shift y", [&](float v) { return v + io.MouseDelta.y / width; });
  }
  if (hovered && io.MouseWheel != 0) {
    if (io.KeyCtrl) {
      move("camera distance", [&](float v) { return v * std::pow(0.94f, io.MouseWheel); });
    } else {
      move("camera zoom", [&](float v) { return v * std::pow(1.12f, io.MouseWheel); });
    }
  }
  if (moved) requests.direct.edit(std::move(edited), "move the camera");
}

void draw_wipe(const FramePicture& picture, Views& views, const Fitted& place) {
  views.truth.follow(picture);
  if (views.truth.texture.empty()) return;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float x = place.at.x + views.wipe * place.size.x;
  const ImVec2 end{place.at.x + place.size.x, place.at.y + place.size.y};
  list.PushClipRect({x, place.at.y}, end, true);
  list.AddImageRounded(views.truth.texture.imgui_id(), place.at, end, {0, 0}, {1, 1}, IM_COL32_WHITE,
                       px(kRounding));
  list.PopClipRect();
  list.AddLine({x, place.at.y}, {x, end.y}, colour({1, 1, 1, 1}), px(2));
  list.AddCircleFilled({x, 0.5f * (place.at.y + end.y)}, px(9), colour({1, 1, 1, 1}));
  const auto label = [&](const std::string& words, float at, bool right) {
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    const float left = right ? at - size.x - px(20) : at;
    list.AddRectFilled({left, place.at.y + px(10)}, {left + size.x + px(20), place.at.y + px(18) + size.y},
                       colour({0, 0, 0, 0.55f}), px(5));
    list.AddText({left + px(10), place.at.y + px(14)}, colour({1, 1, 1, 1}), words.c_str());
  };
  if (views.wipe > 0.12f) label("Avatar", place.at.x + px(10), false);
  if (views.wipe < 0.88f) label(fmt::format("Clip, frame {}", picture.frame), end.x - px(10), true);
}

// At the foot of the picture: beside it, it would move the picture under the mouse that turns it. Where it
// would cover much of a small picture it is one line, and a tooltip shows the rest.
void draw_beyond(const BeyondSeen& beyond, const Fitted& place) {
  std::string words;
  for (const std::string& line : beyond_words(beyond)) words += (words.empty() ? "" : "\n") + line;
  if (words.empty()) return;
  const Palette& p = theme().colours;
  const float pad = px(10), mark = px(18), left = pad + mark + px(8),
              wrap = std::max(px(40), place.size.x - left - pad);
  ImVec2 size = ImGui::CalcTextSize(words.c_str(), nullptr, false, wrap);
  if (size.y + 2 * pad > kMaxCovered * place.size.y) {
    const std::string whole =
        std::exchange(words, shortened(beyond.checked ? kNotHeldInShort : kBeyondInShort, wrap));
    size = ImGui::CalcTextSize(words.c_str());
    const ImVec2 end{place.at.x + place.size.x, place.at.y + place.size.y};
    if (ImGui::IsMouseHoveringRect({place.at.x, end.y - size.y - 2 * pad}, end) && ImGui::IsItemHovered())
      ImGui::SetTooltip("%s", whole.c_str());
  }
  const ImVec2 high{place.at.x + place.size.x, place.at.y + place.size.y},
      low{place.at.x, high.y - size.y - 2 * pad};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(low, high, colour(p.panel, 0.9f), px(kRounding), ImDrawFlags_RoundCornersBottom);
  draw_mark(list, {low.x + pad + 0.5f * mark, low.y + pad + 0.5f * ImGui::GetTextLineHeight()}, mark,
            StepMark::attention, 0);
  list.AddText(ImGui::GetFont(), ImGui::GetFontSize(), {low.x + left, low.y + pad}, colour(p.text),
               words.c_str(), nullptr, wrap);
  note_place("beyond", low, high);
}

void draw_view(const Snapshot& snapshot, Views& views, ImVec2 area, Requests& requests) {
  const AvatarPicture* picture = snapshot.direct.picture.get();
  const Fitted place = fit_into(ImGui::GetCursorScreenPos(), area, 1, 1);
  requests.direct.view_px = int(place.size.x);
  ImGui::SetCursorScreenPos(place.at);
  ImGui::InvisibleButton("avatar view", {std::max(1.f, place.size.x), std::max(1.f, place.size.y)},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  note_view("avatar view");
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
  const Avatar& avatar = snapshot.project.contents->avatar->avatar;
  if (views.rendered.get() != picture) {
    views.render->set_picture(picture->rgba);
    views.rendered = snapshot.direct.picture;
  }
  if (!avatar.plate.empty()) views.plate.follow(avatar.plate, snapshot.project.contents->avatar);
  const ViewPoint& seen = picture->origin.view;
  Backdrop backdrop;
  const Palette& p = theme().colours;
  const float grey[4] = {p.raised.x, p.raised.y, p.raised.z, 1};
  std::copy_n(grey, 4, backdrop.colour);
  if (!avatar.plate.empty()) {
    backdrop.plate = &views.plate.texture;
    // The plate was seen from one place; it fades as the view leaves that place.
    const bool captured = picture->origin.frame >= 0;
    const double away = captured ? 0
                                 : std::hypot(seen.yaw, seen.pitch) * 180 / std::numbers::pi +
                                       kFadeADistance * std::abs(double(seen.distance) - 1);
    backdrop.plate_share = std::clamp(1 - float(away) / kPlateFade_deg, 0.f, 1.f);
    if (!captured) {
      backdrop.scale = seen.zoom;
      backdrop.shift_x = seen.shift_x, backdrop.shift_y = seen.shift_y;
    }
  }
  backdrop.doubt = float(picture->origin.doubt);
  backdrop.exposure = std::exp2(views.exposure_ev);
  const ImTextureID shown = views.render->draw(int(place.size.x), int(place.size.y), backdrop);
  const ImVec2 end{place.at.x + place.size.x, place.at.y + place.size.y};
  ImGui::GetWindowDrawList()->AddImageRounded(shown, place.at, end, {0, 0}, {1, 1}, IM_COL32_WHITE,
                                              px(kRounding));
  if (snapshot.direct.comparing) {
    draw_wipe(snapshot.direct.compare_picture, views, place);
    if (active && ImGui::IsMouseDown(ImGuiMouseButton_Left))
      views.wipe = std::clamp((ImGui::GetIO().MousePos.x - place.at.x) / place.size.x, 0.f, 1.f);
  } else {
    draw_beyond(snapshot.direct.directing.beyond, place);
    move_view(snapshot, views, place, hovered, active, requests);
  }
  if (let_go || (hovered && ImGui::GetIO().MouseWheel != 0)) requests.direct.finished = true;
}

// A slider of a channel at the playhead, with the range that holds, or that the clip showed.
void draw_channel(const Snapshot& snapshot, Views& views, const ChannelGroup& group,
                  const std::string& channel, Requests& requests) {
  const DirectingView& directing = snapshot.direct.directing;
  const auto& limits = snapshot.project.contents->avatar->limits;
  const float start = ImGui::GetCursorPosX(), width = ImGui::GetContentRegionAvail().x, label = 0.42f * width;
  std::string words = channel_words(channel), shown = words_within(group, channel);
  const bool both = directing.linked && channel.ends_with("_L");
  for (std::string* side : {&words, &shown})
    if (both) side->erase(side->find(", left"));
  ImGui::AlignTextToFramePadding();
  const bool animated = is_animated(*directing.performance, channel);
  if (animated) ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.accent);
  clipped_text(shown, label - px(6));
  if (animated) ImGui::PopStyleColor();
  ImGui::SameLine(start + label);
  ChannelScale scale = channel_scale(channel);
  // An attribute does not go beyond what was seen.
  for (const AttributeRegion& region : snapshot.project.contents->avatar->avatar.attributes)
    if (channel == action_channel(region.name)) scale.low = region.low, scale.high = region.high;
  SliderRange range{scale.low, scale.high, 0, 0, rest_value(channel)};
  if (const auto seen = limits.find(channel); seen != limits.end())
    range.seen_low = std::max(scale.low, seen->second.low),
    range.seen_high = std::min(scale.high, seen->second.high);
  const float before = value_at(*directing.performance, channel, directing.playhead_s);
  float value = before;
  if (slider(("##" + channel).c_str(), &value, range, scale.format, width - label)) {
    value = resisted(snapshot, views, channel, before, value);
    Performance edited = requests.direct.start(directing);
    set_value(edited, channel, value, directing.edit());
    requests.direct.edit(std::move(edited), words);
  }
  if (ImGui::IsItemDeactivated()) requests.direct.finished = true;
}

void draw_presets(const Snapshot& snapshot, Requests& requests) {
  const std::vector<Preset>& presets = snapshot.project.contents->avatar->presets;
  const float width = ImGui::GetContentRegionAvail().x, gap = px(6);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(4), ImGui::GetStyle().FramePadding.y));
  float widest = 0;
  for (const Preset& preset : presets)
    widest = std::max(widest, ImGui::CalcTextSize(preset_words(preset).c_str()).x + px(10));
  const int wide = std::clamp(int((width + gap) / (widest + gap)), 1, 4), narrow = 5;
  int in_row = 0;
  bool vowels = false;
  for (const Preset& preset : presets) {
    const bool vowel = preset.name.size() == 1;
    if (vowel && !vowels) in_row = 0, vowels = true;
    const int columns = vowel ? narrow : wide == 3 ? 2 : wide;
    if (in_row++ % columns != 0) ImGui::SameLine(0, gap);
    const bool nothing = preset.seen < kNothingSeen;
    if (plain_button(preset_words(preset).c_str(), !nothing,
                     (width - float(columns - 1) * gap) / float(columns))) {
      Performance edited = requests.direct.start(snapshot.direct.directing);
      apply_preset(edited, preset, snapshot.direct.directing.edit());
      requests.direct.edit(std::move(edited), preset_words(preset));
      requests.direct.finished = true;
    }
    if (nothing) {
      tooltip("The clip showed none of it.");
    } else if (preset.seen < 0.95f) {
      tooltip(fmt::format("As far as the clip showed it: {:.0f} % of the full preset.", 100 * preset.seen));
    }
  }
  ImGui::PopStyleVar();
}

// The command's button; its tooltip names the step.
void step_button(Command command, const Situation& now, const std::string& name, float width,
                 Requests& requests) {
  if (command_button(command, now, false, width)) requests.ask(command);
  if (!name.empty()) tooltip(fmt::format("{}: {}", command_info(command).words, name));
}

void draw_controls(const Snapshot& snapshot, Views& views, Requests& requests) {
  const Situation& now = snapshot.situation;
  const DirectingView& directing = snapshot.direct.directing;
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - px(6));
  step_button(Command::undo, now, directing.undo_name, half, requests);
  ImGui::SameLine(0, px(6));
  step_button(Command::redo, now, directing.redo_name, half, requests);
  if (group_heading("Drive live", views.open_drive)) draw_drive(snapshot, views, requests);
  ImGui::BeginDisabled(snapshot.direct.comparing);
  ImGui::Dummy({0, px(2)});
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("Expressions");
  ImGui::PopFont();
  draw_presets(snapshot, requests);
  bool linked = directing.linked;
  if (tick_box("Link both sides", &linked)) requests.direct.linked = linked;
  std::size_t number = 0;
  for (const ChannelGroup& group : group_channels(*snapshot.project.contents->model,
                                                  snapshot.project.contents->avatar->avatar.attributes)) {
    bool& open = views.open_groups[std::min(number, views.open_groups.size() - 1)];
    ImGui::PushID(int(number++));
    if (group_heading(group.words.c_str(), open))
      for (const std::string& channel : group.channels)
        if (!directing.linked || !channel.ends_with("_R"))
          draw_channel(snapshot, views, group, channel, requests);
    ImGui::PopID();
  }
  ImGui::EndDisabled();
  ImGui::Dummy({0, px(4)});
  const bool checked = snapshot.project.contents->avatar->avatar.holds.has_value();
  faint_text(checked ? "Green under a slider: what holds. It stops there; drag again, or hold Shift, to go "
                       "further. Double click: back to rest. Coloured words: keys on the timeline."
                     : "Green under a slider: what the clip showed. Double click: back to rest. Coloured "
                       "words: keys on the timeline.");
}

// One line; what does not fit is in the menu Edit.
void draw_bar(const Snapshot& snapshot, Requests& requests) {
  const Situation& now = snapshot.situation;
  if (command_button(Command::compare, now, snapshot.direct.comparing)) requests.ask(Command::compare);
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
      std::string(snapshot.direct.comparing ? "Drag: wipe between avatar and clip"
                                            : "Drag: orbit  \u00b7  right: pan  \u00b7  wheel: zoom") +
      (snapshot.direct.rendering ? "  \u00b7  refining\u2026" : "");
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
  const std::vector<int> frames = shown_frames(*snapshot.project.contents, false);
  const Palette& p = theme().colours;
  const auto held_out = [&](int frame) {
    const auto& all = snapshot.project.contents->capture->frames;
    return std::ranges::lower_bound(all, frame, {}, &CaptureFrame::frame)->held_out;
  };
  std::vector<StripBar> bars;
  for (const int frame : frames)
    bars.push_back({frame, 1, colour(held_out(frame) ? p.good : p.accent, 0.75f)});
  const auto words = [&](std::size_t i) {
    return fmt::format("Frame {}{}", frames[i],
                       held_out(frames[i]) ? ", held out: the training never saw it" : "");
  };
  if (const auto clicked =
          draw_frame_strip("compare strip", bars, snapshot.direct.compare_picture.frame, px(26), words))
    requests.direct.compare_frame = clicked;
}

}  // namespace

void draw_direct_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) views.drag_began.clear();
  if (!snapshot.project.contents || !snapshot.project.contents->avatar || !snapshot.project.contents->model) {
    draw_nothing_yet(
        "Here the avatar will turn its head, speak and smile. Make it first: the steps above lead to it.");
    return;
  }
  const ImVec2 area = ImGui::GetContentRegionAvail();
  const float side = std::min(px(350), 0.42f * area.x);
  const float left = area.x - side - px(16);
  ImGui::BeginChild("stage", {left, area.y}, false,
                    ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  draw_bar(snapshot, requests);
  if (snapshot.direct.comparing) draw_compare_strip(snapshot, requests);
  const bool low = is_low();  // the picture needs the foot's height more
  const float foot = low ? 0 : ImGui::GetFrameHeightWithSpacing(),
              timeline = timeline_height(snapshot, area.y);
  const float rest = foot + ImGui::GetStyle().ItemSpacing.y + timeline;
  draw_view(snapshot, views, {left, std::max(px(100), ImGui::GetContentRegionAvail().y - rest)}, requests);
  if (!low) draw_foot(snapshot, views, left);
  draw_timeline(snapshot, views, {left, timeline}, requests);
  ImGui::EndChild();
  ImGui::SameLine(0, px(16));
  begin_card("controls", {side, area.y}, true);
  draw_controls(snapshot, views, requests);
  end_card();
}

}  // namespace likeness::ui
