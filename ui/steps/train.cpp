// Step 5: the avatar while it learns.
#include <fmt/format.h>

#include <algorithm>

#include "ui/steps/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

void draw_buttons(const Snapshot& snapshot, Requests& requests) {
  const Situation& now = snapshot.situation;
  if (now.running) {
    if (command_button(Command::pause, now, true)) requests.ask(Command::pause);
    ImGui::SameLine();
    if (command_button(Command::finish_now, now)) requests.ask(Command::finish_now);
    tooltip(
        "Ends the training and makes the avatar of what is learnt so far. Train longer goes on from there.");
  } else if (now.finished) {
    if (primary_button("Direct the avatar")) requests.show = Step::direct;
    ImGui::SameLine();
    if (command_button(Command::train_longer, now)) requests.ask(Command::train_longer);
    tooltip("Goes on where the training ended, for five minutes more.");
  } else {
    const bool stopped = snapshot.step(Step::train).state == StepState::needs_you;
    if (primary_button(stopped ? "Continue" : "Make the avatar", is_enabled(Command::make_avatar, now)))
      requests.ask(Command::make_avatar);
  }
}

void draw_numbers(const Snapshot& snapshot) {
  if (snapshot.pipeline.training.empty()) return;
  const TrainStatus& last = snapshot.pipeline.training.back();
  ImGui::SameLine(0, px(22));
  ImGui::AlignTextToFramePadding();
  ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
  clipped_text(
      fmt::format("{:.1f} dB   \u00b7   {:.0f} thousand rays a second   \u00b7   step {}   \u00b7   {}",
                  last.train_psnr_db, last.rays_per_s / 1000, last.step, duration(last.seconds)),
      ImGui::GetContentRegionAvail().x);
  ImGui::PopStyleColor();
}

void draw_preview(const char* name, FollowedTexture& texture, const Image8& image,
                  const std::shared_ptr<const void>& owner, const std::string& words, float side) {
  texture.follow(image, owner);
  ImGui::BeginGroup();
  if (texture.texture.empty()) {
    ImGui::Dummy({side, side});
  } else {
    draw_picture(name, texture.texture, {side, side});
  }
  ImGui::PushFont(theme().fonts.small);
  ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
  clipped_text(words, side);
  ImGui::PopStyleColor();
  ImGui::PopFont();
  ImGui::EndGroup();
}

void draw_previews(const std::shared_ptr<const PreviewPictures>& shown, Views& views, float side,
                   int columns) {
  const PreviewPictures& p = *shown;
  draw_preview("preview truth", views.previews[0], p.truth, shown,
               fmt::format("The clip, frame {}{}", p.frame, p.held_out ? " (held out)" : ""), side);
  ImGui::SameLine();
  draw_preview("preview same", views.previews[1], p.same, shown,
               fmt::format("The avatar there: {:.1f} dB", p.psnr_db), side);
  if (columns > 2) ImGui::SameLine();
  draw_preview("preview turned", views.previews[2], p.turned, shown, p.turned_words, side);
  ImGui::SameLine();
  draw_preview("preview expression", views.previews[3], p.expression, shown, p.expression_words, side);
}

}  // namespace

void draw_train_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  const StepView& view = snapshot.step(Step::train);
  draw_step_state(view);
  if (!snapshot.contents) {
    draw_nothing_yet("Here the avatar will be seen while it learns.");
    return;
  }
  draw_buttons(snapshot, requests);
  draw_numbers(snapshot);
  ImGui::Dummy({0, px(2)});
  const bool curve = snapshot.pipeline.training.size() >= 2;
  const PreviewPictures* pictures = snapshot.pipeline.preview.get();
  if (!curve && !pictures) {
    draw_nothing_yet(
        view.state == StepState::running
            ? "Reading the pictures. The curve and the first previews come in a moment."
        : view.state == StepState::done
            ? "The avatar is trained. The curve is drawn while a training runs: train longer to see it."
            : "Here the avatar will be seen while it learns: how near it is to the clip, new views and "
              "new expressions.");
    return;
  }
  const ImVec2 area = ImGui::GetContentRegionAvail();
  const ImVec2 spacing = ImGui::GetStyle().ItemSpacing, padding = ImGui::GetStyle().WindowPadding;
  const float words = ImGui::GetTextLineHeightWithSpacing();
  // In a low window the previews stand beside the curve, two by two.
  const bool low = area.y < px(360);
  const int columns = low ? 2 : 4;
  const float side = low ? std::max(px(30), 0.5f * (area.y - 2 * padding.y - spacing.y) - words)
                         : std::min((area.x - 2 * padding.x - 3 * spacing.x - px(2)) / 4, area.y * 0.46f);
  const ImVec2 previews{float(columns) * side + float(columns - 1) * spacing.x + 2 * padding.x + px(2),
                        side + words + 2 * padding.y + px(6)};
  begin_card("curve", low ? ImVec2(std::max(px(120), area.x - previews.x - spacing.x), area.y)
                          : ImVec2(0, std::max(px(120), area.y - previews.y - spacing.y)));
  if (curve) {
    views.chart.set(snapshot.pipeline.training, snapshot.pipeline.held_out);
    views.chart.draw("training curve", ImGui::GetContentRegionAvail());
  } else {
    draw_nothing_yet("The curve begins with the second report.");
  }
  end_card();
  if (low) ImGui::SameLine();
  begin_card("previews", {0, low ? area.y : previews.y});
  if (pictures) {
    draw_previews(snapshot.pipeline.preview, views, side, columns);
  } else {
    draw_nothing_yet("The first previews come in a moment.");
  }
  end_card();
}

}  // namespace likeness::ui
