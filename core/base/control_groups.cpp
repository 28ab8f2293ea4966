// /proc/self/cgroup says which group a program is in, /proc/self/mountinfo where its files lie: see
// control_groups.h, cgroups(7).
#include "core/base/control_groups.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace likeness {

namespace fs = std::filesystem;

namespace {

// The names that a version has for its files and figures.
struct GroupVersion {
  std::vector<const char*> limits;
  const char* used;  // in memory.stat: what programs hold, of groups within, too. The file cache counts
                     // against a limit as well, but gives way.
};
const GroupVersion& group_version(bool first) {
  static const GroupVersion kFirst{{"memory.limit_in_bytes"}, "total_rss"},
      kSecond{{"memory.max", "memory.high"}, "anon"};
  return first ? kFirst : kSecond;
}

constexpr std::uint64_t kUnlimited = std::uint64_t(1)
                                     << 60;  // version 1 writes a huge number instead of a word

bool has_word(const std::string& list, std::string_view word) {
  std::istringstream words(list);
  for (std::string each; std::getline(words, each, ',');)
    if (each == word) return true;
  return false;
}

std::string without_escapes(const std::string& field) {  // "\040" is a space
  std::string text;
  for (std::size_t i = 0; i < field.size(); ++i)
    if (field[i] == '\\' && i + 3 < field.size()) {
      text += char((field[i + 1] - '0') * 64 + (field[i + 2] - '0') * 8 + (field[i + 3] - '0'));
      i += 3;
    } else {
      text += field[i];
    }
  return text;
}

struct GroupMount {
  bool first_version = false;
  fs::path group, place;  // the group that is mounted, and where
};

std::vector<GroupMount> group_mounts(const fs::path& root) {
  std::vector<GroupMount> mounts;
  std::ifstream file(root / "proc/self/mountinfo");
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    std::string skipped, group, place, kind, source, options;
    fields >> skipped >> skipped >> skipped >> group >> place;
    while (fields >> skipped && skipped != "-") {
    }
    fields >> kind >> source >> options;
    const bool first = kind == "cgroup" && has_word(options, "memory");
    if (!first && kind != "cgroup2") continue;
    mounts.push_back({first, without_escapes(group), without_escapes(place)});
  }
  return mounts;
}

// "/" of a version that the program is in no group of.
fs::path own_group(const fs::path& root, bool first_version) {
  std::ifstream file(root / "proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {  // "5:memory:/a/b", "0::/a/b"
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (first_version ? has_word(controllers, "memory") : controllers.empty()) return line.substr(second + 1);
  }
  return "/";
}

std::optional<std::uint64_t> left_in(const fs::path& group, const GroupVersion& version) {
  std::optional<std::uint64_t> least;
  for (const char* name : version.limits) {
    std::ifstream file(group / name);
    std::uint64_t value = 0;
    if (file >> value && value < kUnlimited) least = std::min(value, least.value_or(value));  // else "max"
  }
  if (!least) return std::nullopt;
  std::ifstream figures(group / "memory.stat");
  std::string key;
  std::uint64_t value = 0;
  while (figures >> key >> value)
    if (key == version.used) return *least > value ? *least - value : 0;
  return least;
}

}  // namespace

std::optional<std::uint64_t> group_memory_left(const fs::path& root) {
  std::optional<std::uint64_t> least;
  for (const GroupMount& mount : group_mounts(root)) {
    // Of a group outside what is mounted, as a container sees it, the mounted one is the nearest known.
    fs::path inside = own_group(root, mount.first_version).lexically_relative(mount.group);
    if (inside.empty() || *inside.begin() == "..") inside = ".";
    fs::path group = root / mount.place.relative_path();
    const auto look = [&] {
      if (const auto left = left_in(group, group_version(mount.first_version)))
        least = std::min(*left, least.value_or(*left));
    };
    look();
    for (const fs::path& name : inside)
      if (name != ".") group /= name, look();
  }
  return least;
}

}  // namespace likeness
