// Claims about projects whose project.json is damaged: they are told from other programs' folders, deleted
// without harm to anything else, and repaired from what is left.
#include "core/project/damaged_project.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"
#include "core/project/care.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class DamagedProjects : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_damaged_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    clip_ = root_ / "clip.mp4";
    ASSERT_TRUE(write_text(clip_, "the clip").ok());
    folder_ = make(root_ / "me.likeness", clip_);
  }
  void TearDown() override { fs::remove_all(root_); }

  static fs::path make(const fs::path& folder, const fs::path& clip) {
    ProjectOptions options;
    options.shared.video = clip;
    options.import.size = 512;
    options.shared.head_model = "/heads/one.npz";
    EXPECT_TRUE(open_or_create_project(folder, options).ok());
    for (const char* file : {"frames/000000.png", "exports/orbit-001.mp4", "avatar.bin", "room.bin"})
      EXPECT_TRUE(write_text(folder / file, "x").ok());
    return folder;
  }
  static void cut(const fs::path& folder, double share) {
    const std::string text = *read_text(folder / "project.json");
    ASSERT_TRUE(
        write_text(folder / "project.json", text.substr(0, std::size_t(share * double(text.size())))).ok());
  }
  static void write_import(const fs::path& folder, const fs::path& clip) {
    Capture capture;
    capture.video = clip;
    capture.video_hash = "0";
    capture.size = 512, capture.split = Split::random30;
    capture.width = capture.height = 64, capture.crop = {0, 0, 64}, capture.frames_per_second = 25;
    for (int i = 0; i < 10; ++i) capture.frames.push_back({i, i / 25.0, 100, i == 9, i != 9, ""});
    ASSERT_TRUE(write_capture(folder / "capture.json", capture).ok());
  }

  fs::path root_, clip_, folder_;
};

TEST_F(DamagedProjects, AWholeProjectIsNotDamaged) {
  EXPECT_FALSE(find_damaged_project(folder_).has_value());
  EXPECT_FALSE(find_damaged_project(root_ / "absent").has_value());
}

TEST_F(DamagedProjects, ACutOneStillNamesItsClip) {
  cut(folder_, 0.9);
  const auto damaged = find_damaged_project(folder_);
  ASSERT_TRUE(damaged.has_value());
  EXPECT_EQ(damaged->clips, std::vector{clip_});
  EXPECT_EQ(damaged->options.shared.head_model, "/heads/one.npz");
  EXPECT_FALSE(damaged->newer);
}

TEST_F(DamagedProjects, AnotherProgramsFolderIsNotTaken) {
  for (const char* text : {"{\"name\": \"web site\"}", "", "{", "{\"program\": \"Other\"}"}) {
    ASSERT_TRUE(write_text(root_ / "site" / "project.json", text).ok());
    ASSERT_TRUE(write_text(root_ / "site" / "frames" / "a.png", "mine").ok());
    EXPECT_FALSE(find_damaged_project(root_ / "site").has_value()) << text;
    EXPECT_FALSE(delete_person(root_ / "site", false).ok()) << text;
    EXPECT_FALSE(repair_project(root_ / "site").ok()) << text;
    EXPECT_EQ(*read_text(root_ / "site" / "frames" / "a.png"), "mine") << text;
    EXPECT_EQ(*read_text(root_ / "site" / "project.json"), text);
  }
  // It is Likeness's where something in it is.
  write_import(root_ / "site", clip_);
  EXPECT_TRUE(find_damaged_project(root_ / "site").has_value());
}

TEST_F(DamagedProjects, AreDeletedAndTheClipStays) {
  cut(folder_, 0.9);
  ASSERT_TRUE(write_text(folder_ / "notes.txt", "mine").ok());
  const auto deleted = delete_person(folder_, false);
  ASSERT_TRUE(deleted.ok()) << deleted.error().what;
  EXPECT_TRUE(deleted->clip_known);
  EXPECT_EQ(deleted->kept, std::vector<std::string>{"notes.txt"});
  EXPECT_EQ(*read_text(clip_), "the clip");
  EXPECT_EQ(deletion_words(*deleted).find("films in them"), std::string::npos);
}

TEST_F(DamagedProjects, AClipInsideIsKeptEvenIfItIsNotKnownWhichItIs) {
  ASSERT_TRUE(write_text(folder_ / "frames" / "holiday.MOV", "the clip").ok());
  ASSERT_TRUE(write_text(folder_ / "project.json", std::string(300, '\0')).ok());
  const auto deleted = delete_person(folder_, false);
  ASSERT_TRUE(deleted.ok()) << deleted.error().what;
  EXPECT_FALSE(deleted->clip_known);
  EXPECT_EQ(*read_text(folder_ / "frames" / "holiday.MOV"), "the clip");
  EXPECT_TRUE(fs::exists(folder_ / "exports" / "orbit-001.mp4"));
  EXPECT_FALSE(fs::exists(folder_ / "avatar.bin"));
  EXPECT_FALSE(fs::exists(folder_ / "room.bin"));
  EXPECT_NE(deletion_words(*deleted).find("exports"), std::string::npos);
  EXPECT_NE(deletion_words(*deleted).find("films in them were kept"), std::string::npos);
}

TEST_F(DamagedProjects, ARememberedClipInsideIsKeptAndTheExportsGo) {
  const fs::path inside = folder_ / "frames" / "holiday.mov";
  ASSERT_TRUE(write_text(inside, "the clip").ok());
  write_import(folder_, inside);
  ASSERT_TRUE(write_text(folder_ / "project.json", "").ok());
  const auto deleted = delete_person(folder_, false);
  ASSERT_TRUE(deleted.ok()) << deleted.error().what;
  EXPECT_TRUE(deleted->clip_known);
  EXPECT_EQ(*read_text(inside), "the clip");
  EXPECT_FALSE(fs::exists(folder_ / "exports"));
}

TEST_F(DamagedProjects, AreRepairedFromWhatIsLeft) {
  write_import(folder_, clip_);
  const std::string broken = "{\"program\": \"Likeness\", \"head_model\": \"/heads/two.npz\", ";
  ASSERT_TRUE(write_text(folder_ / "project.json", broken).ok());
  const auto repaired = repair_project(folder_);
  ASSERT_TRUE(repaired.ok()) << repaired.error().what;
  const auto opened = open_project(folder_);
  ASSERT_TRUE(opened.ok());
  EXPECT_EQ(opened->options.shared.video, clip_);
  EXPECT_EQ(opened->options.import.size, 512);
  EXPECT_EQ(opened->options.import.split, Split::random30);
  EXPECT_EQ(opened->options.shared.head_model, "/heads/two.npz");
  EXPECT_EQ(opened->consent, Consent::not_asked);
  EXPECT_EQ(opened->record(Stage::train).state, StageState::to_do);
  EXPECT_EQ(*read_text(folder_ / "avatar.bin"), "x");
  EXPECT_EQ(*read_text(folder_ / "project.damaged.json"), broken);
  // Whatever was kept of the damage goes with the person.
  EXPECT_TRUE(delete_person(folder_, false)->folder_gone);
}

TEST_F(DamagedProjects, AWholeOrANewerOneIsNotRepaired) {
  const std::string before = *read_text(folder_ / "project.json");
  EXPECT_TRUE(repair_project(folder_).ok());
  EXPECT_EQ(*read_text(folder_ / "project.json"), before);
  ASSERT_TRUE(write_text(folder_ / "project.json", "{\"version\": 1000}").ok());
  EXPECT_TRUE(find_damaged_project(folder_)->newer);
  EXPECT_FALSE(repair_project(folder_).ok());
  EXPECT_EQ(*read_text(folder_ / "project.json"), "{\"version\": 1000}");
}

TEST_F(DamagedProjects, WhatIsAtWorkIsNeitherDeletedNorRepaired) {
  cut(folder_, 0.5);
  const auto lock = ProjectLock::acquire({.folder = folder_});
  ASSERT_TRUE(lock.ok());
  EXPECT_FALSE(delete_person(folder_, false).ok());
  EXPECT_FALSE(repair_project(folder_).ok());
  EXPECT_TRUE(fs::exists(folder_ / "avatar.bin"));
}

}  // namespace
}  // namespace likeness
