// The table of commands: see commands.h.
#include "ui/commands.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"

namespace likeness::ui {

namespace {

using S = const Situation&;

bool always(S) { return true; }
bool with_project(S s) { return s.project; }
bool idle(S s) { return !s.running && !s.exporting; }
bool directing(S s) { return s.directing && s.avatar; }
bool can_export(S s) { return s.avatar && s.consent && !s.exporting && !s.running; }

constexpr CommandInfo kTable[] = {
    {Command::open_clip, Menu::file, "Open a clip...", "Ctrl+N", idle},
    {Command::open_project, Menu::file, "Open a project...", "Ctrl+O", idle},
    {Command::try_demo, Menu::file, "Try the demo", "", idle},
    {Command::close_project, Menu::file, "Close the project", "Ctrl+W",
     [](S s) { return s.project && idle(s); }},
    {Command::quit, Menu::file, "Quit", "Ctrl+Q", always},
    {Command::undo, Menu::edit, "Undo", "Ctrl+Z", [](S s) { return s.avatar && s.can_undo; }},
    {Command::redo, Menu::edit, "Redo", "Ctrl+Y", [](S s) { return s.avatar && s.can_redo; }},
    {Command::reset_face, Menu::edit, "Reset the face", "Ctrl+1", directing},
    {Command::reset_head, Menu::edit, "Reset the head", "Ctrl+2", directing},
    {Command::reset_view, Menu::edit, "Reset the view", "Ctrl+3", directing},
    {Command::check_clip, Menu::avatar, "Check the clip", "Ctrl+K",
     [](S s) { return s.project && s.can_check && s.consent && !s.running && !s.checking; }},
    {Command::make_avatar, Menu::avatar, "Make the avatar", "Ctrl+Enter",
     [](S s) { return s.project && s.clip_there && s.consent && !s.running && !s.finished; }},
    {Command::pause, Menu::avatar, "Pause", "Ctrl+P", [](S s) { return s.running; }},
    {Command::finish_now, Menu::avatar, "Finish with what is learnt", "", [](S s) { return s.training; }},
    {Command::train_longer, Menu::avatar, "Train longer", "",
     [](S s) { return s.project && s.finished && s.consent && !s.running; }},
    {Command::export_still, Menu::avatar, "Export a still", "Ctrl+E", can_export},
    {Command::export_orbit, Menu::avatar, "Export an orbit", "", can_export},
    {Command::export_sequence, Menu::avatar, "Export pictures with transparency", "", can_export},
    {Command::stop_export, Menu::avatar, "Stop the export", "", [](S s) { return s.exporting; }},
    {Command::previous_step, Menu::view, "Previous step", "Ctrl+Up", with_project},
    {Command::next_step, Menu::view, "Next step", "Ctrl+Down", with_project},
    {Command::compare, Menu::view, "Compare with the clip", "Ctrl+B", directing},
    {Command::toggle_theme, Menu::view, "Light or dark", "Ctrl+L", always},
    {Command::larger, Menu::view, "Larger", "Ctrl+Plus", always},
    {Command::smaller, Menu::view, "Smaller", "Ctrl+Minus", always},
    {Command::film_guide, Menu::help, "How to film", "Ctrl+H", always},
    {Command::shortcuts, Menu::help, "Keyboard shortcuts", "F1", always},
    {Command::licences, Menu::help, "Licences and privacy", "", always},
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
  constexpr std::array<std::string_view, 5> kWords{"File", "Edit", "Avatar", "View", "Help"};
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
