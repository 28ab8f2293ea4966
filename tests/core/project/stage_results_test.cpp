// Claims about results that were altered since: none counts as current, and none is lost.
#include "core/project/stage_results.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <functional>

#include "core/base/files.h"
#include "core/project/staleness.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class StageResults : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_results_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    ASSERT_TRUE(write_text(root_ / "clip.mp4", "the clip").ok());
    auto made = open_or_create_project(root_ / "me.likeness", {.shared = {.video = root_ / "clip.mp4"}});
    ASSERT_TRUE(made.ok());
    project_ = *made;
    for (const char* file :
         {"capture.json", "cameras.json", "track.json", "frames/000000.png", "masks/000000.png",
          "regions/000000.png", "plate.png", "plate.json", "matte_report.json", "avatar.bin"})
      ASSERT_TRUE(write_text(project_.folder / file, "as it was made").ok());
    for (const Stage stage : kStages) {
      StageRecord& record = project_.record(stage);
      record.state = StageState::done, record.input_hash = input_hash(project_, stage);
      record.results = stage_results(project_, stage), record.pictures_hash = pictures_hash(project_, stage);
    }
  }
  void TearDown() override { fs::remove_all(root_); }
  fs::path root_;
  Project project_;
};

TEST_F(StageResults, AnyChangeOfAFileMakesItsStageStale) {
  const std::vector<std::pair<Stage, const char*>> files{
      {Stage::import, "capture.json"}, {Stage::align, "cameras.json"}, {Stage::fit, "track.json"},
      {Stage::matte, "plate.png"},     {Stage::matte, "plate.json"},   {Stage::matte, "matte_report.json"},
      {Stage::train, "avatar.bin"}};
  const std::vector<std::function<void(const fs::path&)>> harms{
      [](const fs::path& path) { fs::remove(path); }, [](const fs::path& path) { fs::resize_file(path, 5); },
      [](const fs::path& path) { (void)write_text(path, ""); },
      [](const fs::path& path) { (void)write_text(path, "as it was mads"); },
      [](const fs::path& path) { fs::remove(path), fs::create_directory(path); }};
  for (const auto& [stage, file] : files)
    for (std::size_t harm = 0; harm < harms.size(); ++harm) {
      const fs::path path = project_.folder / file;
      EXPECT_TRUE(is_current_alone(project_, stage)) << file;
      harms[harm](path);
      EXPECT_FALSE(is_current_alone(project_, stage)) << file << " " << harm;
      fs::remove_all(path);
      ASSERT_TRUE(write_text(path, "as it was made").ok());
    }
}

TEST_F(StageResults, APictureIsMissedAtOnceAndLookedIntoBeforeARun) {
  for (const auto& [stage, file] : {std::pair(Stage::import, "frames/000000.png"),
                                    {Stage::matte, "masks/000000.png"},
                                    {Stage::matte, "regions/000000.png"}}) {
    const std::string whole = pictures_hash(project_, stage);
    ASSERT_TRUE(write_text(project_.folder / file, "as it was mads").ok());
    EXPECT_NE(pictures_hash(project_, stage), whole) << file;
    fs::remove(project_.folder / file);
    EXPECT_FALSE(is_current_alone(project_, stage)) << file;
    ASSERT_TRUE(write_text(project_.folder / file, "as it was made").ok());
    EXPECT_EQ(pictures_hash(project_, stage), whole) << file;
  }
}

TEST_F(StageResults, WhatWasChangedIsKeptBesideAndNothingElse) {
  EXPECT_TRUE(keep_changed(project_, Stage::fit)->empty());
  for (const char* name : {"track.changed.json", "track.changed-2.json"}) {
    ASSERT_TRUE(write_text(project_.folder / "track.json", name).ok());
    const auto kept = keep_changed(project_, Stage::fit);
    ASSERT_TRUE(kept.ok()) << kept.error().what;
    EXPECT_EQ(*kept, std::vector<std::string>{name});
    EXPECT_EQ(*read_text(project_.folder / name), name);
  }
  EXPECT_EQ(*read_text(project_.folder / "track.json"), "track.changed-2.json") << "until a run replaces it";
  // What was removed, as our own messages advise, is nobody's edit, and what lies beside it is whole.
  fs::remove(project_.folder / "plate.png"), fs::remove_all(project_.folder / "regions");
  EXPECT_FALSE(is_current_alone(project_, Stage::matte));
  EXPECT_TRUE(keep_changed(project_, Stage::matte)->empty());
}

TEST_F(StageResults, APictureThatIsNotOursChangesNothing) {
  for (const char* name : {"frames/sheet.png", "masks/._000000.png"})
    ASSERT_TRUE(write_text(project_.folder / name, "somebody's").ok());
  EXPECT_TRUE(is_current_alone(project_, Stage::import));
  EXPECT_TRUE(is_current_alone(project_, Stage::matte));
}

TEST_F(StageResults, AProjectFromBeforeHashesWereKeptStaysCurrent) {
  for (const Stage stage : kStages) project_.record(stage).results.clear();
  for (const Stage stage : kStages) EXPECT_TRUE(is_current_alone(project_, stage));
  EXPECT_FALSE(results_readable(project_, Stage::fit)) << "a run looks whether it can be read";
}

}  // namespace
}  // namespace likeness
