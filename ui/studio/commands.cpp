// The table of commands: see commands.h.
#include "ui/studio/commands.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"

namespace likeness::ui {

namespace {

using S = const Situation&;

bool always(S) { return true; }
bool with_project(S s) { return s.project; }
bool idle(S s) { return !s.running && !s.exporting && !s.recording && !s.studying; }
bool directing(S s) { return s.directing && s.avatar; }
bool stepping(S s) { return directing(s) || s.masking; }
bool chosen(S s) { return directing(s) && s.keys_chosen; }
bool can_drive(S s) { return directing(s) && s.consent && !s.driven && !s.studying; }
bool can_export(S s) { return s.avatar && s.consent && (!s.running || s.paused) && !s.studying; }

constexpr CommandInfo kTable[] = {
    {Command::open_clip, Menu::file, "Open a clip...", "Ctrl+N", idle},
    {Command::record_clip, Menu::file, "Record a clip...", "Ctrl+Shift+N",
     [](S s) { return idle(s) && !s.recorder; }},
    {Command::start_recording, Menu::file, "Start recording", "Ctrl+T",
     [](S s) { return s.recorder && s.camera_ready; }},
    {Command::stop_recording, Menu::file, "Stop recording", "Ctrl+Shift+T",
     [](S s) { return s.can_stop_recording; }},
    {Command::discard_recording, Menu::file, "Discard the recording", "",
     [](S s) { return s.can_stop_recording; }},
    {Command::leave_recorder, Menu::file, "Back without a clip", "",
     [](S s) { return s.recorder && !s.recording; }},
    {Command::open_project, Menu::file, "Open a project...", "Ctrl+O", idle},
    {Command::try_demo, Menu::file, "Try the demo", "", idle},
    {Command::open_performance, Menu::file, "Open a performance...", "Ctrl+Shift+O", directing, true},
    {Command::save_performance, Menu::file, "Save the performance as...", "Ctrl+Shift+S", directing},
    {Command::close_project, Menu::file, "Close the project", "Ctrl+W",
     [](S s) { return s.project && idle(s); }, true},
    {Command::find_clip, Menu::file, "Find the clip...", "",
     [](S s) { return s.project && s.clip_missing && idle(s); }},
    {Command::add_clip, Menu::file, "Add a clip of this person...", "",
     [](S s) { return s.project && s.clip_there && s.consent && idle(s); }},
    {Command::repair_project, Menu::file, "Repair the project", "",
     [](S s) { return s.repairable && idle(s); }},
    {Command::delete_person, Menu::file, "Delete this person...", "",
     [](S s) { return (s.project || s.damaged) && idle(s); }},
    {Command::quit, Menu::file, "Quit", "Ctrl+Q", always, true},
    {Command::undo, Menu::edit, "Undo", "Ctrl+Z", [](S s) { return stepping(s) && s.can_undo; }},
    {Command::redo, Menu::edit, "Redo", "Ctrl+Y", [](S s) { return stepping(s) && s.can_redo; }},
    {Command::copy_keys, Menu::edit, "Copy keys", "Ctrl+C", chosen, true},
    {Command::paste_keys, Menu::edit, "Paste keys", "Ctrl+V",
     [](S s) { return directing(s) && s.keys_copied; }},
    {Command::delete_keys, Menu::edit, "Delete keys", "Delete", chosen},
    {Command::choose_all_keys, Menu::edit, "Choose all keys", "Ctrl+A",
     [](S s) { return directing(s) && s.keys; }},
    {Command::choose_keys_here, Menu::edit, "Choose the keys here", "Ctrl+D",
     [](S s) { return directing(s) && s.keys; }},
    {Command::copy_pose, Menu::edit, "Copy the pose", "Ctrl+Shift+C", directing, true},
    {Command::paste_pose, Menu::edit, "Paste the pose", "Ctrl+Shift+V",
     [](S s) { return directing(s) && s.pose_copied; }},
    {Command::reset_face, Menu::edit, "Reset the face", "Ctrl+1", directing, true},
    {Command::reset_head, Menu::edit, "Reset the head", "Ctrl+2", directing},
    {Command::reset_view, Menu::edit, "Reset the view", "Ctrl+3", directing},
    {Command::play, Menu::timeline, "Play or stop", "Space", directing},
    {Command::repeat, Menu::timeline, "Repeat", "Ctrl+R", directing},
    {Command::record_keys, Menu::timeline, "Record keys", "Ctrl+Shift+R", directing},
    {Command::add_keys, Menu::timeline, "Add keys here", "Ctrl+I", [](S s) { return directing(s) && s.keys; },
     true},
    {Command::keys_earlier, Menu::timeline, "Move keys earlier", "Shift+Left", chosen},
    {Command::keys_later, Menu::timeline, "Move keys later", "Shift+Right", chosen},
    {Command::next_easing, Menu::timeline, "Next easing", "Ctrl+G", chosen},
    {Command::previous_picture, Menu::timeline, "Previous picture", "Ctrl+Left", stepping, true},
    {Command::next_picture, Menu::timeline, "Next picture", "Ctrl+Right", stepping},
    {Command::previous_key, Menu::timeline, "Previous key", "Ctrl+Shift+Left", directing},
    {Command::next_key, Menu::timeline, "Next key", "Ctrl+Shift+Right", directing},
    {Command::go_to_start, Menu::timeline, "Go to the start", "Home", directing},
    {Command::go_to_end, Menu::timeline, "Go to the end", "End", directing},
    {Command::random_walk, Menu::timeline, "Random walk", "Ctrl+J", directing, true},
    {Command::camera_orbit, Menu::timeline, "Camera orbit", "", directing},
    {Command::camera_dolly, Menu::timeline, "Camera dolly", "", directing},
    {Command::drive_video, Menu::avatar, "Drive from a video...", "Ctrl+Shift+D", can_drive},
    {Command::drive_webcam, Menu::avatar, "Drive from the webcam", "Ctrl+Shift+W", can_drive},
    {Command::rest_face, Menu::avatar, "This is my resting face", "Ctrl+0", [](S s) { return s.driven; }},
    {Command::record_drive, Menu::avatar, "Record the drive", "Ctrl+Shift+E", [](S s) { return s.driven; }},
    {Command::stop_driving, Menu::avatar, "Stop driving", "Ctrl+Shift+X", [](S s) { return s.driven; }},
    {Command::check_clip, Menu::avatar, "Check the clip", "Ctrl+K",
     [](S s) { return s.project && s.can_check && s.consent && !s.running && !s.checking && !s.studying; },
     true},
    {Command::make_avatar, Menu::avatar, "Make the avatar", "Ctrl+Enter",
     [](S s) { return s.project && s.clip_there && s.consent && !s.running && !s.finished && !s.studying; }},
    {Command::pause, Menu::avatar, "Pause", "Ctrl+P", [](S s) { return s.running && !s.paused; }},
    {Command::go_on, Menu::avatar, "Continue", "Ctrl+Shift+P", [](S s) { return s.running && s.paused; }},
    {Command::stop_work, Menu::avatar, "Stop", "", [](S s) { return s.running; }},
    {Command::finish_now, Menu::avatar, "Finish with what is learnt", "", [](S s) { return s.training; }},
    {Command::train_longer, Menu::avatar, "Train longer", "",
     [](S s) { return s.project && s.finished && s.consent && !s.running && !s.studying; }},
    {Command::compare_methods, Menu::avatar, "Compare with other methods...", "", with_project, true},
    {Command::start_study, Menu::avatar, "Start the comparison", "",
     [](S s) {  // its times are those of the whole program
       return s.can_study && s.consent && !s.running && !s.studying && !s.exporting && !s.checking &&
              !s.driven;
     }},
    {Command::stop_study, Menu::avatar, "Stop the comparison", "", [](S s) { return s.studying; }},
    {Command::show_study, Menu::avatar, "Show the comparison's folder", "", [](S s) { return s.studied; }},
    {Command::export_still, Menu::avatar, "Export a still", "Ctrl+E", can_export, true},
    {Command::export_orbit, Menu::avatar, "Export an orbit", "", can_export},
    {Command::export_performance, Menu::avatar, "Export the performance", "", can_export},
    {Command::export_driven, Menu::avatar, "Export a driven clip", "", can_export},
    {Command::export_mesh, Menu::avatar, "Export the head's mesh", "", can_export},
    {Command::stop_export, Menu::avatar, "Stop all exports", "", [](S s) { return s.exporting; }},
    {Command::show_exports, Menu::avatar, "Show the exports' folder", "", [](S s) { return s.avatar; }},
    {Command::previous_step, Menu::view, "Previous step", "Ctrl+Up", with_project},
    {Command::next_step, Menu::view, "Next step", "Ctrl+Down", with_project},
    {Command::compare, Menu::view, "Compare with the clip", "Ctrl+B",
     [](S s) { return directing(s) && !s.driven; }, true},
    {Command::toggle_theme, Menu::view, "Light or dark", "Ctrl+L", always, true},
    {Command::larger, Menu::view, "Larger", "Ctrl+Plus", always},
    {Command::smaller, Menu::view, "Smaller", "Ctrl+Minus", always},
    {Command::film_guide, Menu::help, "How to film", "Ctrl+H", always},
    {Command::shortcuts, Menu::help, "Keyboard shortcuts", "F1", always},
    {Command::licences, Menu::help, "Licences and privacy", "", always, true},
    {Command::save_diagnostics, Menu::help, "Save diagnostics", "", always},
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
