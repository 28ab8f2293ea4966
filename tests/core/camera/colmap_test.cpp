// Claims about colmap as a program that fails: every way of failing ends in a plain sentence with a remedy,
// and what a killed step had done is not done again. The real program where it matters, a stand-in where only
// its output does.
#include "core/camera/colmap.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <mutex>

#include "core/base/files.h"
#include "core/camera/align.h"
#include "core/camera/process.h"
#include "core/camera/workplace.h"
#include "core/image/files.h"
#include "tests/core/camera/textured_room.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Intrinsics small_lens() {
  Intrinsics k;
  k.width = 240, k.height = 180;
  k.fx = k.fy = 230, k.cx = 120, k.cy = 90;
  return k;
}

int count_of(std::string_view text, std::string_view word) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(word, at)) != text.npos; at += word.size()) ++count;
  return count;
}

class Colmap : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_colmap_" + std::to_string(::getpid()) + "_" +
                                           testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
    work_ = folder_ / "work";
    options_.features = 600;
    options_.overlap = 4;
  }
  void TearDown() override { fs::remove_all(folder_); }

  bool have_colmap() const { return find_program("colmap").has_value(); }
  void add(const Image8& picture) {
    ASSERT_TRUE(prepare_work_folder(work_, "test"));
    const std::string name = fmt::format("{:06}.png", count_++);
    ASSERT_TRUE(write_picture(work_, name, picture, {}, picture.width));
  }
  // A camera that walks past the room's pillar.
  void add_walk(int pictures, const Intrinsics& lens = small_lens()) {
    for (int i = 0; i < pictures; ++i)
      add(render_room(lens, look_at({-0.7 + 0.2 * i, 0.05 * (i % 2), -0.9}, {0.1, 0, 1.4})));
  }
  // A program of that name that runs the given lines. $1 is colmap's command.
  std::string stand_in(const std::string& lines) const {
    const fs::path path = folder_ / "colmap";
    std::ofstream(path) << "#!/bin/sh\n" << lines << "\n";
    fs::permissions(path, fs::perms::owner_all);
    return path;
  }
  Result<ColmapModel> solve(const Progress& progress = {}) {
    return solve_colmap(work_, options_, progress, {});
  }
  Error failure(const Progress& progress = {}) {
    const auto model = solve(progress);
    EXPECT_FALSE(model.ok());
    return model ? Error{} : model.error();
  }

  fs::path folder_, work_;
  ColmapOptions options_;
  int count_ = 0;
};

// -- Faults of the pictures, with the real program

TEST_F(Colmap, FlatPicturesHaveTooLittleTexture) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  for (int i = 0; i < 5; ++i) add(Image8(240, 180, 3, 90));
  const Error error = failure();
  EXPECT_EQ(error.code, ErrorCode::failed);
  EXPECT_THAT(error.what, HasSubstr("too little texture: only 0 of 5 pictures"));
  EXPECT_THAT(error.fix, HasSubstr("background with detail"));
}

TEST_F(Colmap, PicturesOfDifferentPlacesDoNotMatch) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  for (int i = 0; i < 5; ++i) {
    Image8 picture(240, 180, 3);
    for (int y = 0; y < 180; ++y)
      for (int x = 0; x < 240; ++x)
        for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = std::uint8_t(255 * wall_texture(x, y, 40 + 9 * i));
    add(picture);
  }
  const Error error = failure();
  EXPECT_THAT(error.what, HasSubstr("Too few pictures match: 0 verified pairs among 5 pictures"));
  EXPECT_THAT(error.fix, HasSubstr("more slowly"));
}

TEST_F(Colmap, ACameraAtRestHardlyMoved) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  options_.features = 300;
  const Image8 view = render_room(small_lens(), look_at({0, 0, -1}, {0, 0, 1.4}));
  for (int i = 0; i < 3; ++i) add(view);
  const Error error = failure();
  EXPECT_THAT(error.what, HasSubstr("hardly moved"));
  EXPECT_THAT(error.fix, HasSubstr("at least 30 degrees"));
  EXPECT_THAT(error.fix, HasSubstr("--resting-camera"));
}

TEST_F(Colmap, ACameraThatOnlyTurnsSeesNoDepth) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  options_.features = 300;
  for (int i = 0; i < 3; ++i) add(render_room(small_lens(), look_at({0, 0, -1}, {-0.3 + 0.3 * i, 0, 1.4})));
  const Error error = failure();
  EXPECT_EQ(error.code, ErrorCode::failed);
  EXPECT_THAT(error.what, HasSubstr("only turned on the spot"));
  EXPECT_THAT(error.fix, HasSubstr("at least 30 degrees"));
}

// -- Which of several solves is chosen, with the real program

TEST_F(Colmap, TwoSolvesThatAgreeOnTheLensAreEnough) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  add_walk(6);
  const fs::path calls = folder_ / "calls";
  options_.program = stand_in(fmt::format("echo \"$1\" >> '{}'; exec colmap \"$@\"", calls.string()));
  const auto model = solve();
  ASSERT_TRUE(model.ok()) << model.error().what;
  EXPECT_NEAR(model->cameras.begin()->second.fx, small_lens().fx, 0.1 * small_lens().fx);
  const auto text = read_text(calls);
  ASSERT_TRUE(text);
  EXPECT_EQ(count_of(*text, "mapper"), 2);
}

TEST_F(Colmap, DistortionIsFittedOnlyWhereThePicturesAreDistorted) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  add_walk(6);
  const auto plain = solve();
  ASSERT_TRUE(plain.ok()) << plain.error().what;
  const Intrinsics& straight = plain->cameras.begin()->second;
  EXPECT_EQ(straight.k1, 0);
  EXPECT_EQ(straight.cx, 120);

  work_ = folder_ / "bent";
  Intrinsics lens = small_lens();
  lens.k1 = -0.12;
  add_walk(6, lens);
  const auto model = solve();
  ASSERT_TRUE(model.ok()) << model.error().what;
  EXPECT_NEAR(model->cameras.begin()->second.k1, lens.k1, 0.04);
}

TEST_F(Colmap, WhereTwoSolvesDisagreeTheirPointsDecide) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  add_walk(6);
  const fs::path calls = folder_ / "calls";
  // The first solve keeps the focal length that it guesses, 288 px for a picture of 240.
  options_.program = stand_in(
      fmt::format("echo \"$1\" >> '{}'\n"
                  "case \"$*\" in\n"
                  "  mapper*/plain_lens\\ *) exec colmap \"$@\" --Mapper.ba_refine_focal_length 0;;\n"
                  "esac\n"
                  "exec colmap \"$@\"",
                  calls.string()));
  const auto model = solve();
  ASSERT_TRUE(model.ok()) << model.error().what;
  const auto first = read_colmap_model(work_ / "sparse" / "plain_lens" / "0");
  ASSERT_TRUE(first.ok());
  EXPECT_NEAR(first->cameras.begin()->second.fx, 288, 1e-6);
  EXPECT_NEAR(model->cameras.begin()->second.fx, small_lens().fx, 0.1 * small_lens().fx);
  EXPECT_LT(mean_reprojection_px(*model), mean_reprojection_px(*first));
  const auto text = read_text(calls);
  ASSERT_TRUE(text);
  EXPECT_EQ(count_of(*text, "mapper"), 3);
}

// -- The snapshots of a running solve, with the real program

TEST_F(Colmap, RunningSolveReportsThePicturesPlacedSoFar) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  EXPECT_FALSE(solve_so_far(work_));
  add_walk(7);
  std::size_t most = 0;
  bool passed_over = false;
  const auto model = solve(Progress([&](const ProgressReport& report) {
    if (report.text.find("pictures placed") == std::string::npos) return;
    if (most > 0 && !passed_over) {  // a snapshot being written is skipped
      ASSERT_TRUE(write_text(work_ / "snapshots" / "later" / "images.bin", "half of"));
      passed_over = true;
    }
    if (const auto now = solve_so_far(work_)) most = std::max(most, now->images.size());
  }));
  ASSERT_TRUE(model.ok()) << model.error().what;
  EXPECT_TRUE(passed_over);
  EXPECT_GE(most, 5u);
  EXPECT_FALSE(solve_so_far(work_)) << "it is over";
}

TEST_F(Colmap, ProgressIsReadBehindTheTimesThatLaterVersionsPutBeforeEachLine) {
  options_.program = stand_in(R"(prefix="I20260101 12:00:00.000000    26 pairing.cc:436] "
    case $1 in
      feature_extractor) echo "${prefix}Processed file [2/3]" ;;
      *) echo "${prefix}Matching image [1/3]"; echo "${prefix}something nobody foresaw"; exit 3 ;;
    esac)");
  add_walk(3);
  std::vector<std::string> said;
  failure(Progress([&](const ProgressReport& report) { said.push_back(report.text); }));
  EXPECT_THAT(said, testing::Contains(HasSubstr("Looking for features: 2 of 3")));
}

// -- A killed step, with the real program

TEST_F(Colmap, KilledStepContinuesFromItsDatabase) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  add_walk(6);
  // Dies after the third picture's features are stored, with a message.
  const std::string real = find_program("colmap")->string();
  options_.program = stand_in("( exec " + real + R"( "$@" 2>&1 ) | while read -r line; do echo "$line"
        case "$line" in *"Processed file [4/"*) pkill -KILL -P $$ colmap; kill -KILL $$;; esac
      done)");
  options_.threads = 1;
  const Error error = failure();
  EXPECT_THAT(error.what, HasSubstr("was killed by signal 9"));
  EXPECT_THAT(error.fix, HasSubstr("finished steps are kept"));
  EXPECT_FALSE(fs::exists(work_ / "features.done"));
  const auto stored = count_database(work_ / "database.db");
  ASSERT_TRUE(stored.ok()) << stored.error().what;
  ASSERT_GE(stored->described, 2);
  ASSERT_LT(stored->described, 6);

  options_.program = "colmap";
  std::mutex mutex;
  std::vector<std::string> said;
  const auto model = solve(Progress([&](const ProgressReport& report) {
    const std::lock_guard lock(mutex);
    said.push_back(report.text);
  }));
  ASSERT_TRUE(model.ok()) << model.error().what;
  EXPECT_EQ(model->images.size(), 6u);
  EXPECT_EQ(model->cameras.size(), 1u);  // a second one would leave each half its own lens
  // Progress came from every step while it ran.
  const auto said_that = [&](const char* text) {
    return std::ranges::any_of(said, [&](const std::string& s) { return s.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(said_that("Looking for features: 5 of 6"));
  EXPECT_TRUE(said_that("Matching pictures: 3 of 6"));
  EXPECT_TRUE(said_that("Placing pictures: 4 of 6 pictures placed"));
}

TEST_F(Colmap, AKilledMatcherKeepsTheFeaturesAndThePairsItHad) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  add_walk(6);
  const std::string real = find_program("colmap")->string();
  // A picture's pairs are stored before the next picture's are begun.
  options_.program = stand_in("[ $1 = sequential_matcher ] || exec " + real + " \"$@\"\n( exec " + real +
                              R"( "$@" 2>&1 ) | while read -r line; do echo "$line"
        case "$line" in *"Matching image [2/"*) pkill -KILL -P $$ colmap; kill -KILL $$;; esac
      done)");
  options_.threads = 1;
  const Error error = failure();
  EXPECT_THAT(error.what, HasSubstr("`colmap sequential_matcher` was killed by signal 9"));
  EXPECT_THAT(error.fix, HasSubstr("finished steps are kept"));
  EXPECT_TRUE(fs::exists(work_ / "features.done"));
  EXPECT_FALSE(fs::exists(work_ / "matches.done"));
  const auto killed = count_database(work_ / "database.db");
  ASSERT_TRUE(killed.ok()) << killed.error().what;
  EXPECT_EQ(killed->described, 6);
  ASSERT_GE(killed->verified_pairs, 1);

  options_.program = stand_in("[ $1 = feature_extractor ] && exit 9\nexec " + real + " \"$@\"");
  const auto model = solve();
  ASSERT_TRUE(model.ok()) << model.error().what;
  EXPECT_EQ(model->images.size(), 6u);
  const auto whole = count_database(work_ / "database.db");
  ASSERT_TRUE(whole.ok());
  EXPECT_LT(killed->verified_pairs, whole->verified_pairs);
}

TEST_F(Colmap, AKilledSolveKeepsFeaturesAndMatches) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  add_walk(6);
  const std::string real = find_program("colmap")->string();
  options_.program =
      stand_in("[ $1 != mapper ] && exec " + real + " \"$@\"\necho Registering image; kill -KILL $$");
  const Error error = failure();
  EXPECT_THAT(error.what, HasSubstr("`colmap mapper` was killed by signal 9"));
  EXPECT_THAT(error.fix, HasSubstr("finished steps are kept"));

  options_.program =
      stand_in("case $1 in feature_extractor|sequential_matcher) exit 9;; esac\nexec " + real + " \"$@\"");
  const auto model = solve();
  ASSERT_TRUE(model.ok()) << model.error().what;
  EXPECT_EQ(model->images.size(), 6u);
}

TEST_F(Colmap, UnreadableDatabaseIsRebuilt) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  add_walk(6);
  ASSERT_TRUE(write_text(work_ / "database.db", "no database at all, whatever its name may say"));
  ASSERT_TRUE(write_text(work_ / "features.done", "finished\n"));
  const auto model = solve();
  ASSERT_TRUE(model.ok()) << model.error().what;
  EXPECT_EQ(model->images.size(), 6u);
}

// -- Errors known only from the program's output, with a stand-in

TEST_F(Colmap, AnotherVersionsOptionsAreNamed) {
  add_walk(2);
  options_.program =
      stand_in("echo \"Failed to parse options - unrecognised option '--SiftExtraction.use_gpu'.\"; exit 1");
  const Error error = failure();
  EXPECT_EQ(error.code, ErrorCode::missing_dependency);
  EXPECT_THAT(error.what, HasSubstr("--SiftExtraction.use_gpu"));
  EXPECT_THAT(error.fix, HasSubstr("apt install colmap"));
}

TEST_F(Colmap, AFullDiskIsNamed) {
  add_walk(2);
  options_.program = stand_in("echo 'SQLite error: database or disk is full'; exit 1");
  const Error error = failure();
  EXPECT_EQ(error.code, ErrorCode::no_space);
  EXPECT_THAT(error.fix, HasSubstr("Free some space"));
}

TEST_F(Colmap, UnknownFailureQuotesTheProgramsLastOutput) {
  add_walk(2);
  options_.program = stand_in("echo 'something nobody foresaw'; exit 3");
  const Error error = failure();
  EXPECT_EQ(error.code, ErrorCode::io);  // not a statement about the camera
  EXPECT_THAT(error.what, HasSubstr("ended with code 3"));
  EXPECT_THAT(error.what, HasSubstr("something nobody foresaw"));
  EXPECT_FALSE(error.fix.empty());
}

TEST_F(Colmap, DroppedPicturesAreReported) {
  if (!have_colmap()) GTEST_SKIP() << "colmap is not installed";
  add_walk(4);
  // The extractor exits with 0 whatever happens to single pictures.
  ASSERT_TRUE(write_image(work_ / "images" / "000009.png", Image8(100, 60, 3, 50)));
  const Error error = failure();
  EXPECT_THAT(error.what, HasSubstr("only 4 of the 5 pictures"));
  EXPECT_THAT(error.fix, HasSubstr("delete this folder"));
}

// colmap accepts a mask of another name or size silently.
TEST_F(Colmap, MasksHaveTheNameAndSizeColmapExpects) {
  const Image8 picture(240, 180, 3, 90);
  Image8 mask(240, 180, 1, 0);
  for (int y = 0; y < 180; ++y) *mask.at(10, y) = *mask.at(11, y) = 255;
  ASSERT_TRUE(prepare_work_folder(work_, "test"));
  ASSERT_TRUE(write_picture(work_, "000000.png", picture, mask, 120));
  const auto kept = read_image(work_ / "masks" / "000000.png.png");
  const auto reduced = read_image(work_ / "images" / "000000.png");
  ASSERT_TRUE(kept.ok() && reduced.ok());
  EXPECT_EQ(kept->width, reduced->width);
  EXPECT_EQ(kept->height, reduced->height);
  EXPECT_EQ(*kept->at(5, 40), 0);  // ignored
  EXPECT_GT(*kept->at(60, 40), 0);
}

// -- Photographs are checked before colmap runs

TEST_F(Colmap, TruncatedOrOddlySizedPhotographsAreLeftOutAndMoreThanHalfAreRefusedByName) {
  const fs::path photos = folder_ / "photos";
  for (int i = 0; i < 4; ++i)
    ASSERT_TRUE(write_image(photos / fmt::format("p{}.jpg", i),
                            render_room(small_lens(), look_at({0.1 * i, 0, -1}, {0, 0, 1}))));
  auto bytes = read_file(photos / "p2.jpg");
  ASSERT_TRUE(bytes.ok());
  AlignOptions options;
  options.colmap = stand_in("exit 9");
  for (const char* name : {"p1.jpg", "p2.jpg"}) {
    ASSERT_TRUE(write_file(photos / name, std::span(*bytes).first(bytes->size() / 2)));
    const auto result = align_photos(photos, {}, work_, options, {}, {});
    ASSERT_FALSE(result.ok());
    EXPECT_THAT(result.error().what, HasSubstr("ended with code 9")) << "it went on to COLMAP";
  }
  ASSERT_TRUE(write_image(photos / "p3.jpg", Image8(180, 240, 3, 90)));
  const auto result = align_photos(photos, {}, work_, options, {}, {});
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().what, HasSubstr("180 x 240 px"));
  EXPECT_EQ(fs::path(result.error().where).filename(), "p3.jpg");
  EXPECT_FALSE(result.error().fix.empty());
}

}  // namespace
}  // namespace likeness
