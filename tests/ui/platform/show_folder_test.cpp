// Claims about a folder shown by the desktop: the desktop's program gets it, is not waited for, and where it
// or the folder is missing a sentence says so.
#include "ui/platform/show_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "core/base/files.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

class ShowFolder : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_show_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    const char* path = ::getenv("PATH");
    path_ = path ? path : "";
  }
  void TearDown() override {
    ::setenv("PATH", path_.c_str(), 1);
    fs::remove_all(folder_);
  }
  // A program of the desktop's name that notes what it is given, and then stays open like a file manager:
  // as long as the note is there, a minute at most.
  void install_desktop() {
    const fs::path program = folder_ / "xdg-open";
    const std::string shown = (folder_ / "shown").string();
    std::ofstream(program) << "#!/bin/sh\nprintf %s \"$1\" > '" << shown << ".part'\nmv '" << shown
                           << ".part' '" << shown << "'\nfor i in $(seq 600); do [ -e '" << shown
                           << "' ] || exit; sleep 0.1; done\ntouch '" << (folder_ / "ended").string()
                           << "'\n";
    ASSERT_EQ(::chmod(program.c_str(), 0755), 0);
    ::setenv("PATH", (folder_.string() + ":" + path_).c_str(), 1);
  }

  fs::path folder_;
  std::string path_;
};

TEST_F(ShowFolder, HandsTheFolderToTheDesktopAndGoesOn) {
  install_desktop();
  const fs::path exports = folder_ / "Anna's face" / "exports";
  ASSERT_TRUE(fs::create_directories(exports));
  ASSERT_TRUE(show_folder(exports).ok());
  EXPECT_FALSE(fs::exists(folder_ / "ended"));
  for (int i = 0; i < 400 && !fs::exists(folder_ / "shown"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const auto shown = read_text(folder_ / "shown");
  ASSERT_TRUE(shown.ok());
  EXPECT_EQ(*shown, exports.string());
}

TEST_F(ShowFolder, SaysWhatIsMissing) {
  install_desktop();
  const auto no_folder = show_folder(folder_ / "exports");
  ASSERT_FALSE(no_folder.ok());
  EXPECT_EQ(no_folder.error().code, ErrorCode::not_found);
  EXPECT_NE(no_folder.error().what.find("exports"), std::string::npos);
  ::setenv("PATH", (folder_ / "nowhere").c_str(), 1);
  const auto no_program = show_folder(folder_);
  ASSERT_FALSE(no_program.ok());
  EXPECT_EQ(no_program.error().code, ErrorCode::missing_dependency);
  EXPECT_NE(no_program.error().fix.find(folder_.string()), std::string::npos);
}

}  // namespace
}  // namespace likeness::ui
