// Claims about settings: they come back, and a bad file is no failure.
#include "ui/platform/settings.h"

#include <gtest/gtest.h>
#include <pwd.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <string>

#include "core/base/files.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

TEST(SettingsFile, ComesBackAndToleratesDamage) {
  std::string name = (fs::temp_directory_path() / "likeness_settings_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path file = fs::path(name) / "sub" / "studio.json";
  EXPECT_TRUE(read_settings(file).recent.empty());
  Settings settings;
  settings.width = 1500;
  settings.dark = false;
  settings.scale_percent = 150;
  settings.projects = "/media/m\xfcller";
  remember_recent(settings, "/a/b.likeness");
  ASSERT_TRUE(write_settings(file, settings).ok());
  const Settings read = read_settings(file);
  EXPECT_EQ(read.width, 1500);
  EXPECT_FALSE(read.dark);
  EXPECT_EQ(read.scale_percent, 150);
  EXPECT_EQ(read.recent, settings.recent);
  EXPECT_EQ(read.projects, settings.projects);
  for (const char* text : {"", "{", "[]", R"({"width": "wide"})", R"({"recent": [1]})"}) {
    ASSERT_TRUE(write_text(file, text).ok());
    EXPECT_EQ(read_settings(file).width, Settings{}.width) << text;
  }
  ASSERT_TRUE(write_text(file, R"({"scale_percent": 5000, "width": 1})").ok());
  EXPECT_EQ(read_settings(file).scale_percent, kMostScale);
  EXPECT_GE(read_settings(file).width, 960);
  fs::remove_all(name);
}

// As in a service, or where a session was started by hand.
TEST(HomeFolder, WithoutVariablesIsThatOfTheUsersEntry) {
  std::map<std::string, std::string> before;
  for (const char* name : {"HOME", "XDG_CONFIG_HOME", "TMPDIR"})
    if (const char* value = ::getenv(name)) before[name] = value;
  ::unsetenv("HOME"), ::unsetenv("XDG_CONFIG_HOME"), ::setenv("TMPDIR", "/nowhere/at/all", 1);
  const fs::path home = home_folder(), projects = projects_folder(), settings = settings_path();
  ::unsetenv("TMPDIR");
  for (const auto& [name, value] : before) ::setenv(name.c_str(), value.c_str(), 1);
  const passwd* entry = ::getpwuid(::getuid());
  EXPECT_EQ(home, entry ? fs::path(entry->pw_dir) : fs::path());
  if (entry == nullptr) {
    EXPECT_TRUE(projects.empty() && settings.empty());
    EXPECT_TRUE(write_settings(settings, {}).ok()) << "nothing is kept, and nothing is wrong";
  } else {
    EXPECT_EQ(projects, home / "Likeness");
    EXPECT_EQ(settings, home / ".config" / "likeness" / "studio.json");
  }
}

TEST(RememberRecent, KeepsTheNewestTenOnceEach) {
  Settings settings;
  for (int i = 0; i < 15; ++i) remember_recent(settings, "/p" + std::to_string(i));
  remember_recent(settings, "/p9");
  EXPECT_EQ(settings.recent.size(), 10u);
  EXPECT_EQ(settings.recent.front(), "/p9");
  EXPECT_EQ(std::count(settings.recent.begin(), settings.recent.end(), "/p9"), 1);
}

}  // namespace
}  // namespace likeness::ui
