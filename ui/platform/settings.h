// What the studio remembers between starts: window, theme, recent projects. Kept where the desktop keeps
// settings.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"

namespace likeness::ui {

inline constexpr int kLeastScale = 100, kMostScale = 200, kScaleStep = 25;  // %

struct Settings {
  int width = 1280, height = 800;  // of the window, screen coordinates
  bool maximised = false;
  bool dark = true;
  int scale_percent = 100;  // of letters and everything else
  bool licences_shown = false;
  std::vector<std::filesystem::path> recent;  // project folders, newest first
  std::filesystem::path projects{};           // where new ones go, as chosen in the window; empty: ~/Likeness
};

// $HOME, or what the user's entry says; empty where neither tells.
std::filesystem::path home_folder();
// $XDG_CONFIG_HOME/likeness/studio.json, or in ~/.config; empty without a home.
std::filesystem::path settings_path();
// Where new projects go unless told otherwise: ~/Likeness; empty without a home.
std::filesystem::path projects_folder();
// Bytes this process holds in memory; 0 where the system does not say.
std::uint64_t memory_in_use();

// A missing or damaged file gives the defaults: settings are never worth a failure.
Settings read_settings(const std::filesystem::path& path);
// path: empty: nothing is kept.
Result<void> write_settings(const std::filesystem::path& path, const Settings& settings);

// Puts a project at the top of the recent ones, of which ten are kept.
void remember_recent(Settings& settings, const std::filesystem::path& project);

}  // namespace likeness::ui
