// Linux: /proc/meminfo, control groups, and the limit of a process's address space.
#include "core/base/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "core/base/control_groups.h"

namespace likeness {
namespace {

std::optional<std::uint64_t> number_in(const char* path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  if (file >> value) return value;
  return std::nullopt;
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
  if (const auto left = group_memory_left()) available = std::min(available.value_or(*left), *left);
  if (const auto left = address_space_left()) available = std::min(available.value_or(*left), *left);
  return available;
}

}  // namespace likeness
