// Step 2: the clip's frames - which train, which measure, which were refused and why.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

// Entries after the first stand beside the one before if there is room.
void legend(const ImVec4& ink, const std::string& words, bool first = false) {
  const float line = ImGui::GetTextLineHeight(),
              wide = 0.6f * line + px(6) + ImGui::CalcTextSize(words.c_str()).x,
              end = ImGui::GetWindowPos().x + ImGui::GetContentRegionMax().x;
  if (!first && ImGui::GetItemRectMax().x + px(22) + wide <= end) ImGui::SameLine(0, px(22));
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::GetWindowDrawList()->AddRectFilled({at.x, at.y + 0.2f * line},
                                            {at.x + 0.6f * line, at.y + 0.8f * line}, colour(ink), px(2));
  ImGui::Dummy({0.6f * line, line});
  ImGui::SameLine(0, px(6));
  body_text(words);
}

const char* fate(const CaptureFrame& frame) {
  return frame.used ? "trains" : frame.held_out ? "held out for measuring" : "refused";
}

// What the camera does, by the user's word: what --camera-kind says on the command line.
void draw_camera_choice(const Snapshot& snapshot, Requests& requests) {
  constexpr std::pair<const char*, std::optional<CameraKind>> kKinds[] = {
      {"Find out", std::nullopt},
      {"Resting", CameraKind::resting},
      {"Held in the hand", CameraKind::handheld},
      {"Walking", CameraKind::walking}};
  const ProjectContents& contents = *snapshot.project.contents;
  const auto chosen = contents.project.options.align.camera;
  ImGui::BeginDisabled(snapshot.situation.running);
  bool first = true;
  for (const auto& [words, kind] : kKinds) {
    if (!first) (void)same_line_if_fits(fmt::format("      {}", words).c_str());
    first = false;
    if (choice(words, chosen == kind)) requests.project.camera_kind = kind;
  }
  ImGui::EndDisabled();
  if (snapshot.project.can_undo_camera || snapshot.project.can_redo_camera) {
    if (command_button(Command::undo, snapshot.situation)) requests.ask(Command::undo);
    (void)same_line_if_fits(command_info(Command::redo).words.data());
    if (command_button(Command::redo, snapshot.situation)) requests.ask(Command::redo);
  }
  if (contents.cameras && contents.is_stale(Stage::align))
    faint_text("Make the avatar again: cameras and what follows are made by this choice.");
  else
    faint_text("Say it yourself where what was found is wrong.");
}

// What the clip is, in a sentence each; before the stages know it, by the capture check.
void draw_facts(const Snapshot& snapshot, Requests& requests) {
  const ProjectContents& contents = *snapshot.project.contents;
  const ClipFacts facts =
      snapshot.project.checked ? joined_facts(contents.facts, *snapshot.project.checked) : contents.facts;
  strong_text("What the camera does");
  body_text(camera_sentence(facts.camera));
  if (!facts.camera.evidence.empty()) faint_text(facts.camera.evidence);
  if (!contents.look_back.empty()) note("look back", Tone::warn, contents.look_back);
  draw_camera_choice(snapshot, requests);
  ImGui::Dummy({0, px(6)});
  strong_text("How far the mask is trusted");
  body_text(mask_sentence(facts.mask));
  ImGui::Dummy({0, px(6)});
  if (facts.parts.frames > 0) {
    strong_text("What serves");
    body_text(parts_sentence(facts.parts));
    ImGui::Dummy({0, px(6)});
  }
  if (!contents.background_fault.empty()) note("background", Tone::warn, contents.background_fault);
}

// What the capture check found; once the clip is imported, a remark's time leads to its frame.
void draw_verdict(const Snapshot& snapshot, Requests& requests) {
  if (snapshot.situation.checking) {
    body_text("Looking at the clip: " + snapshot.project.checking.text);
    progress_bar(float(snapshot.project.checking.fraction));
    return;
  }
  if (snapshot.project.checking.error && snapshot.project.checking.error->code != ErrorCode::cancelled)
    note("check failed", Tone::bad, snapshot.project.checking.error->what,
         snapshot.project.checking.error->fix);
  if (snapshot.project.verdict) {
    draw_verdict_note(*snapshot.project.verdict);
    int number = 0;
    for (const Remark& remark : snapshot.project.verdict->remarks) {
      ImGui::PushID(number++);
      note("remark", remark.grave ? Tone::bad : Tone::warn, remark.what, remark.remedy);
      const std::string when = fmt::format("{:.0f}\u2013{:.0f} s", remark.from_s, remark.to_s);
      if (!snapshot.project.contents->capture) {
        faint_text(when);
      } else if (plain_button(when.c_str())) {
        const auto& frames = snapshot.project.contents->capture->frames;
        const auto there = std::ranges::lower_bound(frames, remark.from_s, {}, &CaptureFrame::time_s);
        if (there != frames.end()) requests.project.check_frame = there->frame;
      }
      ImGui::PopID();
    }
  }
  if (command_button(Command::check_clip, snapshot.situation)) requests.ask(Command::check_clip);
  ImGui::Dummy({0, px(10)});
}

}  // namespace

void draw_check_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  draw_step_state(snapshot.step(Step::check));
  if (!snapshot.project.contents || !snapshot.project.contents->capture) {
    if (snapshot.project.contents &&
        (snapshot.project.verdict || snapshot.project.checking.state != JobState::none)) {
      begin_card("verdict card", ImGui::GetContentRegionAvail(), true);
      draw_verdict(snapshot, requests);
      draw_facts(snapshot, requests);
      end_card();
    } else {
      draw_nothing_yet(
          "Here the frames of the clip will stand side by side: which are taken, which are refused, and "
          "why.");
    }
    return;
  }
  const Capture& capture = *snapshot.project.contents->capture;
  const Palette& p = theme().colours;
  double sharpest = 1e-9;
  int used = 0, held_out = 0;
  std::map<std::string, int> refused;
  std::vector<StripBar> bars;
  for (const CaptureFrame& frame : capture.frames) sharpest = std::max(sharpest, frame.sharpness);
  for (const CaptureFrame& frame : capture.frames) {
    used += frame.used, held_out += frame.held_out;
    if (!frame.used && !frame.held_out) ++refused[frame.refused];
    bars.push_back({frame.frame, float(frame.sharpness / sharpest),
                    colour(frame.used       ? p.accent
                           : frame.held_out ? p.good
                                            : p.bad)});
  }
  const auto words = [&](std::size_t i) {
    const CaptureFrame& frame = capture.frames[i];
    return fmt::format("Frame {}, {:.2f} s: {}{}", frame.frame, frame.time_s, fate(frame),
                       frame.refused.empty() ? "" : ", " + frame.refused);
  };
  const auto draw_strip = [&] {
    legend(p.accent, fmt::format("{} train", used), true);
    legend(p.good, fmt::format("{} held out for measuring", held_out));
    legend(p.bad, fmt::format("{} refused", int(capture.frames.size()) - used - held_out));
    if (const auto clicked =
            draw_frame_strip("check strip", bars, snapshot.project.check_picture.frame, px(72), words))
      requests.project.check_frame = clicked;
    faint_text("Height: sharpness. Click a frame to see it.");
    ImGui::Dummy({0, px(2)});
  };
  const bool low = is_low();
  if (!low) draw_strip();
  const ImVec2 area = ImGui::GetContentRegionAvail();
  views.check.follow(snapshot.project.check_picture);
  begin_card("frame", {std::min(area.x * (low ? 0.5f : 0.6f), area.y), area.y});
  const ImVec2 room = ImGui::GetContentRegionAvail();
  if (!views.check.texture.empty()) {
    draw_picture("check picture", views.check.texture, room);
  } else {
    draw_nothing_yet(snapshot.project.check_picture.missing.empty()
                         ? "Reading\u2026"
                         : snapshot.project.check_picture.missing.c_str());
  }
  end_card();
  ImGui::SameLine(0, px(16));
  begin_card("about", {0, area.y}, true);
  if (low) draw_strip();
  draw_verdict(snapshot, requests);
  draw_facts(snapshot, requests);
  const auto chosen =
      std::ranges::find(capture.frames, snapshot.project.check_picture.frame, &CaptureFrame::frame);
  if (chosen != capture.frames.end()) {
    ImGui::PushFont(theme().fonts.strong);
    ImGui::Text("Frame %d", chosen->frame);
    ImGui::PopFont();
    body_text(fmt::format("{:.2f} s, {}.", chosen->time_s, fate(*chosen)));
    if (!chosen->refused.empty()) body_text("Reason: " + chosen->refused);
    ImGui::Dummy({0, px(10)});
  }
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("Refused frames");
  ImGui::PopFont();
  if (refused.empty()) faint_text("None: the clip is sharp throughout.");
  for (const auto& [reason, count] : refused)
    body_text(fmt::format("{} \u00d7 {}", count, reason.empty() ? "no reason given" : reason));
  end_card();
}

}  // namespace likeness::ui
