// Claims about links inside a project: whatever name one stands at, it is told, and what it leads to stays.
#include "core/project/own_names.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"
#include "core/project/care.h"
#include "core/project/further_clips.h"
#include "core/project/project.h"
#include "core/project/run_stages.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class LinksInside : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_links_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    ASSERT_TRUE(write_text(root_ / "clip.mp4", "the clip").ok());
    ASSERT_TRUE(open_or_create_project(folder(), options()).ok());
    ASSERT_TRUE(write_text(root_ / "theirs" / "images" / "a.png", "theirs").ok());
    ASSERT_TRUE(write_text(root_ / "theirs" / "project.json", "{}").ok());
  }
  void TearDown() override { fs::remove_all(root_); }

  ProjectOptions options() const { return {.shared = {.video = root_ / "clip.mp4"}}; }
  fs::path folder() const { return root_ / "me.likeness"; }
  void expect_theirs(const std::string& name) const {
    EXPECT_EQ(*read_text(root_ / "theirs" / "images" / "a.png"), "theirs") << name;
    EXPECT_EQ(*read_text(root_ / "theirs" / "project.json"), "{}") << name;
  }

  fs::path root_;
};

TEST_F(LinksInside, AtEveryNameOfAProjectOneIsToldAndNotEntered) {
  for (const char* name : {"frames",
                           "masks",
                           "regions",
                           "masks.part",
                           "regions.old",
                           "colmap",
                           "decoded",
                           "clips",
                           "corrections",
                           "comparison",
                           "capture.json",
                           "cameras.json",
                           "track.json",
                           "plate.png",
                           "plate.json",
                           "matte_report.json",
                           "room.bin",
                           "detail.npz",
                           "checkpoint.bin",
                           "avatar.bin",
                           "training_curve.json",
                           "check.json",
                           "attributes.json",
                           "performance.json",
                           "track_first.json",
                           "refits.json",
                           "track.changed.json",
                           ".lock",
                           ".window"}) {
    const fs::path link = folder() / name;
    fs::remove_all(link);
    fs::create_symlink(root_ / "theirs", link);
    const auto opened = open_project(folder());
    ASSERT_FALSE(opened.ok()) << name;
    EXPECT_NE(opened.error().what.find(link.string() + " is a link to"), std::string::npos)
        << opened.error().what;
    EXPECT_FALSE(open_or_create_project(folder(), options()).ok()) << name;
    Project project{.folder = folder(), .options = options()};
    EXPECT_FALSE(run_stages(project, Stage::train, Progress(), {}, {}).ok()) << name;
    expect_theirs(name);
    fs::remove(link);
  }
  EXPECT_TRUE(open_project(folder()).ok());
}

TEST_F(LinksInside, DeeperOnesStopWhoeverWrites) {
  fs::create_directories(folder() / "colmap");
  fs::create_directory_symlink(root_ / "theirs" / "images", folder() / "colmap" / "images");
  const auto opened = open_project(folder());
  ASSERT_TRUE(opened.ok());
  const auto lock = ProjectLock::acquire(*opened);
  ASSERT_FALSE(lock.ok());
  EXPECT_NE(lock.error().what.find("colmap/images is a link"), std::string::npos) << lock.error().what;
}

TEST_F(LinksInside, ADeletionRemovesTheLinkAndSaysSo) {
  fs::create_directory_symlink(root_ / "theirs", folder() / "colmap");
  fs::create_directories(folder() / "clips");
  fs::create_directory_symlink(root_ / "theirs", folder() / "clips" / "2");
  const auto deleted = delete_person(folder(), false);
  ASSERT_TRUE(deleted.ok()) << deleted.error().what;
  EXPECT_EQ(deleted->links, std::vector<std::string>{"colmap"});
  EXPECT_NE(deletion_words(*deleted).find("only the links were removed"), std::string::npos);
  EXPECT_TRUE(deleted->folder_gone);
  expect_theirs("delete");
}

// A damaged project no longer says which folder holds the clip.
TEST_F(LinksInside, ADamagedProjectLeadsNowhereElse) {
  ASSERT_TRUE(open_or_create_project(root_ / "victim.likeness", options()).ok());
  ASSERT_TRUE(write_text(root_ / "victim.likeness" / "avatar.bin", "theirs").ok());
  ASSERT_TRUE(write_text(folder() / "project.json", "{ damaged").ok());
  ASSERT_TRUE(write_text(folder() / "clips" / "1" / "film.mp4", "a film").ok());
  fs::create_directory_symlink("../../victim.likeness", folder() / "clips" / "2");
  ASSERT_TRUE(delete_person(folder(), false).ok());
  EXPECT_EQ(*read_text(root_ / "victim.likeness" / "avatar.bin"), "theirs");
  EXPECT_TRUE(open_project(root_ / "victim.likeness").ok());
}

TEST_F(LinksInside, AFurtherClipThatIsALinkIsNotRemovedThroughIt) {
  ASSERT_TRUE(open_or_create_project(root_ / "victim.likeness", options()).ok());
  auto project = open_project(folder());
  project->further_clips = {2};
  ASSERT_TRUE(save_project(*project).ok());
  fs::create_directories(folder() / "clips");
  fs::create_directory_symlink("../../victim.likeness", folder() / "clips" / "2");
  EXPECT_FALSE(remove_further_clip(*project, 2).ok());
  EXPECT_TRUE(open_project(root_ / "victim.likeness").ok());
}

// The folder itself may stand elsewhere: a user's own link to a larger disk.
TEST_F(LinksInside, TheProjectsOwnFolderMayBeOne) {
  fs::create_directory_symlink(folder(), root_ / "short.likeness");
  EXPECT_TRUE(open_project(root_ / "short.likeness").ok());
}

}  // namespace
}  // namespace likeness
