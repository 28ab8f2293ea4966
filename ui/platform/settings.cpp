// studio.json: see settings.h.
#include "ui/platform/settings.h"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/base/path_text.h"

namespace likeness::ui {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kRecent = 10;

}  // namespace

fs::path home_folder() {
  if (const char* home = std::getenv("HOME"); home && *home) return home;
  passwd entry{}, *found = nullptr;
  std::vector<char> room(1 << 16);
  ::getpwuid_r(::getuid(), &entry, room.data(), room.size(), &found);
  return found && found->pw_dir ? fs::path(found->pw_dir) : fs::path();
}

fs::path settings_path() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  const fs::path home = home_folder();
  if ((!config || !*config) && home.empty()) return {};
  const fs::path folder = config && *config ? fs::path(config) : home / ".config";
  return folder / "likeness" / "studio.json";
}

fs::path projects_folder() {
  const fs::path home = home_folder();
  return home.empty() ? home : home / "Likeness";
}

std::uint64_t memory_in_use() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  return file >> all >> resident ? resident * std::uint64_t(::sysconf(_SC_PAGESIZE)) : 0;
}

Settings read_settings(const fs::path& path) {
  Settings settings;
  const auto text = read_text(path);
  if (!text) return settings;
  const json j = try_parse_json(*text);
  if (!j.is_object()) return settings;
  try {
    Settings read;
    read.width = std::clamp(j.value("width", read.width), 960, 16384);
    read.height = std::clamp(j.value("height", read.height), 600, 16384);
    read.maximised = j.value("maximised", read.maximised);
    read.dark = j.value("dark", read.dark);
    read.scale_percent = std::clamp(j.value("scale_percent", read.scale_percent), kLeastScale, kMostScale);
    read.licences_shown = j.value("licences_shown", read.licences_shown);
    for (const json& entry : j.value("recent", json::array()))
      read.recent.push_back(path_of_text(entry.get<std::string>()));
    read.projects = path_of_text(j.value("projects", ""));
    return read;
  } catch (const json::exception&) {
    return settings;
  }
}

Result<void> write_settings(const fs::path& path, const Settings& settings) {
  if (path.empty()) return {};
  json recent = json::array();
  for (const fs::path& folder : settings.recent) recent.push_back(text_of_path(folder));
  json j{{"width", settings.width},
         {"height", settings.height},
         {"maximised", settings.maximised},
         {"dark", settings.dark},
         {"scale_percent", settings.scale_percent},
         {"licences_shown", settings.licences_shown},
         {"recent", recent}};
  if (!settings.projects.empty()) j["projects"] = text_of_path(settings.projects);
  return write_text(path, json_text(j, 2) + "\n");
}

void remember_recent(Settings& settings, const fs::path& project) {
  std::erase(settings.recent, project);
  settings.recent.insert(settings.recent.begin(), project);
  if (settings.recent.size() > kRecent) settings.recent.resize(kRecent);
}

}  // namespace likeness::ui
