// Claims about the matte stage's look back: a true background is learnt, a wrong one is said to be, and a
// camera that was taken to rest and did not is found out by its plate.
#include "core/matte/judge_background.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "tests/core/matte/made_scene.h"

namespace likeness {
namespace {

using namespace test;

// A textured wall, moved by whole pixels.
cv::Mat wall_picture(int shift) {
  cv::Mat picture(kSize, kSize, CV_8UC3);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at<cv::Vec3b>(y, x)[c] = std::uint8_t(40 + 170 * wall_texture(x + shift, y, 4));
  return picture;
}

TEST(BackgroundMeter, CountsOnlyWhereNothingOfThePersonIs) {
  const cv::Mat wall = wall_picture(0);
  cv::Mat free(wall.size(), CV_8U, cv::Scalar(255)), other = wall.clone();
  free.rowRange(0, kSize / 2).setTo(0);
  other.rowRange(0, kSize / 2).setTo(cv::Scalar::all(0));  // the person
  other += cv::Scalar::all(10);
  matting::BackgroundMeter meter;
  meter.add(wall, other, free);
  const BackgroundFit fit = meter.fit(true);
  EXPECT_EQ(fit.frames, 1);
  EXPECT_NEAR(fit.psnr_db, 20 * std::log10(255.0 / 10), 0.1);
  cv::Scalar mean, deviation;
  cv::meanStdDev(wall, mean, deviation, free);
  const double variance =
      (deviation[0] * deviation[0] + deviation[1] * deviation[1] + deviation[2] * deviation[2]) / 3;
  EXPECT_NEAR(fit.constant_db, 10 * std::log10(255 * 255 / variance), 0.05);
  free.setTo(0);
  meter.add(wall, other, free);
  EXPECT_EQ(meter.fit(true).frames, 1);  // no background, nothing to say
}

TEST(DiffersFromPlate, OnlyByMoreThanLightNoiseAndAPixel) {
  const cv::Mat plate = wall_picture(0), free(plate.size(), CV_8U, cv::Scalar(255));
  EXPECT_EQ(matting::differs_from_plate(wall_picture(1), plate, free), false);
  EXPECT_EQ(matting::differs_from_plate(wall_picture(6), plate, free), true);
  cv::Mat dark;
  plate.convertTo(dark, CV_8UC3, 0.7);
  EXPECT_EQ(matting::differs_from_plate(dark, plate, free), false);
  cv::Mat noisy = plate.clone(), noise(plate.size(), CV_8UC3);
  cv::RNG random(5);
  random.fill(noise, cv::RNG::NORMAL, cv::Scalar::all(8), cv::Scalar::all(4));
  noisy += noise;
  EXPECT_EQ(matting::differs_from_plate(noisy, plate, free), false);
  EXPECT_EQ(matting::differs_from_plate(plate, plate, cv::Mat(plate.size(), CV_8U, cv::Scalar(0))),
            std::nullopt);
}

TEST(MatteLooksBack, AtAPlateThatShowsTheWall) {
  const Scene scene("judged_plate");
  const auto result = scene.matte();
  ASSERT_TRUE(result.ok()) << result.error().what;
  const MatteReport& report = result->report;
  EXPECT_EQ(report.prior, MaskPrior::none);
  EXPECT_EQ(report.frames, kFrames);
  ASSERT_TRUE(report.plate);
  EXPECT_FALSE(report.room);
  EXPECT_TRUE(report.plate->held_out);
  EXPECT_EQ(report.plate->frames, kFrames - kHeldFrom);
  EXPECT_GT(report.plate->psnr_db, 30);
  EXPECT_GT(report.plate_look_back.frames, kFrames / 2);
  EXPECT_TRUE(holds(report.plate_look_back));
  EXPECT_EQ(background_fault(report), "");
  const auto kept = read_matte_report(scene.folder / "matte_report.json");
  ASSERT_TRUE(kept && *kept);
  EXPECT_NEAR((*kept)->plate->psnr_db, report.plate->psnr_db, 1e-9);
}

// The wall moves behind a camera that is said to rest.
TEST(MatteLooksBack, ACameraThatDidNotRestIsFoundOut) {
  Scene scene("judged_rest", Moves::always);
  scene.cameras.kind = CameraKind::resting;
  scene.cameras.cameras = {scene.cameras.cameras.front()};
  scene.cameras.cameras.front().frame = -1;
  for (TrackedFrame& frame : scene.track.frames) {  // as seen by a camera that stays
    const double shift = 0.01 * frame.frame;
    frame.pose.world_from_head.translation().x() -= shift;
    frame.pose.world_from_torso.translation().x() -= shift;
  }
  const auto result = scene.matte();
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_FALSE(holds(result->report.plate_look_back));
  EXPECT_TRUE(std::ranges::any_of(result->warnings, [](const std::string& warning) {
    return warning.find("--camera-kind handheld") != std::string::npos;
  }));
}

TEST(MatteLooksBack, ARoomIsJudgedByWhatItShows) {
  const Scene scene("judged_room", Moves::always);
  const auto learn = [&](int off) -> LearnRoom {
    return [&scene, off](const auto&, RoomPass, const auto&, auto) -> Result<RoomBehind> {
      return RoomBehind([&scene, off](int frame) {
        Image8 room = scene.wall[std::size_t(frame)];
        for (std::uint8_t& value : room.data) value = std::uint8_t(std::min(255, value + off));
        return room;
      });
    };
  };
  const auto right = scene.matte({}, {}, {}, learn(4));
  ASSERT_TRUE(right.ok()) << right.error().what;
  ASSERT_TRUE(right->report.room);
  EXPECT_GT(right->report.room->psnr_db, 30);
  EXPECT_EQ(background_fault(right->report), "");
  const auto wrong = scene.matte({}, {}, {}, learn(120));
  ASSERT_TRUE(wrong.ok()) << wrong.error().what;
  ASSERT_TRUE(wrong->report.room);
  EXPECT_LT(wrong->report.room->psnr_db, 12);
  EXPECT_NE(background_fault(wrong->report), "");
  EXPECT_EQ(std::ranges::count(wrong->warnings, background_fault(wrong->report)), 1);
}

}  // namespace
}  // namespace likeness
