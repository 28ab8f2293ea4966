// Claims about the kept curve of a training: it comes back as it was, and what is trained again replaces what
// was.
#include "core/project/training_curve.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

TrainStatus point(std::uint64_t step) {
  return {step, 0.1 * double(step), 0.5 / double(step + 1), 20 + 0.001 * double(step), 45000};
}

TEST(TrainingCurve, ComesBackAsItWas) {
  std::string name = (fs::temp_directory_path() / "likeness_curve_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  Project project;
  project.folder = name;
  TrainingCurve curve;
  for (int i = 1; i <= 50; ++i) add_point(curve, point(std::uint64_t(3 * i)));
  add_score(curve, {4, 25.5});
  add_score(curve, {9, 27.25});
  const fs::path path = training_curve_path(project);
  ASSERT_TRUE(write_training_curve(path, curve).ok());
  const auto read = read_training_curve(path);
  ASSERT_TRUE(read.ok()) << read.error().what;
  ASSERT_EQ(read->training.size(), curve.training.size());
  for (std::size_t i = 0; i < curve.training.size(); ++i) {
    EXPECT_EQ(read->training[i].step, curve.training[i].step);
    EXPECT_NEAR(read->training[i].seconds, curve.training[i].seconds, 0.006);
    EXPECT_NEAR(read->training[i].train_psnr_db, curve.training[i].train_psnr_db, 0.0006);
  }
  ASSERT_EQ(read->held_out.size(), 2u);
  EXPECT_NEAR(read->held_out[1].psnr_db, 27.25, 1e-3);
  for (const char* bad : {"", "{}", R"({"version":9,"training":[],"held_out":[]})",
                          R"({"version":1,"training":[[5,1,2,3,4],[5,1,2,3,4]],"held_out":[]})",
                          R"({"version":1,"training":[["a"]],"held_out":[]})"}) {
    ASSERT_TRUE(write_text(path, bad).ok());
    const auto refused = read_training_curve(path);
    EXPECT_FALSE(refused.ok()) << bad;
    EXPECT_FALSE(refused.error().fix.empty());
  }
  fs::remove_all(name);
}

TEST(TrainingCurve, ATrainingThatGoesOnFromACheckpointReplacesWhatLaterWas) {
  TrainingCurve curve;
  for (const int step : {10, 20, 30, 40}) add_point(curve, point(std::uint64_t(step)));
  add_point(curve, point(25));  // killed after 40, the checkpoint was of 24
  ASSERT_EQ(curve.training.size(), 3u);
  EXPECT_EQ(curve.training[1].step, 20u);
  EXPECT_EQ(curve.training[2].step, 25u);
}

TEST(TrainingCurve, ANewTrainingStartsAnEmptyCurve) {
  TrainingCurve curve;
  for (const int step : {10, 20}) add_point(curve, point(std::uint64_t(step)));
  add_score(curve, {1.5, 22});
  add_point(curve, point(2));
  EXPECT_EQ(curve.training.size(), 1u);
  EXPECT_TRUE(curve.held_out.empty());
}

TEST(TrainingCurve, ALongOneIsThinnedAndKeepsItsEnds) {
  TrainingCurve curve;
  for (int i = 1; i <= 5000; ++i) add_point(curve, point(std::uint64_t(i)));
  EXPECT_LE(curve.training.size(), 1000u);
  EXPECT_GT(curve.training.size(), 400u);
  EXPECT_EQ(curve.training.front().step, 1u);
  EXPECT_EQ(curve.training.back().step, 5000u);
}

}  // namespace
}  // namespace likeness
