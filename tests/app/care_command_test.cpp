// Claims about the care of projects from the command line: relink, delete, and the forecast of a build.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/capture/capture.h"
#include "core/video/encode.h"
#include "tests/core/export/tiny_project.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class CareCommand : public testing::Test {
 protected:
  void SetUp() override {
    clip_ = project_.root / "clip.mp4";
    auto writer = VideoWriter::create(clip_, 64, 48);
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < 30; ++i) ASSERT_TRUE(writer->add(Image8(64, 48, 3, std::uint8_t(8 * i))).ok());
    ASSERT_TRUE(writer->finish().ok());
  }
  std::string project() const { return project_.folder().string(); }

  TinyProject project_;
  fs::path clip_;
};

TEST_F(CareCommand, ADeletionIsMeantOrNothingHappens) {
  const ProgramResult asked = likeness({"delete", project()});
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.err, HasSubstr("--yes"));
  EXPECT_TRUE(fs::exists(project_.folder() / "avatar.bin"));
  const ProgramResult meant = likeness({"delete", project(), "--yes", "--json"});
  ASSERT_EQ(meant.exit_code, 0) << meant.err;
  EXPECT_TRUE(json::parse(meant.out).at("folder_gone").get<bool>());
  EXPECT_FALSE(fs::exists(project_.folder()));
  EXPECT_TRUE(fs::exists(clip_));
  EXPECT_EQ(likeness({"delete", project(), "--yes"}).exit_code, 1);
}

// An answer is kept whatever becomes of the run.
TEST_F(CareCommand, WhetherThePersonAgreedIsAnsweredByAnOption) {
  const auto kept = [&] { return open_project(project_.folder())->consent; };
  ASSERT_EQ(kept(), Consent::not_asked);
  EXPECT_EQ(likeness({"train", project(), "--consent", "perhaps"}).exit_code, 2);
  (void)likeness({"train", project(), "--consent", "given"});
  EXPECT_EQ(kept(), Consent::given);
  const fs::path another = project_.root / "another.likeness";
  (void)likeness({"import", clip_.string(), "--project", another.string(), "--consent", "self"});
  EXPECT_FALSE(fs::exists(another)) << "a first import without a face leaves nothing";
  (void)likeness({"import", clip_.string(), "--project", project(), "--consent", "self"});
  EXPECT_EQ(kept(), Consent::own);
}

TEST_F(CareCommand, ADamagedProjectIsRepairedAndDeleted) {
  const auto damage = [&] {
    ASSERT_TRUE(write_text(project_.folder() / "project.json", "{\"program\": \"Likeness\", \"x").ok());
  };
  damage();
  const ProgramResult refused = likeness({"train", project()});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("likeness repair"));
  const ProgramResult repaired = likeness({"repair", project(), "--json"});
  ASSERT_EQ(repaired.exit_code, 0) << repaired.err;
  EXPECT_TRUE(json::parse(repaired.out).at("repaired").get<bool>());
  EXPECT_TRUE(open_project(project_.folder()).ok());
  EXPECT_FALSE(json::parse(likeness({"repair", project(), "--json"}).out).at("repaired").get<bool>());
  damage();
  EXPECT_THAT(likeness({"delete", project()}).err, HasSubstr("--yes"));
  EXPECT_EQ(likeness({"delete", project(), "--yes"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(project_.folder()));
}

TEST_F(CareCommand, AMovedClipIsReportedAndFoundAgain) {
  ASSERT_EQ(likeness({"relink", project(), clip_.string()}).exit_code, 0);
  Capture capture;
  capture.video_hash = *hash_file(clip_);
  capture.width = 64, capture.height = 48, capture.crop = {0, 0, 48}, capture.frames_per_second = 25;
  capture.frames.push_back({0, 0, 100, false, true, ""});
  ASSERT_TRUE(write_capture(project_.folder() / "capture.json", capture).ok());
  const fs::path moved = project_.root / "moved.mp4";
  fs::rename(clip_, moved);
  const ProgramResult lost = likeness({"fit", project()});
  EXPECT_EQ(lost.exit_code, 1);
  EXPECT_THAT(lost.err, HasSubstr("likeness relink"));
  ASSERT_TRUE(write_text(project_.root / "other.mp4", "another").ok());
  EXPECT_EQ(likeness({"relink", project(), (project_.root / "other.mp4").string()}).exit_code, 1);
  const ProgramResult found = likeness({"relink", project(), moved.string(), "--json"});
  ASSERT_EQ(found.exit_code, 0) << found.err;
  EXPECT_EQ(json::parse(found.out).at("video"), moved.string());
  EXPECT_EQ(open_project(project_.folder())->options.shared.video, moved);
}

TEST_F(CareCommand, AForecastDoesNothingButTell) {
  const fs::path folder = project_.root / "new.likeness";
  const ProgramResult told = likeness(
      {"build", clip_.string(), "--project", folder.string(), "--budget", "100", "--forecast", "--json"});
  ASSERT_EQ(told.exit_code, 0) << told.err;
  const json forecast = json::parse(told.out);
  EXPECT_EQ(forecast.at("frames"), 30);
  EXPECT_GT(forecast.at("seconds").get<double>(), 100);
  EXPECT_GT(forecast.at("memory_bytes").get<double>(), 1e8);
  EXPECT_GT(forecast.at("disk_bytes").get<double>(), 1e6);
  EXPECT_TRUE(forecast.contains("fits"));
  EXPECT_FALSE(fs::exists(folder));
  const ProgramResult words = likeness({"build", clip_.string(), "--project", folder.string(), "--forecast"});
  EXPECT_THAT(words.out, HasSubstr("min"));
}

TEST_F(CareCommand, ARefitIsRefusedInPlainWords) {
  for (const auto& [frames, word] :
       std::vector<std::pair<const char*, const char*>>{{"3-9", "not fitted yet"},
                                                        {"5-2", "not a list"},
                                                        {"a", "--refit 12,40-60"},
                                                        {"1,", "not a list"}}) {
    const ProgramResult refused = likeness({"fit", project(), "--refit", frames});
    EXPECT_EQ(refused.exit_code, 1) << frames;
    EXPECT_THAT(refused.err, HasSubstr(word));
    EXPECT_TRUE(open_project(project_.folder())->options.fit.refits.empty());
  }
}

TEST_F(CareCommand, FramesThatMeasureAreNotLeftOut) {
  Capture capture;
  capture.width = 64, capture.height = 48, capture.crop = {0, 0, 48}, capture.frames_per_second = 25;
  for (int i = 0; i < 10; ++i) capture.frames.push_back({i, i / 25.0, 100, i == 9, i != 9, ""});
  ASSERT_TRUE(write_capture(project_.folder() / "capture.json", capture).ok());
  for (const auto& [frames, word] : std::vector<std::pair<const char*, const char*>>{{"3,9", "Frame 9"},
                                                                                     {"12", "no frame 12"},
                                                                                     {"5-2", "not a list"},
                                                                                     {"a", "not a list"},
                                                                                     {"1,", "not a list"}}) {
    const ProgramResult refused = likeness({"train", project(), "--leave-out", frames});
    EXPECT_EQ(refused.exit_code, 1) << frames;
    EXPECT_THAT(refused.err, HasSubstr(word));
    EXPECT_TRUE(open_project(project_.folder())->options.train.left_out.empty());
  }
  // This project cannot train; what shall be left out is remembered all the same.
  (void)likeness({"train", project(), "--leave-out", "2,4-6"});
  EXPECT_EQ(open_project(project_.folder())->options.train.left_out, (std::vector<int>{2, 4, 5, 6}));
  (void)likeness({"train", project(), "--leave-out", "none"});
  EXPECT_TRUE(open_project(project_.folder())->options.train.left_out.empty());
}

TEST_F(CareCommand, ATrainingThatWasFinishedEarlyIsNotTheMeasureOfTheNext) {
  const auto finished_early = [](Project& p) {
    p.options.train.budget_s = 52, p.options.train.full_budget_s = 600;
  };
  ASSERT_TRUE(change_project(project_.folder(), finished_early).ok());
  (void)likeness({"train", project(), "--seed", "7"});  // this project cannot train
  EXPECT_EQ(open_project(project_.folder())->options.train.budget_s, 600);
  EXPECT_EQ(open_project(project_.folder())->options.train.full_budget_s, 0);
  ASSERT_TRUE(change_project(project_.folder(), finished_early).ok());
  (void)likeness({"train", project(), "--budget", "90"});  // what is asked for wins
  EXPECT_EQ(open_project(project_.folder())->options.train.budget_s, 90);
  EXPECT_EQ(open_project(project_.folder())->options.train.full_budget_s, 0);
}

}  // namespace
}  // namespace likeness::test
