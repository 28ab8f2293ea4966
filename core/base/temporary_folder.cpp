// See temporary_folder.h.
#include "core/base/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "core/base/files.h"
#include "core/base/unfinished.h"

namespace likeness {

namespace fs = std::filesystem;

fs::path temporary_place() {
  std::error_code nowhere;
  fs::path place = fs::temp_directory_path(nowhere);
  return nowhere ? fs::path("/tmp") : place;
}

Result<TemporaryFolder> TemporaryFolder::make(const std::string& what) {
  std::string name = (temporary_place() / ("likeness_" + what + "_XXXXXX")).string();
  if (::mkdtemp(name.data()) == nullptr) return file_error(temporary_place(), "create a folder in", errno);
  return TemporaryFolder(name);
}

TemporaryFolder::TemporaryFolder(fs::path path) : path_(std::move(path)) { remember_unfinished(path_); }

TemporaryFolder::~TemporaryFolder() {
  if (path_.empty()) return;
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  forget_unfinished(path_);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}

}  // namespace likeness
