// Claims about who may read a project: its owner; of its exports whoever the umask lets.
#include "core/project/private_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <fstream>

#include "core/base/files.h"
#include "core/project/project.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class PrivateFolder : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_private_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    before_ = ::umask(022);
  }
  void TearDown() override {
    ::umask(before_);
    fs::remove_all(root_);
  }
  static unsigned mode(const fs::path& path) {
    struct stat own {};
    EXPECT_EQ(::lstat(path.c_str(), &own), 0) << path;
    return own.st_mode & 0777;
  }

  fs::path root_;
  mode_t before_ = 0;
};

TEST_F(PrivateFolder, WhatIsMadeInAProjectIsItsOwnersAlone) {
  const fs::path folder = root_ / "me.likeness";
  const auto project = open_or_create_project(folder, {});
  ASSERT_TRUE(project.ok()) << project.error().what;
  EXPECT_EQ(mode(folder), 0700u);
  EXPECT_EQ(mode(folder / "project.json"), 0600u);
  EXPECT_EQ(mode(folder / ".lock"), 0600u);
  ASSERT_TRUE(write_text(folder / "corrections" / "000001.json", "{}").ok());
  EXPECT_EQ(mode(folder / "corrections"), 0700u);
  EXPECT_EQ(mode(folder / "corrections" / "000001.json"), 0600u);
  ASSERT_TRUE(make_writable_folder(folder / "frames").ok());
  EXPECT_EQ(mode(folder / "frames"), 0700u);
  // What a library wrote without asking.
  fs::create_directories(folder / "colmap" / "images");
  std::ofstream(folder / "colmap" / "images" / "0.png") << "a face";
  ASSERT_TRUE(write_text(folder / "exports" / "orbit.mp4", "a film").ok());
  fs::create_symlink(root_, folder / "link");
  keep_private(folder);
  EXPECT_EQ(mode(folder / "colmap" / "images"), 0700u);
  EXPECT_EQ(mode(folder / "colmap" / "images" / "0.png"), 0600u);
  EXPECT_EQ(mode(folder / "exports"), 0755u) << "made to be given away";
  EXPECT_EQ(mode(folder / "exports" / "orbit.mp4"), 0644u);
  EXPECT_EQ(mode(root_), 0700u);
  // A folder of one's own that is no project: as the umask says.
  ASSERT_TRUE(write_text(root_ / "films" / "orbit.mp4", "a film").ok());
  EXPECT_EQ(mode(root_ / "films"), 0755u);
  EXPECT_EQ(mode(root_ / "films" / "orbit.mp4"), 0644u);
  ASSERT_TRUE(write_text(root_ / "orbit.mp4", "a film").ok());
  EXPECT_EQ(mode(root_ / "orbit.mp4"), 0644u);
}

TEST_F(PrivateFolder, AFolderThatItsOwnerSharesStaysShared) {
  const fs::path folder = root_ / "ours.likeness";
  fs::create_directory(folder);
  fs::permissions(folder, fs::perms(0750));
  ASSERT_TRUE(open_or_create_project(folder, {}).ok());
  keep_private(folder);
  EXPECT_EQ(mode(folder), 0750u);
  EXPECT_EQ(mode(folder / "project.json"), 0644u);
}

}  // namespace
}  // namespace likeness
