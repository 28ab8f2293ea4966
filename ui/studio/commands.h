// Every action of the studio, once: its words, its keys, when it can be done and what does it. Menus, keys,
// buttons and the list under F1 are made from this table.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace likeness::ui {

enum class Command {
  open_clip,
  record_clip,
  start_recording,
  stop_recording,
  discard_recording,
  leave_recorder,
  open_project,
  try_demo,
  find_clip,
  add_clip,
  close_project,
  repair_project,
  delete_person,
  choose_projects,
  quit,
  check_clip,
  make_avatar,
  pause,
  go_on,
  stop_work,
  finish_now,
  train_longer,
  compare_methods,
  start_study,
  stop_study,
  show_study,
  undo,
  redo,
  reset_face,
  reset_head,
  reset_view,
  copy_keys,
  paste_keys,
  delete_keys,
  choose_all_keys,
  choose_keys_here,
  copy_pose,
  paste_pose,
  open_performance,
  save_performance,
  play,
  repeat,
  record_keys,
  add_keys,
  keys_earlier,
  keys_later,
  next_easing,
  previous_picture,
  next_picture,
  previous_key,
  next_key,
  go_to_start,
  go_to_end,
  random_walk,
  camera_orbit,
  camera_dolly,
  drive_video,
  drive_webcam,
  rest_face,
  record_drive,
  stop_driving,
  compare,
  previous_step,
  next_step,
  export_still,
  export_orbit,
  export_performance,
  export_driven,
  export_mesh,
  stop_export,
  show_exports,
  toggle_theme,
  larger,
  smaller,
  film_guide,
  shortcuts,
  licences,
  save_diagnostics
};

enum class Menu { file, edit, timeline, avatar, view, help };

// What decides which commands make sense now.
struct Situation {
  bool project = false;       // one is open
  bool clip_there = false;    // and its clip, or what was read of it
  bool clip_missing = false;  // the clip is not where it was
  bool look_only = false;     // another window shows the project, too: nothing of it is changed here
  bool damaged = false;       // the project asked for last cannot be read, and none is open
  bool repairable = false;    // but can be made anew
  bool running = false;       // its stages are at work
  bool paused = false;        // and wait where they are
  bool training = false;      // and it is the training
  bool finished = false;      // every stage is done
  bool interrupted = false;   // a stage was at work and goes on where it was
  bool avatar = false;        // it can be directed
  bool exporting = false;
  bool checking = false, can_check = false;  // the clip is being looked at; it could be
  bool directing = false;                    // the Direct step is shown
  bool masking = false;                      // the masks are shown; undo and redo are of their strokes
  bool choosing = false;  // the Check step is shown; undo and redo are of what the camera does
  bool can_undo = false, can_redo = false;
  bool keys = false, keys_chosen = false;  // the performance has keys; some are chosen
  bool keys_copied = false, pose_copied = false;
  bool driven = false;   // by a video or a webcam, live
  bool consent = false;  // the question of consent was answered
  // The capture check would have another clip; no avatar can be made of this one.
  bool film_again = false, faceless = false;
  // Other methods are being compared on this capture; they can be; there is a report of it.
  bool studying = false, can_study = false, studied = false;
  // A webcam is on to record a clip: nothing else is in sight. It gives pictures; they are kept; and not
  // brought to their end yet.
  bool recorder = false, camera_ready = false, recording = false, can_stop_recording = false;
};

// What the window is to do once the requests were carried out.
enum class WindowRequest {
  none,
  quit,
  pick_clip,
  pick_further_clip,
  pick_project,
  pick_projects,
  pick_performance,
  pick_driver,
  name_performance,
  film_guide,
  shortcuts,
  licences,
  find_clip,
  delete_person
};

struct Sessions;  // sessions.h

struct CommandInfo {
  Command command;
  Menu menu;
  std::string_view words;     // in menus and on buttons
  std::string_view shortcut;  // "Ctrl+O", "F1", "Space"; empty: none
  bool (*enabled)(const Situation&);
  WindowRequest (*carry_out)(const Sessions&);  // only where it is enabled
  bool begins_group = false;                    // in its menu: a line stands above it
};

std::span<const CommandInfo> command_table();
const CommandInfo& command_info(Command command);
std::string_view menu_words(Menu menu);
bool is_enabled(Command command, const Situation& situation);

// A shortcut taken apart. key: upper-case letter or digit, or the name: "F1", "Space", "Left", "Plus", ...
struct Shortcut {
  bool ctrl = false, shift = false;
  std::string key;
  bool operator==(const Shortcut&) const = default;
};
Shortcut parse_shortcut(std::string_view text);

}  // namespace likeness::ui
