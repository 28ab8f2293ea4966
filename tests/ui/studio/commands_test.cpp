// Claims about the table of commands: nothing twice, every key can be typed, and what makes sense when.
#include "ui/studio/commands.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace likeness::ui {
namespace {

TEST(Commands, NothingStandsTwice) {
  std::set<Command> commands;
  std::set<std::string_view> words, keys;
  for (const CommandInfo& info : command_table()) {
    EXPECT_TRUE(commands.insert(info.command).second) << info.words;
    EXPECT_TRUE(words.insert(info.words).second) << info.words;
    EXPECT_TRUE(info.shortcut.empty() || keys.insert(info.shortcut).second) << info.shortcut;
    EXPECT_FALSE(info.words.empty());
    EXPECT_NE(info.carry_out, nullptr) << info.words;
  }
  for (int c = 0; c <= int(Command::save_diagnostics); ++c) EXPECT_TRUE(commands.contains(Command(c))) << c;
}

TEST(Commands, ShortcutsAreTakenApart) {
  EXPECT_EQ(parse_shortcut("Ctrl+Shift+S"), (Shortcut{true, true, "S"}));
  EXPECT_EQ(parse_shortcut("F1"), (Shortcut{false, false, "F1"}));
  EXPECT_EQ(parse_shortcut("Ctrl+Plus"), (Shortcut{true, false, "Plus"}));
}

TEST(Commands, AnAvatarNeedsAProjectAndAnAnswer) {
  Situation now;
  EXPECT_FALSE(is_enabled(Command::make_avatar, now));
  now.project = true;
  EXPECT_FALSE(is_enabled(Command::make_avatar, now));
  now.consent = true;
  EXPECT_FALSE(is_enabled(Command::make_avatar, now));
  now.clip_there = true;
  EXPECT_TRUE(is_enabled(Command::make_avatar, now));
  now.running = true;
  EXPECT_FALSE(is_enabled(Command::make_avatar, now));
  EXPECT_TRUE(is_enabled(Command::pause, now));
  EXPECT_FALSE(is_enabled(Command::finish_now, now));
  EXPECT_FALSE(is_enabled(Command::open_clip, now));
}

TEST(Commands, NothingElseIsMadeWhileMethodsAreCompared) {
  Situation now{.project = true, .clip_there = true, .finished = true, .consent = true};
  now.avatar = now.directing = now.can_check = true;
  EXPECT_TRUE(is_enabled(Command::compare_methods, now));
  EXPECT_FALSE(is_enabled(Command::start_study, now)) << "nothing to compare yet";
  now.can_study = true;
  EXPECT_TRUE(is_enabled(Command::start_study, now));
  EXPECT_TRUE(is_enabled(Command::train_longer, now));
  EXPECT_FALSE(is_enabled(Command::stop_study, now));
  EXPECT_FALSE(is_enabled(Command::show_study, now));
  now.running = true;
  EXPECT_FALSE(is_enabled(Command::start_study, now));
  now.running = false, now.studying = true;
  EXPECT_TRUE(is_enabled(Command::stop_study, now));
  for (const Command c :
       {Command::start_study, Command::train_longer, Command::make_avatar, Command::open_clip,
        Command::close_project, Command::export_orbit, Command::check_clip, Command::drive_webcam})
    EXPECT_FALSE(is_enabled(c, now)) << command_info(c).words;
  now.studying = false;
  EXPECT_TRUE(is_enabled(Command::export_orbit, now));
  EXPECT_TRUE(is_enabled(Command::check_clip, now));
  EXPECT_TRUE(is_enabled(Command::drive_webcam, now));
  // Nor are methods compared beside other work: its time would count as theirs.
  for (bool Situation::*work : {&Situation::exporting, &Situation::checking, &Situation::driven}) {
    now.*work = true;
    EXPECT_FALSE(is_enabled(Command::start_study, now));
    now.*work = false;
  }
  EXPECT_TRUE(is_enabled(Command::start_study, now));
  now.consent = now.studying = false;
  EXPECT_FALSE(is_enabled(Command::start_study, now));
}

TEST(Commands, AProjectThatIsOnlyLookedAtIsNotChanged) {
  Situation now{.project = true, .clip_there = true, .consent = true};
  now.avatar = now.directing = now.can_check = now.can_study = now.clip_missing = true;
  const std::array changing{Command::make_avatar,  Command::check_clip,   Command::start_study,
                            Command::add_clip,     Command::find_clip,    Command::delete_person,
                            Command::export_still, Command::export_driven};
  for (const Command c : changing) EXPECT_TRUE(is_enabled(c, now)) << command_info(c).words;
  now.look_only = true;
  for (const Command c : changing) EXPECT_FALSE(is_enabled(c, now)) << command_info(c).words;
  EXPECT_TRUE(is_enabled(Command::play, now));
  EXPECT_TRUE(is_enabled(Command::close_project, now));
}

TEST(Commands, StrokesAreTakenBackBeforeThereIsAnAvatar) {
  Situation now{.project = true};
  now.can_undo = now.can_redo = true;
  for (const Command c : {Command::undo, Command::redo, Command::previous_picture, Command::next_picture}) {
    now.masking = false;
    EXPECT_FALSE(is_enabled(c, now));
    now.masking = true;
    EXPECT_TRUE(is_enabled(c, now));
  }
}

TEST(Commands, TheChoiceOfACameraIsTakenBackWhereItIsMade) {
  Situation now{.project = true};
  now.choosing = true;
  EXPECT_FALSE(is_enabled(Command::undo, now));
  now.can_undo = now.can_redo = true;
  EXPECT_TRUE(is_enabled(Command::undo, now));
  EXPECT_TRUE(is_enabled(Command::redo, now));
  EXPECT_FALSE(is_enabled(Command::next_picture, now));
}

TEST(Commands, NothingIsExportedWithoutConsentOrWhileItLearns) {
  Situation now{.project = true, .avatar = true};
  for (const Command c : {Command::export_still, Command::export_orbit, Command::export_mesh}) {
    now.consent = false, now.running = false;
    EXPECT_FALSE(is_enabled(c, now));
    now.consent = true;
    EXPECT_TRUE(is_enabled(c, now));
    now.running = true;
    EXPECT_FALSE(is_enabled(c, now));
    now.paused = true;
    EXPECT_TRUE(is_enabled(c, now));
    now.paused = false;
  }
}

TEST(Commands, ARecordingIsEndedBeforeAnythingElseBegins) {
  Situation now;
  EXPECT_TRUE(is_enabled(Command::record_clip, now));
  EXPECT_FALSE(is_enabled(Command::start_recording, now));
  EXPECT_FALSE(is_enabled(Command::leave_recorder, now));
  now.recorder = true;
  EXPECT_FALSE(is_enabled(Command::record_clip, now));
  EXPECT_FALSE(is_enabled(Command::start_recording, now)) << "the camera gives no picture yet";
  EXPECT_TRUE(is_enabled(Command::leave_recorder, now));
  EXPECT_TRUE(is_enabled(Command::open_clip, now));
  now.camera_ready = true;
  EXPECT_TRUE(is_enabled(Command::start_recording, now));
  EXPECT_FALSE(is_enabled(Command::stop_recording, now));
  now.camera_ready = false, now.recording = now.can_stop_recording = true;
  for (const Command c : {Command::start_recording, Command::leave_recorder, Command::open_clip,
                          Command::open_project, Command::try_demo})
    EXPECT_FALSE(is_enabled(c, now)) << command_info(c).words;
  for (const Command c : {Command::stop_recording, Command::discard_recording, Command::quit})
    EXPECT_TRUE(is_enabled(c, now)) << command_info(c).words;
  now = {.project = true, .running = true};
  EXPECT_FALSE(is_enabled(Command::record_clip, now)) << "a build takes the processor";
}

}  // namespace
}  // namespace likeness::ui
