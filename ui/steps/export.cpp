// Step 7: pictures and films of the avatar as it is posed.
#include <fmt/format.h>

#include <cmath>

#include "ui/channel_words.h"
#include "ui/steps/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kLabel = 110;

void slider_label(const char* words) {
  const float start = ImGui::GetCursorPosX();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(words);
  ImGui::SameLine(start + px(kLabel));
}

// The room stands behind a still only, as large as it was filmed, and from where the camera stood.
bool room_possible(const Snapshot& snapshot, const ExportChoice& asked) {
  return !snapshot.contents->avatar->avatar.plate.empty() && !asked.twice &&
         snapshot.directing.view == ViewPoint{};
}

void draw_choices(const Snapshot& snapshot, ExportChoice& asked) {
  const int size = snapshot.contents->avatar->avatar.size;
  choice_label("Size", px(kLabel));
  if (choice(fmt::format("{} px", size).c_str(), !asked.twice)) asked.twice = false;
  ImGui::SameLine();
  if (choice(fmt::format("{} px", 2 * size).c_str(), asked.twice)) asked.twice = true;
  choice_label("Background", px(kLabel));
  if (choice("Light", asked.ground == ExportGround::light)) asked.ground = ExportGround::light;
  ImGui::SameLine();
  if (choice("Dark", asked.ground == ExportGround::dark)) asked.ground = ExportGround::dark;
  ImGui::SameLine();
  ImGui::BeginDisabled(!room_possible(snapshot, asked));
  if (choice("The filmed room (stills)", asked.ground == ExportGround::room))
    asked.ground = ExportGround::room;
  ImGui::EndDisabled();
  if (!room_possible(snapshot, asked))
    tooltip("The room is known from where the camera stood only: reset the view, and keep the filmed size.");
  slider_label("Orbit");
  float angle = float(asked.half_angle_deg);
  if (slider("##orbit angle", &angle, {.low = 5, .high = kOrbitLimit_deg, .rest = 25}, "%.0f\u00b0", px(300)))
    asked.half_angle_deg = std::round(angle);
  ImGui::SameLine(0, px(14));
  ImGui::AlignTextToFramePadding();
  faint_text("to each side");
  slider_label("Length");
  float seconds = float(asked.frames / asked.frames_per_second);
  if (slider("##orbit length", &seconds, {.low = 0.4f, .high = 12, .rest = 4}, "%.1f s", px(300)))
    asked.frames = int(std::lround(seconds * asked.frames_per_second));
  ImGui::SameLine(0, px(14));
  ImGui::AlignTextToFramePadding();
  faint_text(fmt::format("{} pictures", asked.frames));
}

void draw_kind(const Snapshot& snapshot, Command command, const char* words, Requests& requests) {
  if (command_button(command, snapshot.situation, command == Command::export_still, px(290)))
    requests.ask(command);
  ImGui::SameLine(0, px(14));
  ImGui::AlignTextToFramePadding();
  faint_text(words);
}

}  // namespace

void draw_export_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  (void)views;
  const StepView& view = snapshot.step(Step::export_out);
  if (!snapshot.contents || !snapshot.contents->avatar) {
    draw_nothing_yet("Pictures and films of the avatar are written here, as soon as there is one.");
    return;
  }
  if (view.error) note("error", Tone::bad, view.error->what, view.error->fix);
  if (!snapshot.situation.consent)
    note("consent", Tone::warn, "Whether the filmed person agreed was not answered yet.",
         "Answer it in the step Film.");
  if (snapshot.situation.running)
    note("busy", Tone::plain, "The training is at work: pause or finish it before exporting.");
  if (!snapshot.exported.empty())
    note("done", Tone::good, snapshot.exported.filename().string() + " is written.",
         snapshot.exported.string());
  if (snapshot.exporting.state == JobState::stopped)
    note("stopped", Tone::plain, "The export was stopped; nothing half-written is left.");

  begin_card("choices",
             {0, ImGui::GetFrameHeightWithSpacing() * 4 + 2.2f * ImGui::GetStyle().WindowPadding.y +
                     ImGui::GetTextLineHeightWithSpacing()});
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("How");
  ImGui::PopFont();
  ExportChoice asked = snapshot.export_choice;
  draw_choices(snapshot, asked);
  if (asked.ground == ExportGround::room && !room_possible(snapshot, asked))
    asked.ground = ExportGround::light;
  if (!(asked == snapshot.export_choice)) requests.export_choice = asked;
  end_card();
  begin_card("what", {0, ImGui::GetFrameHeightWithSpacing() * 3 + 2.2f * ImGui::GetStyle().WindowPadding.y +
                             ImGui::GetTextLineHeightWithSpacing()});
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("What");
  ImGui::PopFont();
  draw_kind(snapshot, Command::export_still, "One PNG of the avatar as it stands in Direct.", requests);
  draw_kind(snapshot, Command::export_orbit, "An MP4: the view swings to both sides and back.", requests);
  draw_kind(snapshot, Command::export_sequence, "The orbit as PNGs with a transparent background.", requests);
  end_card();
  if (snapshot.situation.exporting) {
    begin_card("progress",
               {0, ImGui::GetFrameHeightWithSpacing() * 2.6f + ImGui::GetStyle().WindowPadding.y});
    progress_bar(float(view.fraction));
    const std::string left = time_left(view.seconds_left);
    faint_text(view.text + (left.empty() || view.text.empty() ? "" : "  \u00b7  ") + left);
    if (command_button(Command::stop_export, snapshot.situation)) requests.ask(Command::stop_export);
    end_card();
  }
  faint_text("Files go to " + (snapshot.contents->project.folder / "exports").string());
}

}  // namespace likeness::ui
