// See private_folder.h.
#include "core/project/private_folder.h"

#include <sys/stat.h>

#include <cerrno>
#include <system_error>

#include "core/base/files.h"

namespace likeness {

namespace fs = std::filesystem;

Result<void> make_project_folder(const fs::path& folder) {
  const fs::path own = folder.has_filename() ? folder : folder.parent_path();
  std::error_code failure;
  if (!fs::exists(own, failure)) {
    if (own.has_parent_path()) fs::create_directories(own.parent_path(), failure);
    if (failure) return file_error(own.parent_path(), "create", failure.value());
    if (::mkdir(own.c_str(), S_IRWXU) != 0 && errno != EEXIST) return file_error(own, "create", errno);
  }
  return make_writable_folder(own);
}

void keep_private(const fs::path& folder) {
  constexpr fs::perms kOthers = fs::perms::group_all | fs::perms::others_all;
  std::error_code failure;
  if ((fs::status(folder, failure).permissions() & kOthers) != fs::perms::none || failure) return;
  for (fs::recursive_directory_iterator it(folder, failure), end; !failure && it != end;
       it.increment(failure)) {
    std::error_code ignored;
    if (it.depth() == 0 && it->path().filename() == "exports")
      it.disable_recursion_pending();
    else if (!it->is_symlink(ignored) && (it->status(ignored).permissions() & kOthers) != fs::perms::none)
      fs::permissions(it->path(), kOthers, fs::perm_options::remove, ignored);
  }
}

}  // namespace likeness
