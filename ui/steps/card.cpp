// The card of a trained avatar, beside its curve.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "core/train/choose_parts.h"
#include "ui/steps.h"
#include "ui/studio/channel_words.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

void title(const char* words) {
  ImGui::Dummy({0, px(4)});
  strong_text(words);
}

void draw_expressions(const Card& card) {
  constexpr const char* kTitles[] = {"Never seen", "Seen a little", "Learnt well"};
  const Palette& p = theme().colours;
  const ImVec4 inks[] = {p.bad, p.warn, p.good};
  for (const Learnt learnt : {Learnt::well, Learnt::little, Learnt::never}) {
    std::string names;
    for (const CardExpression& e : card.expressions) {
      if (e.learnt != learnt) continue;
      std::string words = action_words(e.name);
      if (!names.empty() && !words.empty())
        words[0] = char(std::tolower(static_cast<unsigned char>(words[0])));
      names += (names.empty() ? "" : ", ") + words;
    }
    ImGui::Dummy({0, px(2)});
    ImGui::PushStyleColor(ImGuiCol_Text, inks[std::size_t(learnt)]);
    ImGui::TextUnformatted(kTitles[std::size_t(learnt)]);
    ImGui::PopStyleColor();
    faint_text(names.empty() ? "Nothing." : names + ".");
  }
}

// The tracked frame in the middle of a moment.
std::optional<int> frame_at(const Track& track, const CardMoment& moment) {
  if (track.frames.empty()) return std::nullopt;
  const double middle = 0.5 * (moment.from_s + moment.to_s);
  return std::ranges::min_element(track.frames, {},
                                  [&](const TrackedFrame& frame) { return std::abs(frame.time_s - middle); })
      ->frame;
}

}  // namespace

void draw_parts(const std::vector<AvatarPart>& parts, bool& open) {
  if (!group_heading("Parts of this avatar, and why", open)) return;
  for (const AvatarPart& part : parts) {
    ImGui::Dummy({0, px(2)});
    ImGui::PushStyleColor(ImGuiCol_Text, part.on ? theme().colours.text : theme().colours.faint);
    body_text(fmt::format("{}: {}{}", part_title(part.name), part.value, part.asked ? " (your choice)" : ""));
    ImGui::PopStyleColor();
    faint_text(part.reason);
  }
}

void draw_card(const Snapshot& snapshot, const Card& card, Views& views, Requests& requests) {
  ImGui::PushFont(theme().fonts.heading);
  ImGui::TextUnformatted("What it learnt");
  ImGui::PopFont();
  body_text(fmt::format("{} frames trained; {} weak, {} lost, {} refused.", card.trained, card.weak,
                        card.lost, card.refused));
  body_text(
      fmt::format("Seen from {:.0f}\u00b0 on the right to {:.0f}\u00b0 on the left, {:.0f}\u00b0 below to "
                  "{:.0f}\u00b0 above.",
                  -card.low.yaw * kDegrees, card.high.yaw * kDegrees, -card.low.pitch * kDegrees,
                  card.high.pitch * kDegrees));
  draw_expressions(card);
  if (!card.parts.empty()) {
    ImGui::Dummy({0, px(4)});
    draw_parts(card.parts, views.open_parts);
    if (views.open_parts) {
      if (command_button(Command::compare_methods, snapshot.situation))
        requests.ask(Command::compare_methods);
      tooltip("Avatars of this clip by other methods, and by ours with a part more or less.");
    }
  }
  int number = 0;
  if (!card.gaps.empty()) title("To film in addition");
  for (const CardGap& gap : card.gaps) {
    ImGui::PushID(number++);
    note("gap", Tone::warn, gap.what, gap.film_again);
    ImGui::PopID();
  }
  if (!card.gaps.empty()) {
    if (command_button(Command::add_clip, snapshot.situation)) requests.ask(Command::add_clip);
    faint_text(
        "A clip that shows it may be of another day and place, best in similar light: what it shows of the "
        "head is learnt.");
  }
  title("The worst moments");
  if (card.worst.empty()) faint_text("None: the track is even.");
  for (const CardMoment& moment : card.worst) {
    ImGui::PushID(number++);
    note("moment", Tone::warn, moment.what, moment.film_again);
    const std::string when = fmt::format("Look at {:.1f}\u2013{:.1f} s", moment.from_s, moment.to_s);
    if (plain_button(when.c_str()) && snapshot.project.contents->track) {
      requests.project.face_frame = frame_at(*snapshot.project.contents->track, moment);
      requests.show = Step::face;
    }
    ImGui::PopID();
  }
}

}  // namespace likeness::ui
