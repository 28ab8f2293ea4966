// The guided path down the side, and the bar at the bottom.
#include <fmt/format.h>

#include <algorithm>

#include "ui/keyboard.h"
#include "ui/shell.h"
#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

StepMark mark_of(StepState state) {
  switch (state) {
    case StepState::to_do:
      return StepMark::number;
    case StepState::loading:
    case StepState::running:
      return StepMark::running;
    case StepState::needs_you:
    case StepState::stale:
      return StepMark::attention;
    case StepState::failed:
      return StepMark::failed;
    case StepState::done:
      return StepMark::done;
  }
  return StepMark::number;
}

std::string state_words(const StepView& view) {
  switch (view.state) {
    case StepState::to_do:
      return "To do";
    case StepState::loading:
      return "Reading\u2026";
    case StepState::running: {
      if (view.paused) return "Paused";
      const std::string left = time_left(view.seconds_left);
      return left.empty() ? fmt::format("At work, {:.0f} %", 100 * view.fraction) : left;
    }
    case StepState::needs_you:
      return "Needs you";
    case StepState::stale:
      return "Needs a new run";
    case StepState::failed:
      return "Failed";
    case StepState::done:
      return "Done";
  }
  return {};
}

// height: of the row, px; a low row has no second line.
void draw_step_row(const Snapshot& snapshot, Step step, float height, Requests& requests) {
  const Palette& p = theme().colours;
  const StepView& view = snapshot.step(step);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const bool low = height < px(46);
  const bool chosen = snapshot.shown == step;
  if (ImGui::InvisibleButton(step_words(step).data(), {width, height})) requests.show = step;
  note_widget(std::string("step ") + step_words(step).data());
  draw_keyboard_ring();
  const bool hot = ImGui::IsItemHovered() || ImGui::IsItemFocused();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (chosen || hot)
    list.AddRectFilled(at, {at.x + width, at.y + height}, colour(p.raised, chosen ? 1 : 0.6f), px(8));
  if (chosen) list.AddRectFilled(at, {at.x + px(4), at.y + height}, colour(p.accent), px(3));
  draw_mark(list, {at.x + px(30), at.y + 0.5f * height}, std::min(px(26), 0.72f * height),
            mark_of(view.state), int(step) + 1);
  ImFont* strong = theme().fonts.strong;
  ImFont* small = theme().fonts.small;
  const float first = low ? 0.5f * (height - strong->FontSize) : 0.5f * height - px(19);
  list.AddText(strong, strong->FontSize, {at.x + px(54), at.y + first}, colour(p.text),
               step_words(step).data());
  const ImVec4 ink = view.state == StepState::failed                                        ? p.bad
                     : view.state == StepState::needs_you || view.state == StepState::stale ? p.warn
                     : view.state == StepState::running                                     ? p.accent
                                                                                            : p.faint;
  if (!low)
    list.AddText(small, small->FontSize, {at.x + px(54), at.y + 0.5f * height + px(3)}, colour(ink),
                 state_words(view).c_str());
  if (low) tooltip(state_words(view));
  if (view.state == StepState::running) {
    const float y = at.y + height - px(3), x = at.x + px(54), span = width - px(66);
    list.AddRectFilled({x, y}, {x + span, y + px(2)}, colour(p.line));
    list.AddRectFilled({x, y}, {x + span * float(view.fraction), y + px(2)}, colour(p.accent));
  }
}

// The one next thing to do, at the foot of the path.
void draw_next(const Snapshot& snapshot, Requests& requests) {
  const Situation& now = snapshot.situation;
  const float width = ImGui::GetContentRegionAvail().x;
  if (now.running) {
    const std::string left = time_left(snapshot.project.pipeline.job.seconds_left);
    ImGui::PushFont(theme().fonts.small);
    faint_text(snapshot.project.pipeline.job.state == JobState::stopping ? "Stopping\u2026"
               : now.paused   ? "Paused: nothing is lost, nothing is computed"
               : left.empty() ? "Making the avatar\u2026"
                              : "The avatar: " + left);
    ImGui::PopFont();
    progress_bar(float(snapshot.project.pipeline.job.fraction), 4);
    ImGui::PushID("path");
    const Command next = now.paused ? Command::go_on : Command::pause;
    if (command_button(next, now, now.paused, width)) requests.ask(next);
    ImGui::PopID();
  } else if (!now.finished && now.consent) {
    draw_make_buttons(snapshot, requests, width);
  }
}

}  // namespace

void draw_path(const Snapshot& snapshot, Requests& requests) {
  ImGui::PushFont(theme().fonts.strong);
  const std::string name =
      snapshot.project.contents ? snapshot.project.contents->project.folder.stem().string() : "Opening\u2026";
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + px(8));
  clipped_text(name, ImGui::GetContentRegionAvail().x - px(8));
  ImGui::PopFont();
  ImGui::Dummy({0, px(4)});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(px(10), px(4)));
  const float foot = 2 * ImGui::GetFrameHeightWithSpacing() + px(14);
  const float row = (ImGui::GetContentRegionAvail().y - foot) / float(kSteps.size()) - px(4);
  for (const Step step : kSteps) draw_step_row(snapshot, step, std::clamp(row, px(28), px(54)), requests);
  ImGui::PopStyleVar();
  if (ImGui::GetContentRegionAvail().y > foot)
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + ImGui::GetContentRegionAvail().y - foot);
  draw_next(snapshot, requests);
}

void draw_status_bar(const Snapshot& snapshot, Requests& requests) {
  (void)requests;
  const SystemStatus& system = snapshot.system;
  ImGui::PushFont(theme().fonts.small);
  ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
  std::string left = "Ready";
  if (snapshot.direct.live.on && snapshot.shown != Step::direct) {
    const LiveStatus& live = snapshot.direct.live.status;
    left = fmt::format("{} drives the avatar{}", live.source.empty() ? "A video or webcam" : live.source,
                       live.recording ? fmt::format(", recorded {:.1f} s", live.recorded_s) : "");
  }
  if (is_working(snapshot.project.demo)) left = "Filming the demo person";
  if (snapshot.project.pipeline.stage)
    left = fmt::format("{}: {}", stage_name(*snapshot.project.pipeline.stage),
                       snapshot.project.pipeline.job.text);
  if (is_working(snapshot.exports.status)) left = "Export: " + snapshot.exports.status.text;
  if (is_working(snapshot.study.job))
    left = fmt::format("Comparison: {:.0f} % done", 100 * snapshot.study.job.fraction);
  if (snapshot.recorder)
    left = is_recording(*snapshot.recorder) ? "A clip is being recorded"
           : snapshot.recorder->picture     ? "The webcam is on; nothing is recorded"
                                            : "Record a clip";
  if (snapshot.situation.look_only) left = "To look at only: the project is open in another window";
  if (snapshot.project.loading && !snapshot.recorder) left = "Reading the project";
  const std::string right =
      fmt::format("{}   \u00b7   {} threads   \u00b7   {:.1f} GB used, {:.1f} GB free", system.backend,
                  system.threads, double(system.memory) / 1e9, double(system.available) / 1e9);
  const float right_width = ImGui::CalcTextSize(right.c_str()).x;
  clipped_text(left, ImGui::GetContentRegionAvail().x - right_width - px(30));
  ImGui::SameLine(ImGui::GetContentRegionMax().x - right_width);
  ImGui::TextUnformatted(right.c_str());
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

}  // namespace likeness::ui
