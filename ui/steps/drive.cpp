// What drives the avatar live: where it comes from, how it goes, and how much of it is carried over.
#include <fmt/format.h>

#include <algorithm>

#include "ui/steps.h"
#include "ui/studio/channel_words.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kMaxGain = 2;

std::string state_words(const LiveStatus& status) {
  switch (status.state) {
    case LiveState::opening:
      return "Opening\u2026";
    case LiveState::resting:
      return "Learning your resting face: look into the camera, relaxed.";
    case LiveState::driving:
      return "The avatar follows " + status.source + ".";
    case LiveState::lost:
      return "Your face is lost (" + status.reason + "): come nearer, face the camera, in even light.";
    case LiveState::ended:
      return "The end of " + status.source + ".";
    case LiveState::failed:
      return "Driving stopped.";
  }
  return {};
}

void draw_driver_picture(const LiveView& live, Views& views) {
  if (!live.status.picture) return;
  views.driver.follow(*live.status.picture, live.status.picture);
  if (views.driver.texture.empty()) return;
  const float height = px(84), width = height * float(views.driver.texture.width()) /
                                       std::max(1.f, float(views.driver.texture.height()));
  ImGui::Image(views.driver.texture.imgui_id(), {std::min(width, px(120)), height});
  note_widget("driver picture");
  ImGui::SameLine(0, px(10));
}

void draw_figures(const LiveView& live) {
  const LiveStatus& status = live.status;
  ImGui::BeginGroup();
  ImGui::PushFont(theme().fonts.small);
  const auto line = [](const std::string& words) { ImGui::TextUnformatted(words.c_str()); };
  line(live.shown_per_second > 0 ? fmt::format("{:.1f} pictures/s", live.shown_per_second)
                                 : std::string("\u2013 pictures/s"));
  line(live.latency_s > 0 ? fmt::format("{:.0f} ms behind", 1000 * live.latency_s)
                          : std::string("\u2013 ms behind"));
  line(fmt::format("{} dropped of {}", status.dropped, status.captured));
  if (status.recording) line(fmt::format("recorded {:.1f} s", status.recorded_s));
  ImGui::PopFont();
  ImGui::EndGroup();
  note_widget("live figures");
  tooltip(
      "Pictures shown per second; time from the capture of a picture to the avatar on the screen; pictures "
      "skipped because the one before was still being worked on.");
}

void draw_gains(const Snapshot& snapshot, Requests& requests) {
  std::map<std::string, float> gains = requests.direct.gains.value_or(snapshot.direct.live.gains);
  for (const NamedAction& action : snapshot.project.contents->model->actions) {
    if (action.name.ends_with("_R")) continue;
    const bool both = action.name.ends_with("_L");
    std::string words = action_words(action.name);
    if (both) words = words.substr(0, words.find(", left"));
    const auto own = gains.find(action.name);
    float gain = own == gains.end() ? 1 : own->second;
    const float start = ImGui::GetCursorPosX(), width = ImGui::GetContentRegionAvail().x,
                label = 0.42f * width;
    ImGui::AlignTextToFramePadding();
    clipped_text(words, label - px(6));
    ImGui::SameLine(start + label);
    if (!slider(("##gain " + action.name).c_str(), &gain, {0, kMaxGain, 0, 0, 1}, "%.2f", width - label))
      continue;
    gains[action.name] = gain;
    if (both) gains[action.name.substr(0, action.name.size() - 1) + "R"] = gain;
    std::erase_if(gains, [](const auto& entry) { return entry.second == 1; });
    requests.direct.gains = gains;
  }
}

}  // namespace

void draw_drive(const Snapshot& snapshot, Views& views, Requests& requests) {
  const LiveView& live = snapshot.direct.live;
  const Situation& now = snapshot.situation;
  const float width = ImGui::GetContentRegionAvail().x;
  if (!live.on) {
    if (!now.consent) faint_text("Say first, in the Film step, whether the filmed person agreed.");
    if (now.studying) faint_text("Methods are being compared: wait until that ends, or stop it first.");
    for (const Command command : {Command::drive_video, Command::drive_webcam})
      if (command_button(command, now, false, width)) requests.ask(command);
  } else {
    draw_driver_picture(live, views);
    draw_figures(live);
    const bool trouble = live.status.state == LiveState::lost || live.status.error;
    if (live.status.error) {
      note("live error", Tone::warn, live.status.error->what, live.status.error->fix);
    } else {
      note("live state", trouble ? Tone::warn : Tone::plain, state_words(live.status));
    }
    if (live.status.state == LiveState::resting) progress_bar(float(live.status.rest_share));
    for (const Command command : {Command::rest_face, Command::record_drive, Command::stop_driving}) {
      const bool recording = command == Command::record_drive && live.status.recording;
      if (command_button(command, now, recording, width)) requests.ask(command);
    }
  }
  if (group_heading("Gains", views.open_gains)) draw_gains(snapshot, requests);
}

}  // namespace likeness::ui
