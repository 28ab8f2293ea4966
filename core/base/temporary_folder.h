// A folder for what nobody keeps, removed with the object, and by a signal that ends the process at once.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace likeness {

// $TMPDIR, or /tmp where that is nowhere.
std::filesystem::path temporary_place();

class TemporaryFolder {
 public:
  // what: part of its name.
  static Result<TemporaryFolder> make(const std::string& what);
  ~TemporaryFolder();
  TemporaryFolder(TemporaryFolder&&) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path);
  std::filesystem::path path_;  // empty: moved from
};

}  // namespace likeness
