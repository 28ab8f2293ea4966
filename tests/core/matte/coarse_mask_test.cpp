// Claims about the coarse person mask.
#include "core/matte/coarse_mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/head/builtin_head.h"
#include "core/synth/demo_stage.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

TEST(CoarsePersonMask, AMissingLandmarkModelIsAnError) {
  EXPECT_FALSE(coarse_person_mask("/nonexistent/predictor.dat").ok());
}

TEST(CoarsePersonMask, IsEmptyWithoutAFace) {
  const auto mask = coarse_person_mask();
  if (!mask) GTEST_SKIP() << mask.error().what;
  const Image8 result = (*mask)(0, Image8(320, 240, 3, 90));
  EXPECT_EQ(result.width, 320);
  EXPECT_EQ(result.height, 240);
  EXPECT_EQ(std::count(result.data.begin(), result.data.end(), 255), 0);
}

TEST(CoarsePersonMask, CoversAPersonToTheLowerBorderAndLeavesTheCorners) {
  const fs::path video = fs::path(LIKENESS_SHARED) / "captures" / "wojtek.mp4";
  if (!fs::exists(video)) GTEST_SKIP() << "no capture at " << video;
  const auto mask = coarse_person_mask();
  if (!mask) GTEST_SKIP() << mask.error().what;
  auto reader = VideoReader::open(video);
  ASSERT_TRUE(reader.ok());
  const auto frame = reader->next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  const Image8 result = (*mask)(0, (**frame).rgb);
  for (const auto& [x, y] :
       {std::pair{256, 100}, {256, 250}, {160, 240}, {250, 420}, {256, 505}, {60, 490}, {450, 490}})
    EXPECT_EQ(*result.at(x, y), 255) << x << "," << y;
  for (const auto& [x, y] : {std::pair{10, 10}, {500, 10}, {20, 250}, {495, 250}})
    EXPECT_EQ(*result.at(x, y), 0);
}

// Where no network sees the person the drawn figure has to be enough: what of a head that turns, of hair and
// of shoulders lies beside it would pass for the background, and its motion for the camera's.
TEST(CoarsePersonMask, TheFigureAloneCoversEverybodyWhateverTheyDo) {
  for (const int person : {0, 1, 3, 5}) {
    DemoOptions options;
    options.width = options.height = 192, options.samples_per_pixel = 1;
    options.moving_share = 0, options.person = person;
    DemoStage stage(make_builtin_head(), options);
    const auto mask = coarse_person_mask({}, Pictures::in_sequence, "none");
    ASSERT_TRUE(mask) << mask.error().what;
    double persons = 0, missed = 0;
    for (int frame = 0; frame < options.frames; frame += 24) {
      const DemoFrame film = stage.film(frame, {});
      const Image8 covered = (*mask)(frame, film.rgb);
      for (std::size_t p = 0; p < film.mask.data.size(); ++p)
        if (film.mask.data[p] >= 128) ++persons, missed += covered.data[p] == 0;
    }
    EXPECT_LT(missed, 0.002 * persons) << "person " << person;
  }
}

TEST(CoarsePersonMask, RemembersAFaceThroughAClipButNotFromPhotographToPhotograph) {
  const fs::path video = fs::path(LIKENESS_SHARED) / "captures" / "wojtek.mp4";
  if (!fs::exists(video)) GTEST_SKIP() << "no capture at " << video;
  auto reader = VideoReader::open(video);
  ASSERT_TRUE(reader.ok());
  const auto frame = reader->next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  const Image8 empty_room((**frame).rgb.width, (**frame).rgb.height, 3, 90);
  const auto covered = [&](Pictures pictures) {
    const auto mask = coarse_person_mask({}, pictures);
    EXPECT_TRUE(mask.ok());
    EXPECT_GT(*(*mask)(0, (**frame).rgb).at(256, 250), 0);
    const Image8 after = (*mask)(1, empty_room);
    return std::count(after.data.begin(), after.data.end(), 255);
  };
  EXPECT_GT(covered(Pictures::in_sequence), 10000);
  EXPECT_EQ(covered(Pictures::single), 0);
}

}  // namespace
}  // namespace likeness
