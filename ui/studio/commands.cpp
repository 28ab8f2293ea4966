// The table of commands: see commands.h.
#include "ui/studio/commands.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/video/webcam.h"
#include "ui/studio/diagnostics.h"
#include "ui/studio/sessions.h"

namespace likeness::ui {

namespace {

using S = const Situation&;

bool always(S) { return true; }
bool with_project(S s) { return s.project; }
bool idle(S s) { return !s.running && !s.exporting && !s.recording && !s.studying; }
bool directing(S s) { return s.directing && s.avatar; }
bool stepping(S s) { return directing(s) || s.masking; }
bool undoes(S s) { return stepping(s) || s.choosing; }
bool chosen(S s) { return directing(s) && s.keys_chosen; }
bool can_drive(S s) { return directing(s) && s.consent && !s.driven && !s.studying; }
bool can_export(S s) {
  return s.avatar && s.consent && !s.look_only && (!s.running || s.paused) && !s.studying;
}

using To = const Sessions&;

template <WindowRequest wanted>
WindowRequest ask_window(To) {
  return wanted;
}

template <auto act>
WindowRequest on_project(To to) {
  (to.project.*act)();
  return WindowRequest::none;
}

template <auto act>
WindowRequest on_study(To to) {
  (to.study.*act)();
  return WindowRequest::none;
}

template <auto act>
WindowRequest on_recorder(To to) {
  (to.recorder.*act)();
  return WindowRequest::none;
}

template <auto act>
WindowRequest on_exports(To to) {
  (to.exports.*act)();
  return WindowRequest::none;
}

template <ExportKind kind>
WindowRequest export_now(To to) {
  const Directing& now = to.direct.directing();
  to.exports.start(kind, {now.performance(), now.playhead_s(), to.direct.gains()});
  return WindowRequest::none;
}

// After anything done to what is directed, a new picture is requested.
template <auto act, auto... with>
WindowRequest on_direct(To to) {
  (to.direct.*act)(with...);
  to.direct.request_picture();
  return WindowRequest::none;
}

template <auto act, auto... with>
WindowRequest on_directing(To to) {
  (to.direct.directing().*act)(with...);
  to.direct.request_picture();
  return WindowRequest::none;
}

// Acts on the masks where they are shown, otherwise on what is directed.
template <auto act_on_masks, auto act, auto... with>
WindowRequest where_shown(To to) {
  if (!to.masks.are_shown()) return on_directing<act, with...>(to);
  (to.masks.*act_on_masks)(with...);
  return WindowRequest::none;
}

// Of masks, of the camera's kind, or of what is directed: whatever is shown.
template <auto of_masks, auto of_camera, auto of_directing>
WindowRequest undo_where_shown(To to) {
  if (to.context.shown.step == Step::check) return on_project<of_camera>(to);
  return where_shown<of_masks, of_directing>(to);
}

template <int by>
WindowRequest step_on(To to) {
  const int step = std::clamp(int(to.context.shown.step) + by, 0, int(kSteps.size()) - 1);
  to.context.shown = {kSteps[std::size_t(step)], false};
  to.study.close_page();
  return WindowRequest::none;
}

template <int by>
WindowRequest rescale(To to) {
  int& percent = to.context.settings.scale_percent;
  percent = std::clamp(percent + by, kLeastScale, kMostScale);
  return WindowRequest::none;
}

WindowRequest write_diagnostics(To to) {
  const OpenProject& open = to.context.open;
  Notices& notices = to.context.notices;
  const auto out =
      (open.folder.empty() || open.look_only ? to.context.projects : open.folder) / "diagnostics.txt";
  if (const auto written = write_text(out, diagnostics_text(notices.error, open.contents.get())); !written) {
    notices.fail(written.error());
  } else {
    notices.message = "Written: " + out.string() + ". It contains no pictures.";
  }
  return WindowRequest::none;
}

WindowRequest record_clip(To to) {
  if (!to.recorder.is_on()) to.recorder.start(to.direct.take_driver());
  return WindowRequest::none;
}

WindowRequest try_demo(To to) {
  to.recorder.leave();
  to.project.film_demo();
  return WindowRequest::none;
}

WindowRequest drive_from_webcam(To to) {
  to.direct.drive([] { return open_webcam({}, kToDrive); });
  return WindowRequest::none;
}

WindowRequest start_study(To to) {
  if (!to.study.is_open()) to.study.open_page();
  to.masks.save();
  to.study.start(to.project.latest());
  return WindowRequest::none;
}

WindowRequest toggle_theme(To to) {
  to.context.settings.dark = !to.context.settings.dark;
  return WindowRequest::none;
}

constexpr CommandInfo kTable[] = {
    {Command::open_clip, Menu::file, "Open a clip...", "Ctrl+N", idle, ask_window<WindowRequest::pick_clip>},
    {Command::record_clip, Menu::file, "Record a clip...", "Ctrl+Shift+N",
     [](S s) { return idle(s) && !s.recorder; }, record_clip},
    {Command::start_recording, Menu::file, "Start recording", "Ctrl+T",
     [](S s) { return s.recorder && s.camera_ready; }, on_recorder<&RecordSession::record>},
    {Command::stop_recording, Menu::file, "Stop recording", "Ctrl+Shift+T",
     [](S s) { return s.can_stop_recording; }, on_recorder<&RecordSession::finish>},
    {Command::discard_recording, Menu::file, "Discard the recording", "",
     [](S s) { return s.can_stop_recording; }, on_recorder<&RecordSession::discard>},
    {Command::leave_recorder, Menu::file, "Back without a clip", "",
     [](S s) { return s.recorder && !s.recording; }, on_recorder<&RecordSession::leave>},
    {Command::open_project, Menu::file, "Open a project...", "Ctrl+O", idle,
     ask_window<WindowRequest::pick_project>},
    {Command::try_demo, Menu::file, "Try the demo", "", idle, try_demo},
    {Command::open_performance, Menu::file, "Open a performance...", "Ctrl+Shift+O", directing,
     ask_window<WindowRequest::pick_performance>, true},
    {Command::save_performance, Menu::file, "Save the performance as...", "Ctrl+Shift+S", directing,
     ask_window<WindowRequest::name_performance>},
    {Command::close_project, Menu::file, "Close the project", "Ctrl+W",
     [](S s) { return s.project && idle(s); }, on_project<&ProjectSession::close>, true},
    {Command::find_clip, Menu::file, "Find the clip...", "",
     [](S s) { return s.project && s.clip_missing && !s.look_only && idle(s); },
     ask_window<WindowRequest::find_clip>},
    {Command::add_clip, Menu::file, "Add a clip of this person...", "",
     [](S s) { return s.project && s.clip_there && s.consent && !s.look_only && idle(s); },
     ask_window<WindowRequest::pick_further_clip>},
    {Command::repair_project, Menu::file, "Repair the project", "",
     [](S s) { return s.repairable && idle(s); }, on_project<&ProjectSession::repair>},
    {Command::delete_person, Menu::file, "Delete this person...", "",
     [](S s) { return (s.project || s.damaged) && !s.look_only && idle(s); },
     ask_window<WindowRequest::delete_person>},
    {Command::choose_projects, Menu::file, "Folder of new projects...", "", [](S s) { return !s.recorder; },
     ask_window<WindowRequest::pick_projects>},
    {Command::quit, Menu::file, "Quit", "Ctrl+Q", always, ask_window<WindowRequest::quit>, true},
    {Command::undo, Menu::edit, "Undo", "Ctrl+Z", [](S s) { return undoes(s) && s.can_undo; },
     undo_where_shown<&MaskSession::undo, &ProjectSession::undo_camera, &Directing::undo>},
    {Command::redo, Menu::edit, "Redo", "Ctrl+Y", [](S s) { return undoes(s) && s.can_redo; },
     undo_where_shown<&MaskSession::redo, &ProjectSession::redo_camera, &Directing::redo>},
    {Command::copy_keys, Menu::edit, "Copy keys", "Ctrl+C", chosen, on_directing<&Directing::copy_selected>,
     true},
    {Command::paste_keys, Menu::edit, "Paste keys", "Ctrl+V",
     [](S s) { return directing(s) && s.keys_copied; }, on_directing<&Directing::paste>},
    {Command::delete_keys, Menu::edit, "Delete keys", "Delete", chosen,
     on_directing<&Directing::delete_selected>},
    {Command::choose_all_keys, Menu::edit, "Choose all keys", "Ctrl+A",
     [](S s) { return directing(s) && s.keys; }, on_directing<&Directing::select_all>},
    {Command::choose_keys_here, Menu::edit, "Choose the keys here", "Ctrl+D",
     [](S s) { return directing(s) && s.keys; }, on_directing<&Directing::select_here>},
    {Command::copy_pose, Menu::edit, "Copy the pose", "Ctrl+Shift+C", directing,
     on_directing<&Directing::copy_pose>, true},
    {Command::paste_pose, Menu::edit, "Paste the pose", "Ctrl+Shift+V",
     [](S s) { return directing(s) && s.pose_copied; }, on_directing<&Directing::paste_pose>},
    {Command::reset_face, Menu::edit, "Reset the face", "Ctrl+1", directing,
     on_direct<&DirectSession::rest, ChannelPart::face>, true},
    {Command::reset_head, Menu::edit, "Reset the head", "Ctrl+2", directing,
     on_direct<&DirectSession::rest, ChannelPart::head>},
    {Command::reset_view, Menu::edit, "Reset the view", "Ctrl+3", directing,
     on_direct<&DirectSession::rest, ChannelPart::camera>},
    {Command::play, Menu::timeline, "Play or stop", "Space", directing,
     on_direct<&DirectSession::toggle_playing>},
    {Command::repeat, Menu::timeline, "Repeat", "Ctrl+R", directing,
     on_directing<&Directing::toggle_looping>},
    {Command::record_keys, Menu::timeline, "Record keys", "Ctrl+Shift+R", directing,
     on_directing<&Directing::toggle_recording>},
    {Command::add_keys, Menu::timeline, "Add keys here", "Ctrl+I", [](S s) { return directing(s) && s.keys; },
     on_directing<&Directing::add_keys>, true},
    {Command::keys_earlier, Menu::timeline, "Move keys earlier", "Shift+Left", chosen,
     on_directing<&Directing::move_selected, -1>},
    {Command::keys_later, Menu::timeline, "Move keys later", "Shift+Right", chosen,
     on_directing<&Directing::move_selected, 1>},
    {Command::next_easing, Menu::timeline, "Next easing", "Ctrl+G", chosen,
     on_directing<&Directing::next_easing>},
    {Command::previous_picture, Menu::timeline, "Previous picture", "Ctrl+Left", stepping,
     where_shown<&MaskSession::step, &Directing::step_frames, -1>, true},
    {Command::next_picture, Menu::timeline, "Next picture", "Ctrl+Right", stepping,
     where_shown<&MaskSession::step, &Directing::step_frames, 1>},
    {Command::previous_key, Menu::timeline, "Previous key", "Ctrl+Shift+Left", directing,
     on_directing<&Directing::go_to_key, -1>},
    {Command::next_key, Menu::timeline, "Next key", "Ctrl+Shift+Right", directing,
     on_directing<&Directing::go_to_key, 1>},
    {Command::go_to_start, Menu::timeline, "Go to the start", "Home", directing,
     on_direct<&DirectSession::go_to_start>},
    {Command::go_to_end, Menu::timeline, "Go to the end", "End", directing,
     on_direct<&DirectSession::go_to_end>},
    {Command::random_walk, Menu::timeline, "Random walk", "Ctrl+J", directing,
     on_direct<&DirectSession::random_walk>, true},
    {Command::camera_orbit, Menu::timeline, "Camera orbit", "", directing,
     on_direct<&DirectSession::camera_orbit>},
    {Command::camera_dolly, Menu::timeline, "Camera dolly", "", directing,
     on_direct<&DirectSession::camera_dolly>},
    {Command::drive_video, Menu::avatar, "Drive from a video...", "Ctrl+Shift+D", can_drive,
     ask_window<WindowRequest::pick_driver>},
    {Command::drive_webcam, Menu::avatar, "Drive from the webcam", "Ctrl+Shift+W", can_drive,
     drive_from_webcam},
    {Command::rest_face, Menu::avatar, "This is my resting face", "Ctrl+0", [](S s) { return s.driven; },
     on_direct<&DirectSession::rest_driver>},
    {Command::record_drive, Menu::avatar, "Record the drive", "Ctrl+Shift+E", [](S s) { return s.driven; },
     on_direct<&DirectSession::toggle_drive_recording>},
    {Command::stop_driving, Menu::avatar, "Stop driving", "Ctrl+Shift+X", [](S s) { return s.driven; },
     on_direct<&DirectSession::stop_driving>},
    {Command::check_clip, Menu::avatar, "Check the clip", "Ctrl+K",
     [](S s) {
       return s.project && s.can_check && s.consent && !s.look_only && !s.running && !s.checking &&
              !s.studying;
     },
     on_project<&ProjectSession::check_clip>, true},
    {Command::make_avatar, Menu::avatar, "Make the avatar", "Ctrl+Enter",
     [](S s) {
       return s.project && s.clip_there && s.consent && !s.look_only && !s.faceless && !s.running &&
              !s.finished && !s.studying;
     },
     on_project<&ProjectSession::make_avatar>},
    {Command::pause, Menu::avatar, "Pause", "Ctrl+P", [](S s) { return s.running && !s.paused; },
     on_project<&ProjectSession::pause>},
    {Command::go_on, Menu::avatar, "Continue", "Ctrl+Shift+P", [](S s) { return s.running && s.paused; },
     on_project<&ProjectSession::go_on>},
    {Command::stop_work, Menu::avatar, "Stop", "", [](S s) { return s.running; },
     on_project<&ProjectSession::stop>},
    {Command::finish_now, Menu::avatar, "Finish with what is learnt", "", [](S s) { return s.training; },
     on_project<&ProjectSession::finish_training>},
    {Command::train_longer, Menu::avatar, "Train longer", "",
     [](S s) { return s.project && s.finished && s.consent && !s.look_only && !s.running && !s.studying; },
     on_project<&ProjectSession::train_longer>},
    {Command::compare_methods, Menu::avatar, "Compare with other methods...", "", with_project,
     on_study<&StudySession::open_page>, true},
    {Command::start_study, Menu::avatar, "Start the comparison", "",
     [](S s) {  // its times are those of the whole program
       return s.can_study && s.consent && !s.look_only && !s.running && !s.studying && !s.exporting &&
              !s.checking && !s.driven;
     },
     start_study},
    {Command::stop_study, Menu::avatar, "Stop the comparison", "", [](S s) { return s.studying; },
     on_study<&StudySession::stop>},
    {Command::show_study, Menu::avatar, "Show the comparison's folder", "", [](S s) { return s.studied; },
     on_study<&StudySession::show_results>},
    {Command::export_still, Menu::avatar, "Export a still", "Ctrl+E", can_export,
     export_now<ExportKind::still>, true},
    {Command::export_orbit, Menu::avatar, "Export an orbit", "", can_export, export_now<ExportKind::orbit>},
    {Command::export_performance, Menu::avatar, "Export the performance", "", can_export,
     export_now<ExportKind::performance>},
    {Command::export_driven, Menu::avatar, "Export a driven clip", "", can_export,
     export_now<ExportKind::driven>},
    {Command::export_mesh, Menu::avatar, "Export the head's mesh", "", can_export,
     export_now<ExportKind::mesh>},
    {Command::stop_export, Menu::avatar, "Stop all exports", "", [](S s) { return s.exporting; },
     on_exports<&ExportSession::stop_all>},
    {Command::show_exports, Menu::avatar, "Show the exports' folder", "", [](S s) { return s.avatar; },
     on_exports<&ExportSession::show_folder>},
    {Command::previous_step, Menu::view, "Previous step", "Ctrl+Up", with_project, step_on<-1>},
    {Command::next_step, Menu::view, "Next step", "Ctrl+Down", with_project, step_on<1>},
    {Command::compare, Menu::view, "Compare with the clip", "Ctrl+B",
     [](S s) { return directing(s) && !s.driven; }, on_direct<&DirectSession::toggle_comparing>, true},
    {Command::toggle_theme, Menu::view, "Light or dark", "Ctrl+L", always, toggle_theme, true},
    {Command::larger, Menu::view, "Larger", "Ctrl+Plus", always, rescale<kScaleStep>},
    {Command::smaller, Menu::view, "Smaller", "Ctrl+Minus", always, rescale<-kScaleStep>},
    {Command::film_guide, Menu::help, "How to film", "Ctrl+H", always, ask_window<WindowRequest::film_guide>},
    {Command::shortcuts, Menu::help, "Keyboard shortcuts", "F1", always,
     ask_window<WindowRequest::shortcuts>},
    {Command::licences, Menu::help, "Licences and privacy", "", always, ask_window<WindowRequest::licences>,
     true},
    {Command::save_diagnostics, Menu::help, "Save diagnostics", "", always, write_diagnostics},
};

}  // namespace

std::span<const CommandInfo> command_table() { return kTable; }

const CommandInfo& command_info(Command command) {
  const auto found = std::ranges::find(kTable, command, &CommandInfo::command);
  LIKENESS_CHECK(found != std::end(kTable), "command %d has no row", int(command));
  return *found;
}

std::string_view menu_words(Menu menu) {
  constexpr std::array<std::string_view, 6> kWords{"File", "Edit", "Timeline", "Avatar", "View", "Help"};
  return kWords[std::size_t(menu)];
}

bool is_enabled(Command command, const Situation& situation) {
  return command_info(command).enabled(situation);
}

Shortcut parse_shortcut(std::string_view text) {
  Shortcut shortcut;
  for (std::size_t plus; (plus = text.find('+')) != std::string_view::npos; text.remove_prefix(plus + 1)) {
    const std::string_view part = text.substr(0, plus);
    if (part == "Ctrl") shortcut.ctrl = true;
    if (part == "Shift") shortcut.shift = true;
  }
  shortcut.key = text;
  return shortcut;
}

}  // namespace likeness::ui
