// Step 5: the avatar while it is trained.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

void draw_training_buttons(const Snapshot& snapshot, Requests& requests) {
  const Situation& now = snapshot.situation;
  if (now.running) {
    const Command next = now.paused ? Command::go_on : Command::pause;
    if (command_button(next, now, true)) requests.ask(next);
    tooltip(now.paused ? "Continues where it paused."
                       : "The work pauses where it is and keeps everything in memory.");
    ImGui::SameLine();
    if (command_button(Command::stop_work, now)) requests.ask(Command::stop_work);
    tooltip(
        "Ends the work and frees its memory. What is done is kept, and making the avatar continues from "
        "there.");
    ImGui::SameLine();
    if (command_button(Command::finish_now, now)) requests.ask(Command::finish_now);
    tooltip(
        "Ends the training and makes the avatar from what is learnt so far. Train longer continues from "
        "there.");
  } else if (now.finished) {
    if (primary_button("Direct the avatar")) requests.show = Step::direct;
    ImGui::SameLine();
    if (command_button(Command::train_longer, now)) requests.ask(Command::train_longer);
    tooltip("Trains for five more minutes, from where the training ended.");
  } else {
    draw_make_buttons(snapshot, requests);
  }
}

void draw_numbers(const Snapshot& snapshot) {
  if (snapshot.project.curve.training.empty()) return;
  const TrainStatus& last = snapshot.project.curve.training.back();
  const std::string words =
      fmt::format("{:.1f} dB   \u00b7   {:.0f} thousand rays a second   \u00b7   step {}   \u00b7   {}",
                  last.train_psnr_db, last.rays_per_s / 1000, last.step, duration(last.seconds));
  ImGui::SameLine(0, px(22));
  if (ImGui::CalcTextSize(words.c_str()).x <= ImGui::GetContentRegionAvail().x) {
    ImGui::AlignTextToFramePadding();
  } else {
    ImGui::NewLine();  // large letters: below the buttons
  }
  ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
  clipped_text(words, ImGui::GetContentRegionAvail().x);
  ImGui::PopStyleColor();
}

// Why the figures are the person's; empty: they are of whole pictures.
std::string why_of_person(const Snapshot& snapshot) {
  const std::string& fault = snapshot.project.contents->background_fault;
  const PreviewPictures* pictures = snapshot.project.pipeline.preview.get();
  if (!fault.empty() || !pictures || !pictures->of_person) return fault;
  return "What stands behind the person could not be learnt from this clip: a plain colour stands there.";
}

// Why the figures are the person's; where there is little room, in a line, and none beside a running
// training: there the picture's own words say whose figure it is, and why when the mouse rests on them.
void draw_background_fault(const std::string& fault, bool running) {
  if (fault.empty() || (running && is_low())) return;
  if (!is_low()) {
    note("background", Tone::warn, fault, "The figures are those of the person, without the background.");
    return;
  }
  ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.warn);
  clipped_text("Background not learnt: figures of the person.", ImGui::GetContentRegionAvail().x);
  ImGui::PopStyleColor();
  tooltip(fault);
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
  ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + side);
  ImGui::TextUnformatted(words.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
  ImGui::PopFont();
  ImGui::EndGroup();
}

std::string score_words(const PreviewPictures& p, bool low) {
  if (!p.of_person) return fmt::format("The avatar there: {:.1f} dB", p.psnr_db);
  if (low) return fmt::format("Person: {:.1f} dB", p.psnr_db);
  std::string words = fmt::format("The avatar there: person {:.1f} dB", p.psnr_db);
  if (p.head_db) words += fmt::format(", head {:.1f}", *p.head_db);
  if (p.face_db) words += fmt::format(", face {:.1f}", *p.face_db);
  return words;
}

std::array<std::string, 4> captions(const PreviewPictures& p, bool low) {
  return {low ? fmt::format("Frame {}", p.frame)
              : fmt::format("The clip, frame {}{}", p.frame, p.held_out ? " (held out)" : ""),
          score_words(p, low), p.turned_words, p.expression_words};
}

// Height of the tallest caption under a picture this wide.
float caption_height(const PreviewPictures* p, float side, bool low) {
  ImGui::PushFont(theme().fonts.small);
  float height = ImGui::GetTextLineHeight();
  if (p)
    for (const std::string& words : captions(*p, low))
      height = std::max(height, ImGui::CalcTextSize(words.c_str(), nullptr, false, side).y);
  ImGui::PopFont();
  return height + ImGui::GetStyle().ItemSpacing.y;
}

void draw_previews(const std::shared_ptr<const PreviewPictures>& shown, Views& views, float side, int columns,
                   const std::string& fault) {
  const PreviewPictures& p = *shown;
  const std::array<std::string, 4> words = captions(p, columns == 2);
  draw_preview("preview truth", views.previews[0], p.truth, shown, words[0], side);
  ImGui::SameLine();
  draw_preview("preview same", views.previews[1], p.same, shown, words[1], side);
  if (p.of_person && !fault.empty()) tooltip(fault);
  if (columns > 2) ImGui::SameLine();
  draw_preview("preview turned", views.previews[2], p.turned, shown, words[2], side);
  ImGui::SameLine();
  draw_preview("preview expression", views.previews[3], p.expression, shown, words[3], side);
}

// The curve, with the previews below or, in a low window, beside it.
void draw_learning(const Snapshot& snapshot, Views& views, bool running) {
  const bool curve = snapshot.project.curve.training.size() >= 2;
  const PreviewPictures* pictures = snapshot.project.pipeline.preview.get();
  if (!running && !pictures) {
    begin_card("curve");
    if (curve) {
      views.chart.set(snapshot.project.curve.training, snapshot.project.curve.held_out,
                      !why_of_person(snapshot).empty());
      views.chart.draw("training curve", ImGui::GetContentRegionAvail());
    } else {
      draw_nothing_yet("The avatar is trained. Its curve was not kept.");
    }
    end_card();
    return;
  }
  const ImVec2 area = ImGui::GetContentRegionAvail();
  const ImVec2 spacing = ImGui::GetStyle().ItemSpacing, padding = ImGui::GetStyle().WindowPadding;
  // In a low window the previews are two by two.
  const bool low = area.y < px(360);
  const int columns = low ? 2 : 4;
  const auto side_beside = [&](float words) {
    return low ? std::max(px(30), 0.5f * (area.y - 2 * padding.y - spacing.y) - words)
               : std::min((area.x - 2 * padding.x - 3 * spacing.x - px(2)) / 4, area.y * 0.46f);
  };
  // Large letters need more lines, which leave less for the pictures.
  float words = caption_height(pictures, side_beside(0), low), side = side_beside(words);
  words = caption_height(pictures, side, low), side = side_beside(words);
  const ImVec2 previews{float(columns) * side + float(columns - 1) * spacing.x + 2 * padding.x + px(2),
                        side + words + 2 * padding.y + px(6)};
  begin_card("curve", low ? ImVec2(std::max(px(120), area.x - previews.x - spacing.x), area.y)
                          : ImVec2(0, std::max(px(120), area.y - previews.y - spacing.y)));
  if (curve) {
    views.chart.set(snapshot.project.curve.training, snapshot.project.curve.held_out,
                    !why_of_person(snapshot).empty());
    views.chart.draw("training curve", ImGui::GetContentRegionAvail());
  } else {
    draw_nothing_yet("The curve begins with the second report.");
  }
  end_card();
  if (low) ImGui::SameLine();
  begin_card("previews", {0, low ? area.y : previews.y});
  if (pictures) {
    draw_previews(snapshot.project.pipeline.preview, views, side, columns, why_of_person(snapshot));
  } else {
    draw_nothing_yet("The first previews come in a moment.");
  }
  end_card();
}

// The parts chosen for the training under way; its card comes when it is done.
void draw_chosen(const std::vector<AvatarPart>& parts, Views& views) {
  if (!views.open_chosen) {
    draw_parts(parts, views.open_chosen);
    return;
  }
  begin_card("parts", {0, std::max(px(60), 0.4f * ImGui::GetContentRegionAvail().y)}, true);
  draw_parts(parts, views.open_chosen);
  end_card();
}

}  // namespace

void draw_train_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  if (snapshot.study.open && snapshot.project.contents) {
    draw_study_page(snapshot, views, requests);
    return;
  }
  const StepView& view = snapshot.step(Step::train);
  draw_step_state(view);
  if (!snapshot.project.contents) {
    draw_nothing_yet("Here the avatar will be seen while it learns.");
    return;
  }
  draw_training_buttons(snapshot, requests);
  draw_numbers(snapshot);
  draw_background_fault(why_of_person(snapshot), snapshot.situation.running);
  ImGui::Dummy({0, px(2)});
  const bool curve = snapshot.project.curve.training.size() >= 2;
  const PreviewPictures* pictures = snapshot.project.pipeline.preview.get();
  const Card* card = snapshot.situation.running ? nullptr : snapshot.project.contents->card.get();
  if (!curve && !pictures && !card) {
    draw_nothing_yet(
        view.state == StepState::running
            ? "Reading the pictures. The curve and the first previews come in a moment."
            : "Here the avatar will be seen while it learns: how near it is to the clip, new views and "
              "new expressions.");
    return;
  }
  if (!card && !snapshot.project.pipeline.parts.empty()) draw_chosen(snapshot.project.pipeline.parts, views);
  ImVec2 area = ImGui::GetContentRegionAvail();
  // Large letters leave no room for both side by side: the card is then below, reached by scrolling.
  const bool below = card && area.x < px(760);
  if (below) {
    ImGui::BeginChild("learning and card", area);
    area = {ImGui::GetContentRegionAvail().x, std::max(area.y, px(170))};
  } else if (card) {
    area.x = std::max(0.5f * area.x, area.x - px(400));
  }
  ImGui::BeginChild("learning", area);
  draw_learning(snapshot, views, view.state == StepState::running);
  ImGui::EndChild();
  if (!card) return;
  if (!below) ImGui::SameLine();
  begin_card("card", {0, below ? px(380) : area.y}, true);
  draw_card(snapshot, *card, views, requests);
  end_card();
  if (below) ImGui::EndChild();
}

}  // namespace likeness::ui
