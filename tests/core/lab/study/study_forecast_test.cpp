// Claims about what a study will take.
#include "core/lab/study/study_forecast.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "core/base/files.h"
#include "core/lab/study/finished_rows.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class Forecast : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_forecast_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    options_.tables = {"models"};
  }
  void TearDown() override { fs::remove_all(folder_); }
  void finish(const std::string& name, std::uint64_t seed, const ModelStudyOptions& options) {
    for (const ModelSpec& spec : study_models())
      if (spec.name == name) {
        ASSERT_TRUE(write_finished(training_path(folder_, spec, seed), "pictures",
                                   {{"asked", asked_training(options, spec, seed)}})
                        .ok());
      }
  }

  fs::path folder_;
  ModelStudyOptions options_;
};

TEST_F(Forecast, GrowsWithWhatIsAskedAndFallsWithTheThreads) {
  const StudyForecast usual = forecast_study(folder_, options_, 2);
  EXPECT_EQ(usual.finished, 0);
  EXPECT_EQ(usual.seconds, usual.left_seconds);
  // Of ten models six are trained with every seed.
  EXPECT_EQ(usual.trainings, 6 * 3 + 4);
  EXPECT_GT(usual.seconds, 18 * options_.seconds / 2);
  EXPECT_GT(forecast_study(folder_, options_, 1).seconds, 1.5 * usual.seconds);
  EXPECT_LT(forecast_study(folder_, options_, 8).seconds, 0.5 * usual.seconds);
  ModelStudyOptions other = options_;
  other.seconds *= 4;
  EXPECT_GT(forecast_study(folder_, other, 2).seconds, 1.5 * usual.seconds);
  other = options_, other.seeds = 1;
  EXPECT_EQ(forecast_study(folder_, other, 2).trainings, 10);
  EXPECT_LT(forecast_study(folder_, other, 2).seconds, usual.seconds);
  other = options_, other.size = 256;
  EXPECT_GT(forecast_study(folder_, other, 2).seconds, usual.seconds);
  other = options_, other.tables = {"time"};
  EXPECT_GT(forecast_study(folder_, other, 2).seconds, kBaselineShare * options_.seconds / 2);
}

TEST_F(Forecast, WhatIsFinishedWithTheSameChoicesIsNotCountedAgain) {
  finish("concat-grid", 0, options_);
  finish("concat-grid", 1, options_);
  const StudyForecast some = forecast_study(folder_, options_, 2);
  EXPECT_EQ(some.finished, 2);
  EXPECT_LT(some.left_seconds, some.seconds - options_.seconds);
  ModelStudyOptions other = options_;
  other.seconds = 91;
  EXPECT_EQ(forecast_study(folder_, other, 2).finished, 0);
  other = options_, other.frames = 9;
  EXPECT_EQ(forecast_study(folder_, other, 2).finished, 0);
  other = options_, other.tables = {"models", "parts"};
  EXPECT_EQ(forecast_study(folder_, other, 2).finished, 2);
  ASSERT_TRUE(write_text(folder_ / "concat-grid-1.json", "{ broken").ok());
  EXPECT_EQ(forecast_study(folder_, options_, 2).finished, 1);
  for (const ModelSpec& spec : study_models())
    for (std::uint64_t seed = 0; seed < 3; ++seed) finish(spec.name, seed, options_);
  const StudyForecast all = forecast_study(folder_, options_, 2);
  EXPECT_EQ(all.finished, all.trainings);
  EXPECT_EQ(all.left_seconds, 0);
}

TEST_F(Forecast, AModelOfTwoTablesIsTrainedOnce) {
  std::vector<StudyTable> tables;
  options_.tables = {"models", "parts"};
  const auto both = chosen_models(options_, tables);
  EXPECT_EQ(tables.size(), 2u);
  EXPECT_LT(both.size(), tables[0].models.size() + tables[1].models.size());
  options_.models = {"no-code"};
  tables.clear();
  const auto one = chosen_models(options_, tables);
  ASSERT_EQ(one.size(), 1u);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].name, "parts");
}

TEST_F(Forecast, SomeRowsOfThePartsAreTrainedOnlyByName) {
  std::vector<StudyTable> tables;
  options_.tables = {"parts"};
  for (const ModelSpec& spec : chosen_models(options_, tables)) EXPECT_TRUE(spec.track.is_the_project_s());
  for (const char* name : {"landmarks", "refine-track", "attribute"}) {
    options_.models = {name};
    tables.clear();
    const auto one = chosen_models(options_, tables);
    ASSERT_EQ(one.size(), 1u) << name;
    EXPECT_EQ(one[0].name, name);
    EXPECT_EQ(tables.at(0).models, std::vector<std::string>{name});
  }
  options_.tables = {"models"};
  tables.clear();
  EXPECT_TRUE(chosen_models(options_, tables).empty());
}

TEST_F(Forecast, EveryRowOfATableIsOfAModelAndEveryModelOfATable) {
  std::vector<std::string> named;
  for (const StudyTable& table : study_tables()) {
    named.insert(named.end(), table.models.begin(), table.models.end());
    named.insert(named.end(), table.more.begin(), table.more.end());
  }
  for (const std::string& name : named)
    EXPECT_EQ(std::ranges::count(study_models(), name, &ModelSpec::name), 1) << name;
  for (const ModelSpec& spec : study_models())
    EXPECT_GE(std::ranges::count(named, spec.name), 1) << spec.name;
}

TEST_F(Forecast, FramesFittedToTheFieldTakeTheirTime) {
  ModelStudyOptions refit = options_;
  refit.refit = true;
  EXPECT_GT(forecast_study(folder_, refit, 2).seconds, forecast_study(folder_, options_, 2).seconds);
  finish("concat-grid", 0, options_);
  EXPECT_EQ(forecast_study(folder_, refit, 2).finished, 0);
}

}  // namespace
}  // namespace likeness
