// Claims about the coarse person mask.
#include "core/matte/coarse_mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

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
