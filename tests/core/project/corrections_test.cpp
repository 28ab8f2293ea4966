// Claims about the strokes painted on a project's masks: they survive in their folder, make what is built on
// them stale, and a damaged file stops the stage before anything is lost.
#include "core/project/corrections.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/head/builtin_head.h"
#include "core/project/own_names.h"
#include "core/project/run_stages.h"
#include "core/project/staleness.h"
#include "core/scene/track.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

const Strokes kSome{{StrokeMark::person, 12.5, {{10, 20}, {30.25, 40}}}};
const Strokes kOthers{{StrokeMark::background, 3, {{1, 2}}}, {StrokeMark::erase, 2, {{1, 2}}}};

class Corrections : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_corrections_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    ASSERT_TRUE(write_text(root_ / "clip.mp4", "the clip").ok());
    ProjectOptions options;
    options.shared.video = root_ / "clip.mp4";
    options.shared.person_network = "none";  // whatever is installed here
    auto made = open_or_create_project(root_ / "me.likeness", options);
    ASSERT_TRUE(made.ok()) << made.error().what;
    project_ = *made;
    write_results();
  }
  void TearDown() override { fs::remove_all(root_); }

  // As if all stages had come to their end.
  void write_results() {
    Capture capture;
    capture.video_hash = *hash_file(root_ / "clip.mp4");
    capture.width = capture.height = 64, capture.crop = {0, 0, 64}, capture.frames_per_second = 25;
    capture.frames.push_back({0, 0, 100, false, true, ""});
    ASSERT_TRUE(write_capture(capture_path(project_), capture).ok());
    CameraSet cameras;
    cameras.cameras.push_back({-1, {64, 64, 60, 60, 32, 32}, Pose::Identity()});
    ASSERT_TRUE(write_cameras(cameras_path(project_), cameras).ok());
    const HeadModel model = make_builtin_head();
    Track track;
    track.head_model_hash = model.hash;
    track.person.identity = Eigen::VectorXf::Zero(model.identity_count());
    track.neutral.expression = Eigen::VectorXf::Zero(model.expression_count());
    ASSERT_TRUE(write_track(track_path(project_), track).ok());
    for (const char* file : {"frames/000000.png", "masks/000000.png", "plate.png", "avatar.bin"})
      ASSERT_TRUE(write_text(project_.folder / file, "x").ok());
    for (const Stage stage : kStages) {
      project_.record(stage).state = StageState::done;
      project_.record(stage).input_hash = input_hash(project_, stage);
    }
    ASSERT_TRUE(save_project(project_).ok());
  }

  fs::path root_;
  Project project_;
};

TEST_F(Corrections, SurviveInTheFolderFrameByFrame) {
  EXPECT_TRUE(read_corrections(project_)->empty());
  ASSERT_TRUE(save_corrections(project_, 12, kSome).ok());
  ASSERT_TRUE(save_corrections(project_, 1234567, kOthers).ok());
  const auto read = read_corrections(project_);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(*read, (FrameStrokes{{12, kSome}, {1234567, kOthers}}));
  // What else lies there is none of them.
  for (const char* other : {"12.json", "000013.damaged.json", "notes.txt", "-00001.json", "000014.json.part"})
    ASSERT_TRUE(write_text(corrections_path(project_) / other, "x").ok());
  EXPECT_EQ(corrected_frames(project_), (std::vector<int>{12, 1234567}));
}

TEST_F(Corrections, TakenBackLeaveTheFolderAsItWas) {
  ASSERT_TRUE(save_corrections(project_, 12, kSome).ok());
  ASSERT_TRUE(save_corrections(project_, 12, {}).ok());
  EXPECT_FALSE(fs::exists(corrections_path(project_)));
  EXPECT_TRUE(save_corrections(project_, 12, {}).ok()) << "nothing to take back is no fault";
}

TEST_F(Corrections, MakeTheMasksAndWhatFollowsStaleAndNothingElse) {
  for (const Stage stage : kStages) ASSERT_TRUE(is_current(project_, stage)) << stage_name(stage);
  ASSERT_TRUE(save_corrections(project_, 12, kSome).ok());
  const Freshness painted = read_freshness(project_);
  for (const Stage stage : kStages)
    EXPECT_EQ(painted.stale[std::size_t(stage)], stage >= Stage::matte) << stage_name(stage);
  const std::string first = input_hash(project_, Stage::matte);
  ASSERT_TRUE(save_corrections(project_, 12, kOthers).ok());
  EXPECT_NE(input_hash(project_, Stage::matte), first);
  ASSERT_TRUE(save_corrections(project_, 12, {}).ok());
  ASSERT_TRUE(save_corrections(project_, 13, kSome).ok());
  EXPECT_NE(input_hash(project_, Stage::matte), first) << "the same strokes on another frame";
  ASSERT_TRUE(save_corrections(project_, 13, {}).ok());
  for (const Stage stage : kStages) EXPECT_TRUE(is_current(project_, stage)) << stage_name(stage);
}

TEST_F(Corrections, ProjectsFromBeforeThemAreNotStale) {
  const auto content = [](const fs::path& path) { return *hash_file(path); };
  EXPECT_EQ(input_hash(project_, Stage::matte),
            hash_text(fmt::format("matte 4\n{} {} {} none", content(capture_path(project_)),
                                  content(cameras_path(project_)), content(track_path(project_)))));
}

TEST_F(Corrections, ADamagedFileEndsTheStageWithARemedyAndNothingIsLost) {
  ASSERT_TRUE(save_corrections(project_, 12, kSome).ok());
  ASSERT_TRUE(write_text(strokes_path(project_, 13), "{\"format\":").ok());
  EXPECT_FALSE(read_corrections(project_).ok());
  const auto outcome = run_stages(project_, Stage::matte, Progress(), {}, {});
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().code, ErrorCode::bad_input);
  EXPECT_NE(outcome.error().what.find("000013.json"), std::string::npos) << outcome.error().what;
  EXPECT_FALSE(outcome.error().fix.empty());
  EXPECT_EQ(project_.record(Stage::matte).state, StageState::failed);
  EXPECT_EQ(*read_text(project_.folder / "masks/000000.png"), "x");
  EXPECT_EQ(*read_text(strokes_path(project_, 13)), "{\"format\":");
  // Set aside, it is out of the way and still there.
  const auto aside = set_aside_strokes(project_, 13);
  ASSERT_TRUE(aside.ok()) << aside.error().what;
  EXPECT_EQ(*read_text(*aside), "{\"format\":");
  EXPECT_EQ(*read_corrections(project_), (FrameStrokes{{12, kSome}}));
  ASSERT_TRUE(write_text(strokes_path(project_, 13), "again").ok());
  const auto second = set_aside_strokes(project_, 13);
  ASSERT_TRUE(second.ok());
  EXPECT_NE(*second, *aside);
  EXPECT_EQ(*read_text(*aside), "{\"format\":");
}

TEST_F(Corrections, OfAnotherClipAreSetAsideWhole) {
  ASSERT_TRUE(save_corrections(project_, 12, kSome).ok());
  const auto aside = set_aside_corrections(project_);
  ASSERT_TRUE(aside.ok()) << aside.error().what;
  EXPECT_TRUE(corrected_frames(project_).empty());
  EXPECT_EQ(*read_strokes(*aside / "000012.json"), kSome);
  // Nor does the next clip's work take the place of the first one's.
  ASSERT_TRUE(save_corrections(project_, 3, {kSome.front()}).ok());
  const auto second = set_aside_corrections(project_);
  ASSERT_TRUE(second.ok()) << second.error().what;
  EXPECT_NE(*second, *aside);
  EXPECT_EQ(*read_strokes(*aside / "000012.json"), kSome);
  EXPECT_TRUE(fs::exists(*second / "000003.json"));
  for (const fs::path& folder : {*aside, *second, corrections_path(project_)})
    EXPECT_TRUE(is_corrections_folder(folder.filename().string())) << folder;
  EXPECT_FALSE(is_corrections_folder("corrections.txt"));
}

}  // namespace
}  // namespace likeness
