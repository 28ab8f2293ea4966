// In place of the Train step, on request: avatars of this capture by other methods, and how close each comes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ui/keyboard.h"
#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

struct TableWords {
  const char *name, *words, *about;
};
constexpr TableWords kTables[] = {
    {"models", "Other methods",
     "Those of six papers and ours, each given the same time. Three of them learn slowly: their pictures are "
     "still blurred by then."},
    {"time", "How soon",
     "The best known of them given forty times that time, and ours given from a quarter of it to five times "
     "as much."},
    {"parts", "What each part brings", "Ours with one part more or less."}};

std::string seconds_words(double seconds) {
  return seconds < 60 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.3g} min", seconds / 60);
}

std::string long_words(double seconds) {
  if (seconds < 90) return "about a minute";
  const double minutes = std::ceil(seconds / 60);
  if (minutes < 90) return fmt::format("about {:.0f} min", minutes);
  return fmt::format("about {:.1f} h", minutes / 60);
}

std::string forecast_words(const StudyForecast& forecast) {
  if (forecast.finished == 0)
    return fmt::format("{} trainings: {}.", forecast.trainings, long_words(forecast.seconds));
  if (forecast.finished == forecast.trainings)
    return fmt::format("All {} trainings are finished already.", forecast.trainings);
  return fmt::format("{} of {} trainings are finished already; the others: {}.", forecast.finished,
                     forecast.trainings, long_words(forecast.left_seconds));
}

void draw_study_choices(const StudyChoice& now, Requests& requests) {
  StudyChoice asked = now;
  strong_text("What");
  for (const TableWords& table : kTables) {
    const auto at = std::ranges::find(asked.tables, table.name);
    bool on = at != asked.tables.end();
    if (tick_box(table.words, &on)) {
      if (on)
        asked.tables.emplace_back(table.name);
      else
        asked.tables.erase(at);
    }
    faint_text(table.about);
  }
  ImGui::Dummy({0, px(4)});
  strong_text("How long");
  faint_text("Each training, in seconds of the processor:");
  bool first = true;
  for (const double seconds : kStudySeconds) {
    const std::string words = seconds_words(seconds);
    if (!first) (void)same_line_if_fits((words + "    ").c_str());
    if (choice(words.c_str(), asked.seconds == seconds)) asked.seconds = seconds;
    first = false;
  }
  faint_text("Trained once, or three times to see what is chance:");
  constexpr std::array<const char*, std::size(kStudySeeds)> kTimes{"Once", "Three times"};
  for (std::size_t i = 0; i < kTimes.size(); ++i) {
    if (i > 0) (void)same_line_if_fits(kTimes[i]);
    if (choice(kTimes[i], asked.seeds == kStudySeeds[i])) asked.seeds = kStudySeeds[i];
  }
  if (!(asked == now)) requests.study.choice = asked;
}

// What the model that is being trained is called; a stage that is no model is shown by its name.
std::string model_words(const std::string& stage) {
  const auto spec = std::ranges::find(study_models(), stage, &ModelSpec::name);
  return spec == study_models().end() ? stage : spec->about;
}

void draw_work(const Snapshot& snapshot, Requests& requests) {
  const JobStatus& job = snapshot.study.job;
  const bool stopping = job.state == JobState::stopping;
  progress_bar(float(job.fraction));
  const std::string left = stopping ? "" : time_left(job.seconds_left);
  std::string words = stopping            ? "Stopping; what is finished is kept"
                      : job.text.empty()  ? "Reading the pictures"
                      : job.stage.empty() ? job.text
                                          : model_words(job.stage) + ", " + job.text;
  faint_text(words + (left.empty() ? "" : "  \u00b7  " + left));
  ImGui::Dummy({0, px(2)});
  if (command_button(Command::stop_study, snapshot.situation)) requests.ask(Command::stop_study);
  tooltip("An unfinished training starts afresh next time; finished ones are kept.");
}

// Drawn first, so that it is in sight whatever the size of the letters.
void draw_start(const Snapshot& snapshot, Requests& requests) {
  const StudyView& study = snapshot.study;
  const JobStatus& job = study.job;
  if (is_working(job)) {
    draw_work(snapshot, requests);
    return;
  }
  if (job.state == JobState::failed && job.error) note("failed", Tone::bad, job.error->what, job.error->fix);
  if (job.state == JobState::done) note("done", Tone::good, job.outcome);
  if (!study.missing.empty()) note("missing", Tone::warn, study.missing);
  const bool begun = study.forecast && study.forecast->finished > 0;
  const bool complete = begun && study.forecast->finished == study.forecast->trainings;
  if (primary_button(complete ? "Write the report again"
                     : begun  ? "Go on with the comparison"
                              : command_info(Command::start_study).words.data(),
                     is_enabled(Command::start_study, snapshot.situation)))
    requests.ask(Command::start_study);
  note_widget(command_info(Command::start_study).words.data());
  std::string words = study.choice.tables.empty() ? "Choose what to compare first."
                      : study.forecast            ? forecast_words(*study.forecast)
                                                  : "Estimating\u2026";
  if (snapshot.situation.exporting || snapshot.situation.checking || snapshot.situation.driven)
    words =
        "Something else is running, and its time would count as the methods': wait until it ends, or stop "
        "it.";
  if (snapshot.situation.running) words = "The avatar is being made: wait until it is done, or stop it.";
  if (!snapshot.situation.consent) words = "Say first, in the Film step, whether the filmed person agreed.";
  if (same_line_if_fits((words + "    ").c_str())) ImGui::AlignTextToFramePadding();
  body_text(words);
  if (!complete)
    faint_text(
        "The computer is busy for that time, and everything else on it is slower. Leave this window alone "
        "meanwhile: what it renders of the avatar counts as the methods' time. Stop it whenever you like: it "
        "continues where it stopped.");
}

std::string number(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "\u2013";
}

void draw_table(const SummaryTable& table) {
  strong_text(table.title.c_str());
  const bool wide = ImGui::GetContentRegionAvail().x > px(500);
  ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, ImVec2(px(6), px(3)));
  if (ImGui::BeginTable(table.name.c_str(), wide ? 7 : 5,
                        ImGuiTableFlags_BordersInnerH | ImGuiTableFlags_SizingFixedFit)) {
    ImGui::TableSetupColumn("Method", ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableSetupColumn("Picture");
    ImGui::TableSetupColumn("Head");
    ImGui::TableSetupColumn("Face");
    if (wide) ImGui::TableSetupColumn("\u00b1 head");
    if (wide) ImGui::TableSetupColumn("Training");
    ImGui::TableSetupColumn("Pictures/s");
    ImGui::TableHeadersRow();
    for (const SummaryRow& row : table.rows) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      clipped_text(row.about.empty() ? row.name : row.about, ImGui::GetContentRegionAvail().x);
      tooltip(row.name + (row.about.empty() ? "" : ": " + row.about) +
              (row.failed.empty() ? "" : "\nNot trained: " + row.failed));
      const auto cell = [](const std::string& words) {
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(words.c_str());
      };
      cell(number(row.psnr_db, 1)), cell(number(row.head_db, 1)), cell(number(row.face_db, 1));
      if (wide) cell(number(row.head_spread_db, 1));
      if (wide) cell(row.failed.empty() ? seconds_words(row.train_seconds) : "\u2013");
      cell(!row.failed.empty()
               ? "\u2013"
               : fmt::format("{:.{}f}", row.frames_per_second, row.frames_per_second < 1 ? 2 : 1));
    }
    ImGui::EndTable();
  }
  ImGui::PopStyleVar();
  note_view("study table " + table.name);
  ImGui::Dummy({0, px(6)});
}

void draw_results(const Snapshot& snapshot, Views& views, Requests& requests) {
  const StudyView& study = snapshot.study;
  if (study.unreadable) note("unreadable", Tone::warn, study.unreadable->what, study.unreadable->fix);
  if (!study.finished) {
    draw_nothing_yet(
        "Here the methods will stand side by side: how close each comes to frames it never saw, how long "
        "that took, and how fast it renders.");
    return;
  }
  const StudySummary& summary = study.finished->summary;
  if (command_button(Command::show_study, snapshot.situation)) requests.ask(Command::show_study);
  tooltip("report.html in it has all of this with pictures of the frames side by side.");
  faint_text(fmt::format(
      "Likeness in dB (PSNR) on {} frames of {} px that none of them had seen; more is closer. Times are "
      "processor time.",
      summary.frames, summary.size));
  ImGui::Dummy({0, px(4)});
  for (const SummaryTable& table : summary.tables) draw_table(table);
  views.study_plots.resize(std::max(views.study_plots.size(), study.finished->plots.size()));
  for (std::size_t i = 0; i < study.finished->plots.size(); ++i) {
    const Image8& picture = study.finished->plots[i];
    if (picture.empty()) continue;
    FollowedTexture& texture = views.study_plots[i];
    texture.follow(picture, std::shared_ptr<const void>(study.finished, &study.finished->plots[i]));
    if (texture.texture.empty()) continue;
    const float width = std::min(ImGui::GetContentRegionAvail().x, px(float(picture.width)));
    draw_picture(fmt::format("study plot {}", i).c_str(), texture.texture,
                 {width, width * float(picture.height) / float(picture.width)});
    faint_text(summary.plots[i].caption);
    ImGui::Dummy({0, px(6)});
  }
}

}  // namespace

void draw_study_page(const Snapshot& snapshot, Views& views, Requests& requests) {
  if (plain_button("Back to the training")) requests.study.close = true;
  ImGui::SameLine(0, px(14));
  ImGui::AlignTextToFramePadding();
  strong_text("Compare with other methods");
  const StudyView& study = snapshot.study;
  if (!study.missing.empty() && !study.finished) {
    draw_nothing_yet(study.missing.c_str());
    return;
  }
  ImGui::Dummy({0, px(2)});
  draw_start(snapshot, requests);
  ImGui::Dummy({0, px(2)});
  ImVec2 area = ImGui::GetContentRegionAvail();
  // Large letters leave no room for both side by side: the results are then below, reached by scrolling.
  const bool below = area.x < px(760);
  if (below) {
    ImGui::BeginChild("study page", area);
    scroll_by_keys();
    area = ImGui::GetContentRegionAvail();
  }
  begin_card("study choices",
             {below ? 0 : std::min(px(360), 0.4f * area.x), below ? views.study_choices : area.y}, true);
  ImGui::BeginDisabled(is_working(study.job));
  draw_study_choices(study.choice, requests);
  ImGui::EndDisabled();
  views.study_choices =
      ImGui::GetCursorPosY() - ImGui::GetStyle().ItemSpacing.y + ImGui::GetStyle().WindowPadding.y;
  end_card();
  if (!below) ImGui::SameLine(0, px(16));
  begin_card("study results", {0, below ? std::max(px(320), area.y) : area.y}, true);
  scroll_by_keys();
  draw_results(snapshot, views, requests);
  end_card();
  if (below) ImGui::EndChild();
}

}  // namespace likeness::ui
