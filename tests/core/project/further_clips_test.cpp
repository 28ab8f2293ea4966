// Claims about a project's list of further clips: who may be added, what of theirs follows the project, what
// they make old, and that taking one out leaves everything else.
#include "core/project/further_clips.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>

#include "core/base/files.h"
#include "core/capture/capture.h"
#include "core/project/care.h"
#include "core/project/damaged_project.h"
#include "core/project/staleness.h"
#include "core/video/decode.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class FurtherClips : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_clips_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    for (const auto& [file, grey] : {std::pair("first.mp4", 40), {"second.mp4", 90}, {"third.mp4", 160}})
      film(root_ / file, std::uint8_t(grey));
    ProjectOptions options;
    options.shared.video = root_ / "first.mp4";
    options.import.size = 512;
    options.shared.seed = 7;
    auto made = open_or_create_project(root_ / "me.likeness", options);
    ASSERT_TRUE(made.ok());
    project_ = std::move(*made);
  }
  void TearDown() override { fs::remove_all(root_); }

  static void film(const fs::path& path, std::uint8_t grey) {
    auto writer = VideoWriter::create(path, 64, 48);
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(writer->add(Image8(64, 48, 3, grey)).ok());
    ASSERT_TRUE(writer->finish().ok());
  }
  Result<int> add_seconds(const char* file, double from_s, double to_s) {
    return add_further_clip(project_, root_ / file, std::nullopt, {from_s, to_s});
  }
  // As an import leaves it whose film is cut after its first second: the rest shows another place.
  void read_first_clip() {
    Capture capture;
    capture.video = root_ / "first.mp4";
    capture.video_hash = *hash_video(capture.video);
    capture.width = 64, capture.height = 48, capture.crop.side = 48;
    for (int i = 0; i < 100; ++i) capture.frames.push_back({.frame = i, .time_s = i / 25.0});
    capture.shots = {{0, 24, 0, 1, true, ""}, {25, 99, 1, 4, false, "another place"}};
    ASSERT_TRUE(write_capture(capture_path(project_), capture).ok());
  }
  int add(const char* file) {
    const auto number = add_further_clip(project_, root_ / file);
    EXPECT_TRUE(number.ok()) << number.error().what;
    return number ? *number : 0;
  }

  fs::path root_;
  Project project_;
};

TEST_F(FurtherClips, AreKeptInOrderAndFollowTheProjectsChoices) {
  EXPECT_EQ(add("second.mp4"), 2);
  EXPECT_EQ(add("third.mp4"), 3);
  auto again = open_project(project_.folder);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->further_clips, (std::vector<int>{2, 3}));
  again->options.import.size = 256;
  again->options.shared.head_model = "/somewhere/head.npz";
  const auto clip = open_further_clip(*again, 3);
  ASSERT_TRUE(clip.ok());
  EXPECT_EQ(clip->options.shared.video, root_ / "third.mp4");
  EXPECT_EQ(clip->options.import.size, 256);
  EXPECT_EQ(clip->options.shared.head_model, "/somewhere/head.npz");
  EXPECT_EQ(clip->options.shared.seed, 7u);
  EXPECT_EQ(clip->first_clip, project_.folder);
  EXPECT_EQ(further_clip_name(*clip, 3), "Clip 3 (third.mp4)");
}

TEST_F(FurtherClips, TheSameClipTwiceOrNoClipAtAllIsRefused) {
  add("second.mp4");
  fs::copy_file(root_ / "second.mp4", root_ / "copy.mp4");
  for (const auto& [file, says] : {std::pair("first.mp4", "first clip"), {"copy.mp4", "clip 2"}}) {
    const auto refused = add_further_clip(project_, root_ / file);
    ASSERT_FALSE(refused.ok()) << file;
    EXPECT_NE(refused.error().what.find(says), std::string::npos) << refused.error().what;
    EXPECT_FALSE(refused.error().fix.empty());
  }
  ASSERT_TRUE(write_text(root_ / "torn.mp4", "no film").ok());
  EXPECT_FALSE(add_further_clip(project_, root_ / "torn.mp4").ok());
  EXPECT_FALSE(add_further_clip(project_, root_ / "absent.mp4").ok());
  EXPECT_EQ(open_project(project_.folder)->further_clips, std::vector<int>{2});
}

TEST_F(FurtherClips, SomeSecondsOfAClipAreKeptAndImportedByTheNextRun) {
  ASSERT_TRUE(add_seconds("second.mp4", 1, 2.5).ok());
  const auto clip = open_further_clip(*open_project(project_.folder), 2);
  ASSERT_TRUE(clip.ok());
  EXPECT_EQ(clip->options.import.seconds, (ClipSeconds{1, 2.5}));
  EXPECT_EQ(further_clip_name(*clip, 2), "Clip 2 (second.mp4 from 1 s to 2.5 s)");
  Project whole = *clip;
  whole.options.import.seconds = {};
  EXPECT_NE(input_hash(*clip, Stage::import), input_hash(whole, Stage::import));
}

TEST_F(FurtherClips, SecondsThatAClipDoesNotHaveAreRefused) {
  for (const auto& [from_s, to_s] :
       {std::pair(2.0, 1.0), {2.0, 2.0}, {-1.0, 2.0}, {4.5, 0.0}, {1.0, 9.0}, {NAN, 2.0}, {1.0, INFINITY}}) {
    const auto refused = add_seconds("second.mp4", from_s, to_s);
    ASSERT_FALSE(refused.ok()) << from_s << " to " << to_s;
    EXPECT_NE(refused.error().fix.find("--from"), std::string::npos) << refused.error().fix;
  }
  EXPECT_TRUE(add_seconds("second.mp4", 0, 4).ok());
  EXPECT_EQ(open_project(project_.folder)->further_clips, std::vector<int>{2});
}

// What is held out of the first clip must not be learnt from through another.
TEST_F(FurtherClips, OfAClipThatIsThereOnlyWhatDoesNotServeYet) {
  EXPECT_FALSE(add_seconds("first.mp4", 1, 4).ok());  // not read: all of it may serve
  read_first_clip();
  EXPECT_FALSE(add_seconds("first.mp4", 0.5, 4).ok());
  EXPECT_FALSE(add_seconds("first.mp4", 0, 0).ok());
  ASSERT_TRUE(add_seconds("first.mp4", 1, 2.5).ok());
  const auto refused = add_seconds("first.mp4", 2, 4);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().what.find("from 1 s to 2.5 s is already clip 2"), std::string::npos)
      << refused.error().what;
  EXPECT_TRUE(add_seconds("first.mp4", 2.5, 0).ok());
}

TEST_F(FurtherClips, NothingIsChangedWhileAnotherProcessWorks) {
  add("second.mp4");
  const auto lock = ProjectLock::acquire(project_);
  ASSERT_TRUE(lock.ok());
  EXPECT_FALSE(add_further_clip(project_, root_ / "third.mp4").ok());
  EXPECT_FALSE(remove_further_clip(project_, 2).ok());
  EXPECT_TRUE(fs::exists(further_clip_folder(project_, 2)));
}

TEST_F(FurtherClips, OneTakenOutLeavesNothingButItsFilm) {
  add("second.mp4");
  const std::string alone =
      input_hash(Project{.folder = project_.folder, .options = project_.options}, Stage::train);
  EXPECT_NE(input_hash(project_, Stage::train), alone);
  ASSERT_TRUE(remove_further_clip(project_, 2).ok());
  EXPECT_EQ(input_hash(project_, Stage::train), alone);
  EXPECT_FALSE(fs::exists(project_.folder / "clips"));
  EXPECT_TRUE(fs::exists(root_ / "second.mp4"));
  EXPECT_FALSE(remove_further_clip(project_, 2).ok());
  EXPECT_EQ(add("third.mp4"), 2);
}

TEST_F(FurtherClips, AFolderThatIsGoneIsSaidWithTheRemedy) {
  add("second.mp4");
  fs::remove_all(further_clip_folder(project_, 2));
  const auto clip = open_further_clip(project_, 2);
  ASSERT_FALSE(clip.ok());
  EXPECT_NE(clip.error().fix.find("--remove 2"), std::string::npos);
  EXPECT_TRUE(remove_further_clip(project_, 2).ok());
}

TEST_F(FurtherClips, ARepairedProjectStillHasThem) {
  add("second.mp4");
  add("third.mp4");
  ASSERT_TRUE(write_text(project_.folder / "project.json", "{\"program\": \"Likeness\", \"vid").ok());
  const auto repaired = repair_project(project_.folder);
  ASSERT_TRUE(repaired.ok()) << repaired.error().what;
  EXPECT_EQ(repaired->further_clips, (std::vector<int>{2, 3}));
}

TEST_F(FurtherClips, NumbersThatNameNoFolderAreDropped) {
  add("second.mp4");
  auto text = read_text(project_.folder / "project.json");
  ASSERT_TRUE(text.ok());
  const auto list = text->find("\"further_clips\": [");
  ASSERT_NE(list, std::string::npos);
  text->insert(list + 18, "1, -3, \"two\", 99999999999999, 2,");
  ASSERT_TRUE(write_text(project_.folder / "project.json", *text).ok());
  const auto opened = open_project(project_.folder);
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->further_clips, std::vector<int>{2});
}

TEST_F(FurtherClips, AFilmAmongThemStaysButNothingThatWasMadeOfIt) {
  add("second.mp4");
  const fs::path folder = further_clip_folder(project_, 2), film = folder / "film.mp4";
  fs::rename(root_ / "second.mp4", film);
  ASSERT_TRUE(relink_clip(folder, film).ok());
  ASSERT_TRUE(write_text(folder / "masks" / "000000.png", "x").ok());
  const auto deleted = delete_person(project_.folder, false);
  ASSERT_TRUE(deleted.ok()) << deleted.error().what;
  EXPECT_TRUE(fs::exists(film));
  EXPECT_FALSE(fs::exists(folder / "masks"));
  EXPECT_FALSE(fs::exists(folder / "project.json"));
  EXPECT_FALSE(fs::exists(project_.folder / "project.json"));
}

TEST_F(FurtherClips, GoWithADeletedPersonAndTheirFilmsStay) {
  add("second.mp4");
  fs::rename(root_ / "third.mp4", project_.folder / "third.mp4");
  const auto number = add_further_clip(project_, project_.folder / "third.mp4");
  ASSERT_TRUE(number.ok());
  const auto deleted = delete_person(project_.folder, false);
  ASSERT_TRUE(deleted.ok()) << deleted.error().what;
  EXPECT_FALSE(fs::exists(project_.folder / "clips"));
  EXPECT_TRUE(fs::exists(project_.folder / "third.mp4"));
  EXPECT_TRUE(fs::exists(root_ / "second.mp4"));
}

}  // namespace
}  // namespace likeness
