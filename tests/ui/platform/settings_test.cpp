// Claims about settings: they come back, and a bad file is no failure.
#include "ui/platform/settings.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>

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
  remember_recent(settings, "/a/b.likeness");
  ASSERT_TRUE(write_settings(file, settings).ok());
  const Settings read = read_settings(file);
  EXPECT_EQ(read.width, 1500);
  EXPECT_FALSE(read.dark);
  EXPECT_EQ(read.scale_percent, 150);
  EXPECT_EQ(read.recent, settings.recent);
  for (const char* text : {"", "{", "[]", R"({"width": "wide"})", R"({"recent": [1]})"}) {
    ASSERT_TRUE(write_text(file, text).ok());
    EXPECT_EQ(read_settings(file).width, Settings{}.width) << text;
  }
  ASSERT_TRUE(write_text(file, R"({"scale_percent": 5000, "width": 1})").ok());
  EXPECT_EQ(read_settings(file).scale_percent, kMostScale);
  EXPECT_GE(read_settings(file).width, 960);
  fs::remove_all(name);
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
