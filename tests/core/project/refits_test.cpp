// Claims about spans fitted again in a project: what is remembered, what is stale by it, and the way back.
#include "core/project/refits.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"
#include "core/head/builtin_head.h"
#include "core/project/staleness.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class ProjectRefits : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_refits_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    auto made = open_or_create_project(root_ / "p", {.shared = {.video = root_ / "gone.mp4"}});
    ASSERT_TRUE(made.ok());
    project_ = *made;
    first_.head_model_hash = model_.hash;
    first_.person.identity = Eigen::VectorXf::Zero(model_.identity_count());
    first_.neutral = neutral_articulation(model_);
    for (int i = 0; i < 30; ++i) {
      TrackedFrame& frame = first_.frames.emplace_back();
      frame.frame = i;
      frame.pose.articulation = neutral_articulation(model_);
      frame.inner_error_px = 1 + 0.1 * i;
    }
    ASSERT_TRUE(write_track(track_path(project_), first_).ok());
  }
  void TearDown() override { fs::remove_all(root_); }

  Result<Track> apply(bool fitted) {
    const RefitWork work{capture_, cameras_, model_, {}, "inputs", fitted};
    outcomes_.clear(), warnings_.clear();
    const auto first = first_track(project_, work);
    if (!first) return first.error();
    if (!*first) return Error{ErrorCode::failed, "the whole clip is to be fitted", "", ""};
    return apply_refits(project_, work, **first, outcomes_, warnings_, Progress(), {});
  }
  std::string text(const fs::path& path) { return read_text(path).ok() ? *read_text(path) : "absent"; }

  const HeadModel model_ = make_builtin_head();
  fs::path root_;
  Project project_;
  Capture capture_;
  CameraSet cameras_;
  Track first_;
  std::vector<RefitOutcome> outcomes_;
  std::vector<std::string> warnings_;
};

TEST_F(ProjectRefits, AreRememberedMerged) {
  project_.options.fit.refits = {{20, 22}, {4, 6}, {7, 9}};
  ASSERT_TRUE(save_project(project_).ok());
  const auto opened = open_project(project_.folder);
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->options.fit.refits, (std::vector<RefitSpan>{{4, 9}, {20, 22}}));
}

TEST_F(ProjectRefits, AProjectFromBeforeThemOpens) {
  std::string json = text(project_.folder / "project.json");
  const std::size_t at = json.find("\"refits\": [],");
  ASSERT_NE(at, std::string::npos);
  json.erase(at, 13);
  ASSERT_TRUE(write_text(project_.folder / "project.json", json).ok());
  const auto opened = open_project(project_.folder);
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_TRUE(opened->options.fit.refits.empty());
}

TEST_F(ProjectRefits, CountForTheFitOnlyWhereThereAreAny) {
  const auto hash = [&](std::vector<RefitSpan> spans, Stage stage) {
    Project other = project_;
    other.options.fit.refits = std::move(spans);
    return input_hash(other, stage);
  };
  const std::string none = input_hash(project_, Stage::fit);
  EXPECT_EQ(hash({}, Stage::fit), none);
  EXPECT_NE(hash({{3, 5}}, Stage::fit), none);
  EXPECT_NE(hash({{3, 5}}, Stage::fit), hash({{3, 6}}, Stage::fit));
  EXPECT_EQ(hash({{3, 5}, {9, 9}}, Stage::fit), hash({{9, 9}, {3, 4}, {5, 5}}, Stage::fit));
  for (const Stage other : {Stage::import, Stage::align})
    EXPECT_EQ(hash({{3, 5}}, other), input_hash(project_, other));
}

TEST_F(ProjectRefits, OutcomesReadBack) {
  const Refits written{"0123", {{{3, 5}, 3, 2, 1, 0}, {{9, 9}, 1, 1, 1, 0}}};
  ASSERT_TRUE(write_refits(project_, written).ok());
  const auto read = read_refits(project_);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(read->fit_inputs, "0123");
  EXPECT_EQ(read->outcomes, written.outcomes);
  EXPECT_EQ(find_refit(read->outcomes, 4), &read->outcomes[0]);
  EXPECT_EQ(find_refit(read->outcomes, 6), nullptr);
  ASSERT_TRUE(write_text(refits_path(project_), "{\"version\": 1").ok());
  EXPECT_FALSE(read_refits(project_).ok());
}

TEST_F(ProjectRefits, ASpanThatFailsLeavesTheTrackAsItWas) {
  const std::string before = text(track_path(project_));
  project_.options.fit.refits = {{3, 5}};
  EXPECT_FALSE(apply(true).ok());  // the clip is gone
  EXPECT_EQ(text(track_path(project_)), before);
  EXPECT_EQ(text(first_track_path(project_)), before);
  // Taken back, nothing is left of it.
  project_.options.fit.refits.clear();
  ASSERT_TRUE(apply(false).ok());
  EXPECT_EQ(text(track_path(project_)), before);
  EXPECT_FALSE(fs::exists(first_track_path(project_)));
  EXPECT_FALSE(fs::exists(refits_path(project_)));
}

// As two spans left it, whose clip is gone: what is there needs no fit, what is taken back comes to the bit.
TEST_F(ProjectRefits, SpansThatAreThereStayAndEachCanBeTakenBack) {
  const std::string before = text(track_path(project_));
  ASSERT_TRUE(write_text(first_track_path(project_), before).ok());
  Track fitted = first_;
  for (const int i : {3, 4, 5, 9}) fitted.frames[std::size_t(i)].inner_error_px = 0.5;
  ASSERT_TRUE(write_track(track_path(project_), fitted).ok());
  ASSERT_TRUE(write_refits(project_, {"inputs", {{{3, 5}, 3, 3, 3, 0}, {{9, 9}, 1, 1, 1, 0}}}).ok());
  project_.options.fit.refits = {{3, 5}, {9, 9}};
  ASSERT_TRUE(apply(false).ok());
  EXPECT_EQ(outcomes_.size(), 2u);
  project_.options.fit.refits = {{9, 9}, {28, 40}};
  const auto one = apply(false);
  ASSERT_TRUE(one.ok()) << one.error().what;
  EXPECT_EQ(warnings_.size(), 1u) << "frames 28 to 40 are not in the clip";
  EXPECT_EQ(one->frames[4].inner_error_px, first_.frames[4].inner_error_px);
  EXPECT_EQ(one->frames[9].inner_error_px, 0.5);
  project_.options.fit.refits.clear();
  ASSERT_TRUE(apply(false).ok());
  EXPECT_EQ(text(track_path(project_)), before);
}

TEST_F(ProjectRefits, OtherInputsAskForTheWholeClip) {
  ASSERT_TRUE(write_text(first_track_path(project_), text(track_path(project_))).ok());
  ASSERT_TRUE(write_refits(project_, {"other inputs", {}}).ok());
  const RefitWork work{capture_, cameras_, model_, {}, "inputs", false};
  const auto first = first_track(project_, work);
  ASSERT_TRUE(first.ok());
  EXPECT_FALSE(first->has_value());
}

TEST_F(ProjectRefits, AreRefusedInPlainWords) {
  const auto early = check_project_refits(project_, {{3, 5}});
  ASSERT_FALSE(early.ok());
  EXPECT_EQ(early.error().what, "This project is not fitted yet.");
  project_.record(Stage::fit).state = StageState::done;
  EXPECT_TRUE(check_project_refits(project_, {{3, 5}}).ok());
  const auto outside = check_project_refits(project_, {{3, 50}});
  ASSERT_FALSE(outside.ok());
  EXPECT_EQ(outside.error().what, "The clip has no frames 3 to 50.");
  EXPECT_EQ(outside.error().fix, "Its frames are 0 to 29.");
}

TEST_F(ProjectRefits, OfAFilmThatWasCutOnlyShotsThatServeAreFittedAgain) {
  auto track = read_track(track_path(project_));
  ASSERT_TRUE(track) << track.error().what;
  track->shots = {{0, 9}, {20, 29}};
  const auto left_out = check_refits(*track, {{12, 14}});
  ASSERT_FALSE(left_out);
  EXPECT_NE(left_out.error().what.find("frames 12 to 14 is left out"), std::string::npos);
  EXPECT_TRUE(check_refits(*track, {{8, 12}}));
}

}  // namespace
}  // namespace likeness
