// Choosing a clip or a project inside the window: works on every desktop, also over a remote display.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace likeness::ui {

enum class Wanted { clip, driver, project, performance, new_performance };

struct BrowserEntry {
  std::string name;
  bool folder = false;
  bool project = false;  // a folder with a project.json
  std::uintmax_t bytes = 0;
};

// What of a folder is shown: folders and, for clips and drivers, video files, for performances .json files;
// projects first. Hidden ones are left out. An unreadable folder has no entries.
std::vector<BrowserEntry> list_folder(const std::filesystem::path& folder, Wanted wanted);
bool is_video_name(const std::filesystem::path& path);

class FileBrowser {
 public:
  void open(Wanted wanted, const std::filesystem::path& start);
  bool is_open() const { return open_; }
  Wanted wanted() const { return wanted_; }
  // Draws the dialog; the path chosen, once.
  std::optional<std::filesystem::path> draw();

 private:
  void enter(const std::filesystem::path& folder);

  bool open_ = false, appear_ = false;
  Wanted wanted_ = Wanted::clip;
  std::filesystem::path folder_;
  std::vector<BrowserEntry> entries_;
  std::string typed_, name_;  // the folder; of the new file
  int chosen_ = -1;
};

}  // namespace likeness::ui
