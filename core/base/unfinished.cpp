// See unfinished.h.
#include "core/base/unfinished.h"

#include <mutex>
#include <set>
#include <system_error>

namespace likeness {

namespace fs = std::filesystem;

namespace {

struct UnfinishedPaths {
  std::mutex mutex;
  std::set<fs::path> paths;
};

// Never destroyed: threads may still write while the process ends.
UnfinishedPaths& unfinished() {
  static auto* const all = new UnfinishedPaths;
  return *all;
}

}  // namespace

void remember_unfinished(const fs::path& path) {
  const std::lock_guard lock(unfinished().mutex);
  unfinished().paths.insert(path);
}

void forget_unfinished(const fs::path& path) {
  const std::lock_guard lock(unfinished().mutex);
  unfinished().paths.erase(path);
}

void remove_unfinished() {
  unfinished().mutex.lock();  // and stays so
  std::error_code ignored;
  // Twice: what was just being put into a folder may keep it from going.
  for (int pass = 0; pass < 2; ++pass)
    for (const fs::path& path : unfinished().paths) fs::remove_all(path, ignored);
}

}  // namespace likeness
