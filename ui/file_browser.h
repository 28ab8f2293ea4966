// Choosing a file or a project inside the window: works on every desktop, also over a remote display.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ui/studio/background.h"
#include "ui/studio/folder_list.h"

namespace likeness::ui {

class FileBrowser {
 public:
  // wake: called from the thread that reads folders.
  explicit FileBrowser(std::function<void()> wake);

  void open(Wanted wanted, const std::filesystem::path& start);
  bool is_open() const { return open_; }
  Wanted wanted() const { return wanted_; }
  // Draws the dialog; the path chosen, once. projects: folder of new ones.
  std::optional<std::filesystem::path> draw(const std::filesystem::path& projects);

 private:
  void enter(const std::filesystem::path& folder);

  bool open_ = false, appear_ = false;
  Wanted wanted_ = Wanted::clip;
  std::filesystem::path folder_;
  std::vector<FolderEntry> entries_;
  bool reading_ = false;
  std::string typed_, name_;  // the folder; of the new file
  int chosen_ = -1;
  Background reader_;  // last: its deliveries use the rest
};

}  // namespace likeness::ui
