// A clip from a webcam: the camera's picture as in a mirror, what to do in front of it, and the buttons.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/film_drawings.h"
#include "ui/letters.h"
#include "ui/shell.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

// A webcam's name; two of the same name are told apart by their devices.
std::string webcam_words(const std::vector<Webcam>& webcams, const Webcam& webcam) {
  const auto same = std::ranges::count(webcams, webcam.name, &Webcam::name);
  return same > 1 ? fmt::format("{} ({})", webcam.name, webcam.device) : webcam.name;
}

void draw_webcams(const RecorderStatus& status, Requests& requests) {
  if (status.webcams.size() < 2) return;
  const auto chosen = std::ranges::find(status.webcams, status.device, &Webcam::device);
  const Webcam& shown = chosen == status.webcams.end() ? status.webcams.front() : *chosen;
  ImGui::BeginDisabled(is_recording(status));
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  const bool open = ImGui::BeginCombo("##webcam", for_window(webcam_words(status.webcams, shown)).c_str());
  note_widget("webcams");
  if (open) {
    for (const Webcam& webcam : status.webcams) {
      const std::string words = webcam_words(status.webcams, webcam);
      if (ImGui::Selectable((for_window(words) + "##" + webcam.device).c_str(),
                            webcam.device == shown.device))
        requests.recorder.webcam = webcam.device;
      note_widget("webcam " + webcam.device);
    }
    ImGui::EndCombo();
  }
  ImGui::EndDisabled();
}

void draw_buttons(const Snapshot& snapshot, Requests& requests) {
  const bool recording = is_recording(*snapshot.recorder);
  const Command first = recording ? Command::stop_recording : Command::start_recording;
  const Command second = recording ? Command::discard_recording : Command::leave_recorder;
  if (command_button(first, snapshot.situation, true)) requests.ask(first);
  (void)same_line_if_fits(command_info(second).words.data());
  if (command_button(second, snapshot.situation)) requests.ask(second);
}

// A red dot and the time, in a corner of the picture.
void draw_recording_mark(const Fitted& picture, double seconds) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const std::string words = fmt::format("{}:{:02}", int(seconds) / 60, int(seconds) % 60);
  const ImVec2 text = ImGui::CalcTextSize(words.c_str());
  const ImVec2 at{picture.at.x + px(12), picture.at.y + px(12)};
  const ImVec2 end{at.x + text.x + px(40), at.y + text.y + px(12)};
  list.AddRectFilled(at, end, IM_COL32(0, 0, 0, 170), px(8));
  list.AddCircleFilled({at.x + px(17), 0.5f * (at.y + end.y)}, px(6), colour(theme().colours.bad));
  list.AddText({at.x + px(30), at.y + px(6)}, IM_COL32(255, 255, 255, 255), words.c_str());
  note_place("recording mark", at, end);
}

void draw_failure(const Snapshot& snapshot, Requests& requests) {
  const RecorderStatus& status = *snapshot.recorder;
  note("webcam error", Tone::bad, status.error->what, status.error->fix);
  ImGui::Dummy({0, px(4)});
  draw_webcams(status, requests);
  if (primary_button("Try again")) requests.recorder.webcam = status.device;
  (void)same_line_if_fits(command_info(Command::open_clip).words.data());
  if (command_button(Command::open_clip, snapshot.situation)) requests.ask(Command::open_clip);
  (void)same_line_if_fits(command_info(Command::leave_recorder).words.data());
  if (command_button(Command::leave_recorder, snapshot.situation)) requests.ask(Command::leave_recorder);
}

void draw_camera(const Snapshot& snapshot, Views& views, Requests& requests) {
  const RecorderStatus& status = *snapshot.recorder;
  if (status.error) return draw_failure(snapshot, requests);
  const float line = ImGui::GetFrameHeightWithSpacing();
  const float foot = (status.webcams.size() > 1 ? 2 : 1) * line;
  const ImVec2 at = ImGui::GetCursorPos(), room = ImGui::GetContentRegionAvail();
  const ImVec2 area{room.x, std::max(px(40), room.y - foot)};
  if (status.picture) {
    views.mirror.follow(*status.picture, status.picture);
    const Fitted place = draw_picture("mirror", views.mirror.texture, area, true);
    if (is_recording(status)) {
      draw_recording_mark(place, status.recorded_s);
    } else {
      draw_framing(*ImGui::GetWindowDrawList(), place.at, place.size);
    }
  } else {
    faint_text("Opening the webcam\u2026");
  }
  ImGui::SetCursorPos({at.x, at.y + area.y + ImGui::GetStyle().ItemSpacing.y});
  draw_webcams(status, requests);
  draw_buttons(snapshot, requests);
}

void draw_cue_list(std::size_t first) {
  int number = int(first);
  for (const FilmCue& cue : film_script().subspan(std::min(first, film_script().size()))) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    draw_mark(*ImGui::GetWindowDrawList(), {at.x + px(11), at.y + 0.5f * ImGui::GetTextLineHeight()}, px(20),
              StepMark::number, ++number);
    ImGui::Indent(px(32));
    faint_text(std::string(cue.words));
    ImGui::Unindent(px(32));
  }
}

// Drawings side by side, as large as the line and `most` allow.
void draw_drawings(std::initializer_list<FilmDrawing> drawings, float most) {
  const float count = float(drawings.size()), gap = px(8), width = ImGui::GetContentRegionAvail().x;
  const float side = std::min(most, (width - (count - 1) * gap) / count);
  ImVec2 at = ImGui::GetCursorScreenPos();
  for (const FilmDrawing drawing : drawings) {
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(at, {at.x + side, at.y + side}, colour(theme().colours.raised), px(8));
    draw_film_drawing(list, at, side, drawing);
    at.x += side + gap;
  }
  ImGui::Dummy({width, side});
}

void draw_before(Requests& requests, const Situation& now) {
  heading("Before you begin");
  draw_drawings({FilmDrawing::light, FilmDrawing::camera_rests, FilmDrawing::framing}, px(110));
  body_text(
      "Even light from the front, the camera at the height of the eyes, head and shoulders in the picture.");
  if (command_button(Command::film_guide, now)) requests.ask(Command::film_guide);
  ImGui::Dummy({0, px(4)});
  heading("Then, for about a minute");
  draw_cue_list(0);
}

void draw_during(const RecorderStatus& status) {
  const ScriptPlace place = script_place(status.recorded_s);
  const bool enough = place.cue == film_script().size();
  faint_text(duration(std::floor(status.recorded_s)) + (enough ? "" : " of about a minute"));
  progress_bar(float(status.recorded_s / film_script_s()));
  ImGui::Dummy({0, px(4)});
  if (enough) {
    heading("That is enough");
    body_text(fmt::format("Stop, or carry on as you like; it ends by itself after {:.0f} min.",
                          std::ceil(status.longest_s / 60)));
    return;
  }
  const FilmCue& cue = film_script()[place.cue];
  ImGui::PushFont(theme().fonts.heading);
  body_text(std::string(cue.words));
  note_widget("cue");
  ImGui::PopFont();
  // With large letters in a small window the drawing gets the height that the words leave.
  draw_drawings({cue.drawing}, std::clamp(ImGui::GetContentRegionAvail().y, px(60), px(160)));
  ImGui::Dummy({0, px(6)});
  draw_cue_list(place.cue + 1);
}

}  // namespace

void draw_record_page(const Snapshot& snapshot, Views& views, Requests& requests) {
  heading("Record a clip");
  faint_text("A phone's camera sees more than a webcam. Film only people who have agreed to it.");
  ImGui::Dummy({0, px(2)});
  const ImVec2 area = ImGui::GetContentRegionAvail();
  const float gap = px(16), left = 0.62f * (area.x - gap);
  begin_card("camera", {left, area.y});
  draw_camera(snapshot, views, requests);
  end_card();
  ImGui::SameLine(0, gap);
  begin_card("script", {0, area.y}, true);
  if (is_recording(*snapshot.recorder)) {
    draw_during(*snapshot.recorder);
  } else {
    draw_before(requests, snapshot.situation);
  }
  end_card();
}

}  // namespace likeness::ui
