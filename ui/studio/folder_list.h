// What of a folder the file browser shows.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace likeness::ui {

// What a path is asked for: something to open or to save, for an export, the clip that moved, or a
// further one.
enum class Wanted {
  clip,
  project,
  projects,  // the folder of new ones
  driver,
  driving_clip,
  background,
  performance,
  new_performance,
  export_performance,
  moved_clip,
  further_clip
};

struct FolderEntry {
  std::string name;
  bool folder = false;
  bool project = false;  // a folder with a project.json
  std::uintmax_t bytes = 0;
};

// Folders and what is wanted - video files, pictures, performances; projects first. Hidden ones are left
// out. An unreadable folder has no entries.
std::vector<FolderEntry> list_folder(const std::filesystem::path& folder, Wanted wanted);
// By its ending.
bool is_picture_name(const std::filesystem::path& path);

}  // namespace likeness::ui
