// Step 4: the head model over the clip, and how well it fits in every frame.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/project/refits.h"
#include "core/track/clip/error_strip.h"
#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

const char* verdict(FrameStatus status) {
  return status == FrameStatus::good ? "good" : status == FrameStatus::weak ? "weak" : "lost";
}

ImVec4 verdict_ink(FrameStatus status) {
  const Palette& p = theme().colours;
  return status == FrameStatus::good ? p.good : status == FrameStatus::weak ? p.warn : p.bad;
}

bool is_left_out(const Snapshot& snapshot, int frame) {
  return std::ranges::binary_search(snapshot.project.contents->project.options.train.left_out, frame);
}

// Training frames can be left out by a click; held-out frames cannot, or the figures would flatter.
void draw_training_choice(const Snapshot& snapshot, int frame, Requests& requests) {
  const auto& frames = snapshot.project.contents->capture->frames;
  const auto own = std::ranges::find(frames, frame, &CaptureFrame::frame);
  if (own == frames.end()) return;
  std::vector<int> left_out = snapshot.project.contents->project.options.train.left_out;
  if (own->held_out) {
    faint_text("Held out: it measures the avatar and never trains. It cannot be left out.");
  } else if (!own->used) {
    faint_text("Refused by the check: it does not train.");
  } else if (is_left_out(snapshot, frame)) {
    body_text("Left out of the training.");
    if (plain_button("Use it again", !snapshot.situation.running)) {
      std::erase(left_out, frame);
      requests.project.left_out = left_out;
    }
  } else {
    if (plain_button("Leave it out of the training", !snapshot.situation.running)) {
      left_out.insert(std::ranges::upper_bound(left_out, frame), frame);
      requests.project.left_out = left_out;
    }
    tooltip("For frames in which the net does not lie on the face. The training then needs a new run.");
  }
  if (left_out.size() > 1 && !requests.project.left_out) {
    faint_text(fmt::format("{} frames are left out.", left_out.size()));
    if (plain_button("Use all again", !snapshot.situation.running))
      requests.project.left_out = std::vector<int>{};
  }
}

// "0 to 11, 40"
std::string frame_words(const std::vector<int>& frames) {
  std::string words;
  for (std::size_t i = 0, next = 0; i < frames.size(); i = next) {
    for (next = i + 1; next < frames.size() && frames[next] == frames[next - 1] + 1;) ++next;
    words += (words.empty() ? "" : ", ") + fmt::format("{}", frames[i]);
    if (next > i + 1) words += fmt::format(" to {}", frames[next - 1]);
  }
  return words;
}

// From which frames the resting face comes, and naming another. Held-out frames cannot be named.
void draw_rest(const Snapshot& snapshot, int frame, Requests& requests) {
  const ProjectContents& contents = *snapshot.project.contents;
  const std::vector<int>& asked = contents.project.options.fit.rest_frames;
  const RestChoice& rest = contents.track->rest;
  const bool idle = !snapshot.situation.running && snapshot.situation.consent;
  ImGui::Dummy({0, px(10)});
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("Resting face");
  ImGui::PopFont();
  if (!asked.empty()) {
    body_text(fmt::format("Frame {}, as you said.", frame_words(asked)));
    if (!rest.asked) faint_text("It is used by the next run.");
  } else if (!rest.frames.empty()) {
    body_text(fmt::format("{} {}.", rest.frames.size() == 1 ? "Frame" : "Frames", frame_words(rest.frames)));
    faint_text(rest.asked ? "It is chosen again by the next run." : rest.why);
  } else {
    faint_text("Every expression counts from the face at rest, which the fit finds in calm frames.");
  }
  if (!rest.warning.empty() && asked.empty()) body_text(rest.warning);
  const auto& frames = contents.capture->frames;
  const auto own = std::ranges::find(frames, frame, &CaptureFrame::frame);
  const bool named = std::ranges::binary_search(asked, frame);
  if (own != frames.end() && !own->held_out && !own->apart && !named) {
    if (plain_button("This is my resting face", idle)) requests.project.rest_frames = std::vector{frame};
    tooltip(
        "For a frame with the mouth closed and the face at ease, if a smile counts as rest. Face and avatar "
        "then need a new run.");
  }
  if (!asked.empty() && plain_button("Choose it again by itself", idle))
    requests.project.rest_frames = std::vector<int>{};
}

// What can be done with a marked span, and with one that was fitted again.
void draw_refit(const Snapshot& snapshot, const std::optional<RefitSpan>& marked, int frame,
                Requests& requests) {
  const ProjectContents& contents = *snapshot.project.contents;
  const bool idle = !snapshot.situation.running && snapshot.situation.consent;
  if (marked) {
    std::array<int, 3> count{};
    for (const TrackedFrame& f : contents.track->frames)
      if (f.frame >= marked->first && f.frame <= marked->last) ++count[std::size_t(f.status)];
    ImGui::PushFont(theme().fonts.strong);
    ImGui::Text("Frames %d to %d", marked->first, marked->last);
    ImGui::PopFont();
    body_text(fmt::format("{} good, {} weak, {} lost.", count[0], count[1], count[2]));
    if (plain_button("Fit this span again", idle && contents.clip.has_value()))
      requests.project.refit = marked;
    tooltip(
        "For a stretch in which the net does not lie on the face, between frames in which it does. Takes "
        "seconds; all other frames stay as they are.");
  }
  const auto done = std::ranges::find_if(contents.project.options.fit.refits, [&](const RefitSpan& span) {
    return marked ? span.first <= marked->last && marked->first <= span.last
                  : span.first <= frame && frame <= span.last;
  });
  if (done != contents.project.options.fit.refits.end()) {
    if (const RefitOutcome* outcome = find_refit(contents.refits, done->first))
      body_text(refit_words(*outcome));
    else
      faint_text("To be fitted again by the next run.");
    if (plain_button("Undo the re-fit", idle)) requests.project.take_back = *done;
  }
  if (marked || done != contents.project.options.fit.refits.end()) ImGui::Dummy({0, px(6)});
}

void draw_about(const Snapshot& snapshot, const TrackedFrame& frame, const std::optional<RefitSpan>& marked,
                Requests& requests) {
  draw_refit(snapshot, marked, frame.frame, requests);
  ImGui::PushFont(theme().fonts.strong);
  ImGui::Text("Frame %d", frame.frame);
  ImGui::SameLine();
  ImGui::TextColored(verdict_ink(frame.status), "%s", verdict(frame.status));
  ImGui::PopFont();
  if (!frame.reason.empty()) body_text(frame.reason);
  if (frame.status != FrameStatus::lost) {
    body_text(fmt::format("The model misses the face's points by {:.1f} px.", frame.inner_error_px));
    faint_text(fmt::format("The points themselves are uncertain by {:.1f} px.", mean_inner_spread(frame)));
  }
  if (snapshot.project.contents->capture) {
    draw_training_choice(snapshot, frame.frame, requests);
    draw_rest(snapshot, frame.frame, requests);
  }
  ImGui::Dummy({0, px(10)});
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("How to read it");
  ImGui::PopFont();
  faint_text(
      "The net lies on the skin of the head model and should move with the face. Points are green where "
      "certain, red where not. The two rays show where the eyes look.");
  ImGui::Dummy({0, px(10)});
  if (snapshot.project.contents->model) faint_text("Head model: " + snapshot.project.contents->model->name);
}

}  // namespace

void draw_face_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  draw_step_state(snapshot.step(Step::face));
  if (!snapshot.project.contents || !snapshot.project.contents->track ||
      snapshot.project.contents->track->frames.empty()) {
    draw_nothing_yet("Here the head model will lie over the clip, with how well it fits in every frame.");
    return;
  }
  const Track& track = *snapshot.project.contents->track;
  std::vector<double> errors;
  for (const TrackedFrame& frame : track.frames) errors.push_back(frame.inner_error_px);
  const auto most = errors.begin() + std::ptrdiff_t((errors.size() - 1) * 98 / 100);
  std::ranges::nth_element(errors, most);
  const double tall = std::max(1e-6, *most);
  std::vector<StripBar> bars;
  for (const TrackedFrame& frame : track.frames)
    bars.push_back({frame.frame, frame.status == FrameStatus::lost ? 1.f : float(frame.inner_error_px / tall),
                    colour(verdict_ink(frame.status)), is_left_out(snapshot, frame.frame),
                    find_refit(snapshot.project.contents->refits, frame.frame) != nullptr});
  const auto words = [&](std::size_t i) {
    const TrackedFrame& frame = track.frames[i];
    return fmt::format("Frame {}, {:.2f} s: {}{}{}{}", frame.frame, frame.time_s, verdict(frame.status),
                       frame.reason.empty() ? "" : ", " + frame.reason,
                       is_left_out(snapshot, frame.frame) ? ", left out of the training" : "",
                       find_refit(snapshot.project.contents->refits, frame.frame) ? ", fitted again" : "");
  };
  // A marked span belongs to one project: in another, the same numbers are other frames.
  if (views.face_span_of != snapshot.project.contents->project.folder) {
    views.face_span = {};
    views.face_span_of = snapshot.project.contents->project.folder;
  }
  const auto draw_strip = [&] {
    if (const auto clicked = draw_frame_strip("face strip", bars, snapshot.project.face_picture.frame, px(60),
                                              words, &views.face_span))
      requests.project.face_frame = clicked;
    faint_text(
        fmt::format("Height: how far the model misses the face's points, up to {:.1f} px. Click a frame to "
                    "see it, drag to mark a span.",
                    tall));
    ImGui::Dummy({0, px(2)});
  };
  const bool low = is_low();
  if (!low) draw_strip();
  const ImVec2 area = ImGui::GetContentRegionAvail();
  views.face.follow(snapshot.project.face_picture);
  begin_card("frame", {std::min(area.x * (low ? 0.5f : 0.64f), area.y), area.y});
  const ImVec2 room = ImGui::GetContentRegionAvail();
  if (!views.face.texture.empty()) {
    draw_picture("face picture", views.face.texture, room);
  } else {
    draw_nothing_yet(snapshot.project.face_picture.missing.empty()
                         ? "Reading\u2026"
                         : snapshot.project.face_picture.missing.c_str());
  }
  end_card();
  ImGui::SameLine(0, px(16));
  begin_card("about", {0, area.y}, true);
  if (low) draw_strip();
  if (const TrackedFrame* frame = find_tracked(track, snapshot.project.face_picture.frame))
    draw_about(snapshot, *frame, views.face_span.span, requests);
  end_card();
}

}  // namespace likeness::ui
