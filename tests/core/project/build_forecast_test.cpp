// Claims about the forecast of a build: it grows with what costs, says no where it must, and offers what
// fits.
#include "core/project/build_forecast.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"
#include "core/head/builtin_head.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

const HeadModel& head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

VideoInfo minute() {
  return {.width = 1080, .height = 1920, .frames_per_second = 30, .frame_count = 1800, .duration_s = 60};
}

BuildForecast forecast(const VideoInfo& clip, int size, double budget_s = 300, int threads = 2) {
  ProjectOptions options;
  options.import.size = size, options.train.budget_s = budget_s;
  return forecast_build(clip, options, head(), threads);
}

TEST(BuildForecast, GrowsWithWhatCosts) {
  const BuildForecast base = forecast(minute(), 256);
  EXPECT_EQ(base.frames, 1800);
  const BuildForecast larger = forecast(minute(), 512);
  EXPECT_GT(larger.disk, 3 * base.disk);
  EXPECT_GT(larger.memory, base.memory);
  EXPECT_GT(larger.total_seconds(), base.total_seconds());
  EXPECT_NEAR(forecast(minute(), 256, 600).total_seconds() - base.total_seconds(), 300, 1e-6);
  VideoInfo half = minute();
  half.frame_count = 900;
  EXPECT_LT(forecast(half, 256).disk, base.disk);
  EXPECT_LT(forecast(half, 256).memory, base.memory);
  // More threads shorten everything but the training, which takes its budget.
  const BuildForecast quick = forecast(minute(), 256, 300, 8);
  EXPECT_LT(quick.seconds[std::size_t(Stage::fit)], base.seconds[std::size_t(Stage::fit)]);
  EXPECT_EQ(quick.seconds[std::size_t(Stage::train)], base.seconds[std::size_t(Stage::train)]);
}

TEST(BuildForecast, AClipThatDoesNotSayItsFramesIsCountedByItsTime) {
  VideoInfo unknown = minute();
  unknown.frame_count = 0;
  EXPECT_EQ(forecast(unknown, 256).frames, 1800);
}

TEST(BuildForecast, OfSomeSecondsTheirFramesCount) {
  ProjectOptions options;
  options.import.seconds = {20, 35};
  EXPECT_EQ(forecast_build(minute(), options, head(), 2).frames, 450);
  options.import.seconds = {50, 0};
  EXPECT_EQ(forecast_build(minute(), options, head(), 2).frames, 300);
}

TEST(BuildForecast, FramesBeyondThoseThatTrainCostNoPictures) {
  VideoInfo long_clip = minute();
  long_clip.frame_count = 20000;
  VideoInfo longer = long_clip;
  longer.frame_count = 21000;
  const auto grown = forecast(longer, 1024).disk - forecast(long_clip, 1024).disk;
  EXPECT_LT(grown, 1000ull * 1024 * 1024 / 2);
}

TEST(BuildForecast, SaysNoWithFiguresAndOffersASmallerSize) {
  ProjectOptions options;
  options.import.size = 1024;
  const BuildForecast large = forecast_build(minute(), options, head(), 2);
  const BuildForecast small = forecast(minute(), 256);
  const Resources plenty{1ull << 45, 1ull << 45};
  EXPECT_TRUE(check_forecast(large, plenty).ok());
  EXPECT_EQ(smaller_size(minute(), options, head(), 2, plenty), std::nullopt);
  const Resources little_disk{small.disk + 1'000'000, 1ull << 45};
  const auto refused = check_forecast(large, little_disk);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::no_space);
  EXPECT_NE(refused.error().what.find("GB"), std::string::npos);
  EXPECT_FALSE(refused.error().fix.empty());
  EXPECT_EQ(smaller_size(minute(), options, head(), 2, little_disk), 256);
  EXPECT_FALSE(check_forecast(large, {1ull << 45, small.memory}).ok());
  EXPECT_EQ(smaller_size(minute(), options, head(), 2, {1000, 1000}), std::nullopt) << "nothing fits";
  // What the project holds already needs no room of its own; an unknown amount is no reason to refuse.
  EXPECT_TRUE(check_forecast(large, little_disk, large.disk).ok());
  EXPECT_TRUE(check_forecast(large, {}).ok());
}

TEST(FreeResources, AreThoseOfTheNearestFolderThatIsThere) {
  const Resources free = free_resources(fs::temp_directory_path() / "absent" / "me.likeness");
  ASSERT_TRUE(free.disk.has_value());
  EXPECT_GT(*free.disk, 0u);
}

TEST(FolderBytes, CountsFilesOnceAndFollowsNoLinks) {
  std::string name = (fs::temp_directory_path() / "likeness_bytes_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path folder = name;
  ASSERT_TRUE(write_text(folder / "a", "12345").ok());
  ASSERT_TRUE(write_text(folder / "b" / "c", "123").ok());
  fs::create_symlink(folder / "a", folder / "link");
  EXPECT_EQ(folder_bytes(folder), 8u);
  EXPECT_EQ(folder_bytes(folder / "absent"), 0u);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace likeness
