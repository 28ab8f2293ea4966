// Claims about the study of camera kinds: what its clips cover, that its judgement is honest, and that it
// goes on where it was stopped.
#include "core/lab/truth/kind_study.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/synth/demo_shots.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

using enum CameraKind;

int clips_with(bool (*has)(const DemoOptions&)) {
  return int(std::ranges::count_if(kind_clips(), [&](const KindClip& clip) { return has(clip.film); }));
}

TEST(KindClips, CoverEveryCameraBeforeEveryWallThatTellsSomething) {
  std::set<std::pair<DemoCamera, DemoWall>> covered;
  for (const KindClip& clip : kind_clips()) covered.emplace(clip.film.camera, clip.film.wall);
  for (const DemoCamera camera : {DemoCamera::resting, DemoCamera::handheld, DemoCamera::walking})
    for (const DemoWall wall : {DemoWall::furnished, DemoWall::plain, DemoWall::textured})
      EXPECT_TRUE(covered.contains({camera, wall})) << int(camera) << " before " << int(wall);
  for (const DemoCamera camera : {DemoCamera::zoom, DemoCamera::slide})
    for (const DemoWall wall : {DemoWall::furnished, DemoWall::textured})
      EXPECT_TRUE(covered.contains({camera, wall})) << int(camera) << " before " << int(wall);
  EXPECT_TRUE(covered.contains({DemoCamera::guided, DemoWall::furnished}));
}

TEST(KindClips, VaryWhatAFilmCanVaryIn) {
  using Film = const DemoOptions&;
  EXPECT_EQ(kind_clips().size(), 24u);
  EXPECT_GE(clips_with([](Film f) { return f.height > f.width; }), 5);
  EXPECT_GE(clips_with([](Film f) { return f.camera == DemoCamera::handheld && f.hand_turn_deg <= 1; }), 3);
  EXPECT_GE(clips_with([](Film f) { return f.camera == DemoCamera::handheld && f.hand_turn_deg >= 6; }), 4);
  EXPECT_GE(clips_with([](Film f) { return f.camera == DemoCamera::handheld && f.hand_shift_m > 0.009; }), 3);
  EXPECT_GE(clips_with([](Film f) { return f.drift; }), 3);
  EXPECT_GE(clips_with([](Film f) { return f.motion_blur; }), 3);
  EXPECT_GE(clips_with([](Film f) { return f.lens_tag; }), 3);
  std::set<int> persons, lights, seeds;
  std::set<std::string> names, films;
  for (const KindClip& clip : kind_clips()) {
    persons.insert(clip.film.person), lights.insert(clip.film.light), seeds.insert(clip.film.seed);
    names.insert(clip.name), films.insert(demo_words(clip.film));
    EXPECT_GE(std::min(clip.film.width, clip.film.height), 180) << clip.name;
    EXPECT_GE(clip.film.frames, 75) << clip.name;
  }
  EXPECT_EQ(persons.size(), 6u);
  EXPECT_EQ(lights.size(), 3u);
  EXPECT_EQ(seeds.size(), kind_clips().size());
  EXPECT_EQ(names.size(), kind_clips().size());
  EXPECT_EQ(films.size(), kind_clips().size());
}

// Shots of other places show other walls: no kind is true of all of them.
TEST(KindClips, StayInOnePlaceAndSomeAreCutCloser) {
  std::set<CutKind> kinds;
  for (const KindClip& clip : kind_clips())
    for (const DemoShot& shot : demo_shots(clip.film)) {
      EXPECT_EQ(shot.place, 0) << clip.name;
      kinds.insert(shot.kind);
    }
  EXPECT_EQ(kinds, (std::set<CutKind>{CutKind::opening, CutKind::jump, CutKind::punch_in}));
}

TEST(KindClips, AreChosenByNameInTheirOrder) {
  const auto all = kind_clips_named({});
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->size(), kind_clips().size());
  const auto two = kind_clips_named({"walk-plain", "rest-plain"});
  ASSERT_TRUE(two.ok());
  ASSERT_EQ(two->size(), 2u);
  EXPECT_EQ((*two)[0].name, "rest-plain");
  const auto none = kind_clips_named({"rest-plain", "rest-marble"});
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().what.find("rest-marble"), std::string::npos);
  EXPECT_NE(none.error().fix.find("rest-textured"), std::string::npos);
}

TEST(DemoWords, DifferWhereTheFilmDoes) {
  const DemoOptions film = {.camera = DemoCamera::handheld};
  const std::string words = demo_words(film);
  EXPECT_NE(words.find("--camera handheld"), std::string::npos) << words;
  EXPECT_NE(words.find("--hand-shift 1.5"), std::string::npos) << words;
  for (const auto change :
       {+[](DemoOptions& o) { o.width = 320; }, +[](DemoOptions& o) { o.height = 320; },
        +[](DemoOptions& o) { o.frames = 9; }, +[](DemoOptions& o) { o.samples_per_pixel = 1; },
        +[](DemoOptions& o) { o.person = 1; }, +[](DemoOptions& o) { o.light = 1; },
        +[](DemoOptions& o) { o.seed = 1; }, +[](DemoOptions& o) { o.camera = DemoCamera::slide; },
        +[](DemoOptions& o) { o.hand_turn_deg = 1; }, +[](DemoOptions& o) { o.hand_shift_m = 0.01; },
        +[](DemoOptions& o) { o.cuts = 1; }, +[](DemoOptions& o) { o.hair = DemoHair::loose; },
        +[](DemoOptions& o) { o.wall = DemoWall::plain; }, +[](DemoOptions& o) { o.still_torso = true; },
        +[](DemoOptions& o) { o.drift = true; }, +[](DemoOptions& o) { o.motion_blur = true; },
        +[](DemoOptions& o) { o.lens_tag = true; }, +[](DemoOptions& o) { o.habit = true; },
        +[](DemoOptions& o) { o.restless_head = true; }}) {
    DemoOptions other = film;
    change(other);
    EXPECT_NE(demo_words(other), words);
  }
}

TEST(JudgeKind, OnlyTheTrueKindThatWasShownIsRight) {
  for (const DemoWall wall : {DemoWall::furnished, DemoWall::textured, DemoWall::plain})
    for (const CameraKind truth : {resting, handheld, walking}) {
      EXPECT_EQ(judge_kind(wall, truth, KindFound{truth, false}), KindOutcome::right);
      EXPECT_EQ(judge_kind(wall, truth, std::nullopt), KindOutcome::wrong);
    }
  for (const CameraKind truth : {resting, handheld, walking})
    for (const CameraKind found : {resting, handheld, walking}) {
      if (found == truth) continue;
      EXPECT_EQ(judge_kind(DemoWall::furnished, truth, KindFound{found, false}), KindOutcome::wrong);
      EXPECT_EQ(judge_kind(DemoWall::furnished, truth, KindFound{found, true}), KindOutcome::wrong);
    }
}

TEST(JudgeKind, WhatIsAssumedBeforeAWallThatShowsItIsRightByDefaultAlone) {
  for (const DemoWall wall : {DemoWall::furnished, DemoWall::textured}) {
    EXPECT_EQ(judge_kind(wall, resting, KindFound{resting, true}), KindOutcome::by_default);
    EXPECT_EQ(judge_kind(wall, handheld, KindFound{handheld, true}), KindOutcome::by_default);
    EXPECT_EQ(judge_kind(wall, handheld, KindFound{resting, true}), KindOutcome::wrong);
  }
}

TEST(JudgeKind, BeforeAPlainWallToTakeItToRestIsNeitherRightNorWrong) {
  for (const CameraKind truth : {resting, handheld, walking})
    EXPECT_EQ(judge_kind(DemoWall::plain, truth, KindFound{resting, true}), KindOutcome::untold);
  // To claim that it was seen to rest is wrong of a camera that moves.
  EXPECT_EQ(judge_kind(DemoWall::plain, handheld, KindFound{resting, false}), KindOutcome::wrong);
  EXPECT_EQ(judge_kind(DemoWall::plain, resting, KindFound{handheld, true}), KindOutcome::wrong);
}

TEST(JudgeKind, AWalkAlongAFlatWallMayBeCalledHandHeldButNotAtRest) {
  EXPECT_EQ(judge_kind(DemoWall::textured, walking, KindFound{handheld, true}), KindOutcome::untold);
  EXPECT_EQ(judge_kind(DemoWall::textured, walking, KindFound{handheld, false}), KindOutcome::untold);
  EXPECT_EQ(judge_kind(DemoWall::textured, walking, KindFound{resting, true}), KindOutcome::wrong);
  EXPECT_EQ(judge_kind(DemoWall::textured, handheld, KindFound{walking, false}), KindOutcome::wrong);
}

TEST(KindCount, LeavesOutWhatCannotBeTold) {
  KindCount count;
  for (const KindOutcome outcome : {KindOutcome::right, KindOutcome::right, KindOutcome::untold,
                                    KindOutcome::by_default, KindOutcome::wrong})
    count.add(outcome);
  EXPECT_EQ(kind_count_words(count), "2 of 4 right, 1 by default, 1 wrong; of 1 more nothing can be told");
  EXPECT_EQ(kind_count_words({.right = 3}), "3 of 3 right");
}

class KindStudy : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_kind_study_" + std::to_string(::getpid()));
    clip_.name = "tiny";
    clip_.film.camera = DemoCamera::resting;
    clip_.film.width = 160, clip_.film.height = 96, clip_.film.frames = 12;
    clip_.film.samples_per_pixel = 1;
    clip_.film.wall = DemoWall::plain;
  }
  void TearDown() override { fs::remove_all(folder_); }

  Result<std::vector<KindRow>> study(std::stop_token stop = {}) const {
    return study_camera_kinds({clip_}, folder_, {}, Progress(), stop);
  }
  fs::file_time_type filmed() const { return fs::last_write_time(folder_ / "tiny" / "demo.mp4"); }

  fs::path folder_;
  KindClip clip_;
};

TEST_F(KindStudy, FilmsAlignsAndJudgesAndASecondCallKeepsBoth) {
  const auto first = study();
  ASSERT_TRUE(first.ok()) << first.error().what;
  ASSERT_EQ(first->size(), 1u);
  const KindRow& row = first->front();
  EXPECT_EQ(row.truth, resting);
  ASSERT_TRUE(row.found.has_value());
  EXPECT_EQ(row.found->kind, resting);
  EXPECT_EQ(row.outcome, row.found->assumed ? KindOutcome::untold : KindOutcome::right);
  ASSERT_TRUE(row.views.has_value());
  EXPECT_EQ(row.views->turn_max_deg, 0);
  EXPECT_FALSE(row.evidence.empty());
  EXPECT_FALSE(fs::exists(folder_ / "tiny" / "align"));

  const auto time = filmed();
  const auto again = study();
  ASSERT_TRUE(again.ok()) << again.error().what;
  EXPECT_EQ(filmed(), time);
  EXPECT_EQ(again->front().align.wall, row.align.wall);  // read, not measured again
  EXPECT_EQ(again->front().evidence, row.evidence);
  EXPECT_EQ(again->front().outcome, row.outcome);

  // What was found is believed only of this film, and only whole.
  std::ofstream(folder_ / "tiny" / "found.json") << "{\"inputs\": 3";
  ASSERT_TRUE(study().ok());
  EXPECT_EQ(filmed(), time);
  clip_.film.seed = 1;
  ASSERT_TRUE(study().ok());
  EXPECT_NE(filmed(), time);
}

TEST_F(KindStudy, StopsBeforeItBeginsAndMidway) {
  std::stop_source stop;
  stop.request_stop();
  const auto before = study(stop.get_token());
  ASSERT_FALSE(before.ok());
  EXPECT_EQ(before.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(fs::exists(folder_));

  std::stop_source later;
  const Progress midway([&](const ProgressReport& report) {
    if (report.fraction > 0.2) later.request_stop();
  });
  const auto stopped = study_camera_kinds({clip_}, folder_, {}, midway, later.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(fs::exists(folder_ / "tiny" / "clip.txt"));
  EXPECT_FALSE(fs::exists(folder_ / "tiny" / "demo.mp4"));
}

}  // namespace
}  // namespace likeness
