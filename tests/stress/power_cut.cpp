// Preloaded into a program: at the n-th of its calls that sync, rename or remove, the power fails. What POSIX
// does not promise to be on the disk then is lost, at random: of a file that was not synced since it changed
// the bytes behind its last sync, of a folder that was not synced its latest renames and removals.
//   LIKENESS_CUT_AT=n LIKENESS_CUT_SEED=n LIKENESS_CUT_BELOW=folder LIKENESS_CUT_KEPT=folder on the same disk
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Synced {
  off_t size = 0;
  timespec changed{};
};
// A rename (from is where it was) or a removal (from is empty); what stood at `to` before is kept beside.
struct Change {
  std::string from, to, kept;
};
struct State {
  std::mutex lock;
  std::string below, kept;
  long long left = 0;
  std::mt19937_64 random;
  std::map<ino_t, Synced> synced;
  std::vector<Change> changes;  // not yet synced with their folders, in order
  int kept_count = 0;
  bool active = false;
};
State* g_state = nullptr;
thread_local bool t_inside = false;

template <class Function>
Function* next_of(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

std::string absolute(int folder, const char* path) {
  if (path[0] == '/') return path;
  if (folder == AT_FDCWD) return fs::absolute(path).string();
  std::error_code ignored;
  return (fs::read_symlink("/proc/self/fd/" + std::to_string(folder), ignored) / path).string();
}
bool is_ours(const std::string& path) {
  return g_state && g_state->active && path.starts_with(g_state->below + "/");
}
bool same_time(const timespec& a, const timespec& b) {
  return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

[[noreturn]] void cut() {
  State& s = *g_state;
  s.active = false;
  const auto real_rename = next_of<int(const char*, const char*)>("rename");
  const std::size_t persisted = s.changes.empty() ? 0 : s.random() % (s.changes.size() + 1);
  for (std::size_t i = s.changes.size(); i-- > persisted;) {
    const Change& change = s.changes[i];
    if (!change.from.empty()) real_rename(change.to.c_str(), change.from.c_str());
    if (!change.kept.empty()) real_rename(change.kept.c_str(), change.to.c_str());
  }
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(s.below, ignored)) {
    struct stat now {};
    if (::lstat(entry.path().c_str(), &now) != 0 || !S_ISREG(now.st_mode)) continue;
    const auto found = s.synced.find(now.st_ino);
    if (found != s.synced.end() && found->second.size == now.st_size &&
        same_time(found->second.changed, now.st_mtim))
      continue;
    if (s.random() % 2 == 0) continue;  // this one had been written out by then
    const off_t safe = found == s.synced.end() ? 0 : std::min(found->second.size, now.st_size);
    static_cast<void>(!::truncate(entry.path().c_str(), safe));
  }
  ::kill(::getpid(), SIGKILL);
  for (;;) ::pause();
}

// Before a call that syncs or changes names.
void count_down() {
  if (--g_state->left <= 0) cut();
}

// Keeps what stands at `path`, which is about to go; empty: nothing stands there.
std::string keep(const std::string& path) {
  const std::string kept = g_state->kept + "/" + std::to_string(g_state->kept_count++);
  return ::link(path.c_str(), kept.c_str()) == 0 ? kept : std::string();
}

int renamed(const std::string& from, const std::string& to, auto call) {
  if (t_inside || !is_ours(to)) return call();
  t_inside = true;
  const std::lock_guard hold(g_state->lock);
  count_down();
  const std::string kept = keep(to);
  const int result = call();
  if (result == 0) g_state->changes.push_back({from, to, kept});
  t_inside = false;
  return result;
}

int removed(const std::string& path, auto call) {
  struct stat now {};
  if (t_inside || !is_ours(path) || ::lstat(path.c_str(), &now) != 0 || !S_ISREG(now.st_mode)) return call();
  t_inside = true;
  const std::lock_guard hold(g_state->lock);
  count_down();
  const std::string kept = keep(path);
  const int result = call();
  if (result == 0) g_state->changes.push_back({"", path, kept});
  t_inside = false;
  return result;
}

int sync_of(int file, auto call) {
  struct stat now {};
  if (t_inside || !g_state || !g_state->active || ::fstat(file, &now) != 0) return call();
  t_inside = true;
  const std::lock_guard hold(g_state->lock);
  count_down();
  const int result = call();
  if (S_ISREG(now.st_mode) && ::fstat(file, &now) == 0)
    g_state->synced[now.st_ino] = {now.st_size, now.st_mtim};
  if (S_ISDIR(now.st_mode)) {
    const std::string folder = absolute(file, ".").substr(0, absolute(file, ".").size() - 2);
    std::erase_if(g_state->changes, [&](const Change& change) {
      return fs::path(change.to).parent_path() == fs::path(folder);
    });
  }
  t_inside = false;
  return result;
}

__attribute__((constructor)) void begin() {
  const char* at = ::getenv("LIKENESS_CUT_AT");
  const char* below = ::getenv("LIKENESS_CUT_BELOW");
  const char* kept = ::getenv("LIKENESS_CUT_KEPT");
  const char* seed = ::getenv("LIKENESS_CUT_SEED");
  const char* program = ::program_invocation_short_name;
  if (!at || !below || !kept || !seed || std::string(program) == "env") return;
  ::unsetenv("LD_PRELOAD");  // programs that this one runs have no part in it
  g_state = new State;
  g_state->below = below, g_state->kept = kept;
  g_state->left = std::atoll(at);
  g_state->random.seed(std::strtoull(seed, nullptr, 10));
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(below, ignored)) {
    struct stat now {};
    if (::lstat(entry.path().c_str(), &now) == 0) g_state->synced[now.st_ino] = {now.st_size, now.st_mtim};
  }
  g_state->active = true;
}

}  // namespace

extern "C" {

int fsync(int file) {
  return sync_of(file, [&] { return next_of<int(int)>("fsync")(file); });
}
int fdatasync(int file) {
  return sync_of(file, [&] { return next_of<int(int)>("fdatasync")(file); });
}
int rename(const char* from, const char* to) noexcept {
  return renamed(absolute(AT_FDCWD, from), absolute(AT_FDCWD, to),
                 [&] { return next_of<int(const char*, const char*)>("rename")(from, to); });
}
int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  return renamed(absolute(from_folder, from), absolute(to_folder, to), [&] {
    return next_of<int(int, const char*, int, const char*)>("renameat")(from_folder, from, to_folder, to);
  });
}
int unlink(const char* path) noexcept {
  return removed(absolute(AT_FDCWD, path), [&] { return next_of<int(const char*)>("unlink")(path); });
}
int unlinkat(int folder, const char* path, int flags) noexcept {
  return removed(absolute(folder, path),
                 [&] { return next_of<int(int, const char*, int)>("unlinkat")(folder, path, flags); });
}
int remove(const char* path) noexcept {
  return removed(absolute(AT_FDCWD, path), [&] { return next_of<int(const char*)>("remove")(path); });
}

}  // extern "C"
