// Linux: /proc/meminfo, and control groups of version 2.
#include "core/base/memory.h"

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

}  // namespace

std::optional<std::uint64_t> available_memory() {
  std::ifstream info("/proc/meminfo");
  std::string key, unit;
  std::uint64_t value = 0;
  std::optional<std::uint64_t> available;
  while (info >> key >> value && std::getline(info, unit))
    if (key == "MemAvailable:") available = value * 1024;
  const auto limit = number_in("/sys/fs/cgroup/memory.max");
  // What programs hold; the cache of files counts against the limit, too, but gives way.
  std::ifstream group("/sys/fs/cgroup/memory.stat");
  std::optional<std::uint64_t> used;
  while (group >> key >> value)
    if (key == "anon") used = value;
  if (available && limit && used) available = std::min(*available, *limit > *used ? *limit - *used : 0);
  return available;
}

}  // namespace likeness
