// See replace_folder.h.
#include "core/matte/replace_folder.h"

#include "core/base/files.h"

namespace likeness {

namespace fs = std::filesystem;

void restore_folder(const fs::path& target) {
  std::error_code ignored;
  const fs::path old = target.string() + ".old";
  if (!fs::exists(target, ignored) && fs::exists(old, ignored)) fs::rename(old, target, ignored);
}

Result<void> replace_folder(const fs::path& finished, const fs::path& target) {
  std::error_code fault;
  const fs::path old = target.string() + ".old";
  fs::remove_all(old, fault);
  if (fs::exists(target, fault)) fs::rename(target, old, fault);
  if (fault) return file_error(target, "replace", fault.value());
  fs::rename(finished, target, fault);
  if (fault) {
    restore_folder(target);
    return file_error(target, "write", fault.value());
  }
  fs::remove_all(old, fault);
  return {};
}

Result<fs::path> fresh_folder(const fs::path& path) {
  std::error_code fault;
  fs::remove_all(path, fault);
  if (auto made = make_writable_folder(path); !made) return made.error();
  return path;
}

}  // namespace likeness
