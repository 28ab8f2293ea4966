// Linux: /proc/meminfo, control groups of version 2, and the limit of a process's address space.
#include "core/base/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

namespace likeness {
namespace {

std::optional<std::uint64_t> number_in(const char* path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  if (file >> value) return value;
  return std::nullopt;  // no such file, or "max"
}

// What `ulimit -v` leaves of the address space.
std::optional<std::uint64_t> address_space_left() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  const auto pages = number_in("/proc/self/statm");
  if (!pages) return std::nullopt;
  const std::uint64_t taken = *pages * std::uint64_t(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur > taken ? limit.rlim_cur - taken : 0;
}

}  // namespace

std::optional<std::uint64_t> available_memory() {
  std::ifstream info("/proc/meminfo");
  std::string key, unit;
  std::uint64_t value = 0;
  std::optional<std::uint64_t> available;
  while (info >> key >> value && std::getline(info, unit))
    if (key == "MemAvailable:") available = value * 1024;
  const auto limit = number_in("/sys/fs/cgroup/memory.max");
  // What programs hold; the file cache counts against the limit too, but gives way.
  std::ifstream group("/sys/fs/cgroup/memory.stat");
  std::optional<std::uint64_t> used;
  while (group >> key >> value)
    if (key == "anon") used = value;
  if (available && limit && used) available = std::min(*available, *limit > *used ? *limit - *used : 0);
  if (const auto left = address_space_left()) available = std::min(available.value_or(*left), *left);
  return available;
}

}  // namespace likeness
