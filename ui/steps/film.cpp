// Step 1: the clip, the agreement of the person in it, and the one button.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/project/option_table.h"
#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

void draw_consent(const Snapshot& snapshot, Requests& requests) {
  const Consent answer = snapshot.project.contents->project.consent;
  if (answer == Consent::not_asked) {
    heading("Did the filmed person agree?");
    faint_text(
        "An avatar can be made to say and do what the person never did. Make one only of yourself, or of "
        "someone who knows what it is for and has agreed. The answer is kept in the project.");
    ImGui::Dummy({0, px(2)});
    if (primary_button("It is me")) requests.project.consent = Consent::own;
    ImGui::SameLine();
    if (primary_button("They agreed")) requests.project.consent = Consent::given;
    ImGui::SameLine();
    if (plain_button("No")) requests.project.nobody_agreed = true;
    return;
  }
  constexpr const char* kWords[] = {"", "The person in the clip is the one who makes the avatar.",
                                    "The person in the clip agreed.",
                                    "The person is the built-in demo: nobody real."};
  note("consent", Tone::good, kWords[std::size_t(answer)]);
}

// A row of buttons with the values offered for an option, the chosen one pressed. Returns the value that was
// clicked.
std::optional<double> draw_option(const OptionRow& row, double chosen) {
  const StudioField& field = row.studio;
  std::optional<double> clicked;
  choice_label(field.label, px(94));
  for (const double value : field.offered) {
    if (choice(fmt::format("{} {}", value / field.one_unit, field.unit).c_str(), chosen == value))
      clicked = value;
    ImGui::SameLine();
  }
  ImGui::NewLine();
  faint_text(field.hint);
  return clicked;
}

void draw_choices(const Snapshot& snapshot, Requests& requests) {
  const ProjectOptions& options = snapshot.project.contents->project.options;
  ImGui::BeginDisabled(snapshot.situation.running);
  if (const auto size = draw_option(option_row("size_px"), options.import.size))
    requests.project.picture_size = int(*size);
  const TrainChoices& train = options.train;
  const double seconds = train.full_budget_s > 0 ? train.full_budget_s : train.budget_s;
  const double chosen = train.steps > 0 ? 0 : seconds;  // 0: by steps, which no button offers
  if (const auto budget = draw_option(option_row("budget_s"), chosen)) requests.project.budget_s = budget;
  ImGui::EndDisabled();
}

// What the capture check says of the clip, before anything is made of it.
void draw_judgement(const Snapshot& snapshot) {
  if (snapshot.situation.checking) {
    faint_text("Looking at the clip\u2026");
    progress_bar(float(snapshot.project.checking.fraction), 4);
    return;
  }
  const CaptureVerdict* verdict = snapshot.project.verdict.get();
  if (!verdict || snapshot.project.contents->project.consent == Consent::no_real_person) return;
  std::string why;
  for (const Remark& remark : verdict->remarks)
    if (remark.grave) why += (why.empty() ? "" : "\n") + remark.what + " " + remark.remedy;
  if (verdict->verdict == Verdict::usable) why = "The Check step names them.";
  draw_verdict_note(*verdict, why);
}

// What making the avatar will take, before it starts.
void draw_plan(const Snapshot& snapshot, Requests& requests) {
  const Plan& plan = snapshot.project.contents->plan;
  if (!plan.forecast || plan.seconds == 0) return;
  const BuildForecast& forecast = *plan.forecast;
  std::string words = fmt::format("{} about {:.0f} min, {:.1f} GB of the disk and {:.1f} GB of memory.",
                                  snapshot.situation.interrupted ? "Still takes" : "Takes",
                                  std::max(1.0, std::ceil(plan.seconds / 60)), double(forecast.disk) / 1e9,
                                  double(forecast.memory) / 1e9);
  if (!snapshot.project.contents->is_current(Stage::align))
    words += fmt::format(" If the camera moves, {:.0f} min more.",
                         std::max(1.0, std::ceil(forecast.seconds_if_moving / 60)));
  faint_text(words);
  if (!plan.too_much) return;
  note("too much", Tone::warn, plan.too_much->what, plan.too_much->fix);
  if (!plan.smaller_size) return;
  if (primary_button(fmt::format("Make pictures of {} px instead", *plan.smaller_size).c_str()))
    requests.project.picture_size = plan.smaller_size;
}

void draw_facts(const Snapshot& snapshot) {
  const ProjectContents& contents = *snapshot.project.contents;
  ImGui::PushFont(theme().fonts.strong);
  clipped_text(contents.project.options.shared.video.filename().string(), ImGui::GetContentRegionAvail().x);
  ImGui::PopFont();
  if (contents.clip)
    faint_text(fmt::format("{} \u00d7 {} px, {:.0f} pictures a second, {:.0f} s, {}", contents.clip->width,
                           contents.clip->height, contents.clip->frames_per_second, contents.clip->duration_s,
                           contents.clip->codec));
  faint_text("Project: " + contents.project.folder.string());
}

// Further clips of the person, each with what was found in it.
void draw_further_clips(const Snapshot& snapshot, Requests& requests) {
  const ProjectContents& contents = *snapshot.project.contents;
  if (!contents.capture && contents.further.empty()) return;  // one clip is enough for a start
  heading("More clips of this person");
  for (const FurtherClip& further : contents.further) {
    ImGui::PushID(further.number);
    const float left = ImGui::GetCursorPosX(), room = ImGui::GetContentRegionAvail().x, button = px(84);
    ImGui::AlignTextToFramePadding();
    clipped_text(fmt::format("{}  {}", further.number, further.name), room - button - px(8));
    ImGui::SameLine();
    ImGui::SetCursorPosX(left + room - button);
    if (plain_button("Take out", is_enabled(Command::close_project, snapshot.situation), button))
      requests.project.remove_clip = further.number;
    if (further.state == StageState::failed) {
      note("failed", Tone::bad, further.words);
    } else {
      faint_text(further.state == StageState::done ? further.words : "Will be read in the next run.");
    }
    ImGui::PopID();
  }
  if (contents.further.empty())
    faint_text(
        "What this clip never shows - a side, a smile - another one can, filmed on another day or elsewhere, "
        "best in similar light. What it shows of the head is learnt; clothes, light and background stay this "
        "clip's.");
  if (command_button(Command::add_clip, snapshot.situation)) requests.ask(Command::add_clip);
}

}  // namespace

void draw_film_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  const StepView& view = snapshot.step(Step::film);
  if (!snapshot.project.contents) {
    draw_nothing_yet("Reading the project\u2026");
    return;
  }
  if (view.error) note("error", Tone::bad, view.error->what, view.error->fix);
  const ImVec2 area = ImGui::GetContentRegionAvail();
  const float left = std::max(px(220), std::min(area.x * 0.46f, area.y - px(10)));
  views.clip.follow(snapshot.project.clip_picture);
  begin_card("clip", {left, area.y});
  const ImVec2 room = ImGui::GetContentRegionAvail();
  if (!views.clip.texture.empty()) {
    draw_picture("clip picture", views.clip.texture, room);
  } else {
    draw_nothing_yet(snapshot.project.clip_picture.missing.empty()
                         ? "Reading the clip\u2026"
                         : snapshot.project.clip_picture.missing.c_str());
  }
  end_card();
  ImGui::SameLine(0, px(16));
  begin_card("facts", {0, area.y}, true);
  draw_facts(snapshot);
  if (snapshot.situation.clip_missing &&
      command_button(Command::find_clip, snapshot.situation, !snapshot.situation.finished))
    requests.ask(Command::find_clip);
  ImGui::Dummy({0, px(6)});
  draw_consent(snapshot, requests);
  if (snapshot.project.contents->project.consent != Consent::not_asked) {
    ImGui::Dummy({0, px(8)});
    const Situation& now = snapshot.situation;
    if (now.running) {
      const Command next = now.paused ? Command::go_on : Command::pause;
      if (command_button(next, now, now.paused)) requests.ask(next);
      ImGui::SameLine();
      if (command_button(Command::stop_work, now)) requests.ask(Command::stop_work);
      faint_text(now.paused
                     ? "Paused: the work waits where it is. Stop frees its memory and keeps what is done."
                     : "At work. What is done is kept when you stop.");
    } else if (now.finished) {
      if (primary_button("Direct the avatar")) requests.show = Step::direct;
    } else {
      draw_judgement(snapshot);
      draw_make_buttons(snapshot, requests);
      if (!now.faceless) draw_plan(snapshot, requests);
      if (!now.film_again)
        faint_text(now.clip_there
                       ? "Checks the clip, finds cameras and face, and trains. You can pause at any time."
                       : "The clip must be readable first.");
    }
    ImGui::Dummy({0, px(6)});
    draw_further_clips(snapshot, requests);
    ImGui::Dummy({0, px(6)});
    if (group_heading("More choices", views.more_choices)) draw_choices(snapshot, requests);
  }
  end_card();
}

}  // namespace likeness::ui
