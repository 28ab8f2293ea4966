// A temporary folder, removed when a study ends.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <system_error>

namespace likeness::app {

class WorkFolder {
 public:
  // what: part of its name. path() is empty if none could be made; errno says why.
  explicit WorkFolder(const std::string& what) {
    std::error_code ignored;
    std::string name =
        (std::filesystem::temp_directory_path(ignored) / ("likeness_" + what + "_XXXXXX")).string();
    if (::mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace likeness::app
