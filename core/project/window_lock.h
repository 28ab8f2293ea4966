// Held by a window for as long as it shows a project: of two windows that both save what is directed and
// painted, the later one would undo the other's. It keeps nobody from working on the project; that is
// ProjectLock's.
#pragma once

#include <filesystem>

namespace likeness {

class WindowLock {
 public:
  // The project's folder. Where no lock can be had at all - a folder that cannot be written, a file system
  // without locks - nobody else's is known.
  explicit WindowLock(const std::filesystem::path& folder);
  ~WindowLock();
  WindowLock(const WindowLock&) = delete;
  WindowLock& operator=(const WindowLock&) = delete;

  bool is_others() const { return others_; }  // another window shows the project

 private:
  int fd_ = -1;
  bool others_ = false;
};

}  // namespace likeness
