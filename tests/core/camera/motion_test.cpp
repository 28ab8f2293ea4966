// Claims about telling a camera at rest from a moving one, through real encoded video.
#include "core/camera/motion.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <random>

#include "core/camera/align.h"
#include "core/camera/assumed_lens.h"
#include "core/video/encode.h"
#include "tests/core/camera/textured_room.h"
#include "tests/core/video/film_boxes.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 320, kHeight = 240;

struct Clip {
  fs::path folder = fs::temp_directory_path() / ("likeness_motion_" + std::to_string(::getpid()));
  fs::path video = folder / "clip.mp4";
  ~Clip() { fs::remove_all(folder); }

  // picture(frame) for each frame, encoded at 20 frames a second.
  explicit Clip(int frames, const std::function<Image8(int)>& picture) {
    fs::create_directories(folder);
    auto writer = VideoWriter::create(video, kWidth, kHeight, {20, 18});
    if (!writer) throw std::runtime_error(writer.error().what);
    for (int i = 0; i < frames; ++i)
      if (auto added = writer->add(picture(i)); !added) throw std::runtime_error(added.error().what);
    if (auto done = writer->finish(); !done) throw std::runtime_error(done.error().what);
  }
};

// A large noise picture from which a window is cut: the camera pans over it.
Image8 wall_window(double shift) {
  Image8 picture(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = std::uint8_t(255 * wall_texture(1.0 * x + shift, 1.0 * y, 5));
  return picture;
}

// Something like a person: a disc of its own texture that wanders over a third of the picture.
void draw_blob(Image8& picture, int frame) {
  const double cx = 160 + 60 * std::sin(frame * 0.3), cy = 130 + 20 * std::cos(frame * 0.4);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (std::hypot(x - cx, y - cy) < 60)
        for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = std::uint8_t(200 * wall_texture(x - cx, y - cy, 9));
}

AlignResult align_or_throw(const Clip& clip) {
  auto result = align_clip(clip.video, {}, clip.folder / "work", {}, {}, {});
  if (!result) throw std::runtime_error(result.error().what);
  return *result;
}

TEST(BackgroundMotion, AStaticCameraWithAMovingPersonIsStatic) {
  const Image8 wall = wall_window(0);
  const Clip clip(60, [&](int frame) {
    Image8 picture = wall;
    draw_blob(picture, frame);
    return picture;
  });
  const auto motion = measure_background_motion(clip.video, {}, 0.75, {}, {});
  ASSERT_TRUE(motion.ok()) << motion.error().what;
  EXPECT_LT(motion->motion, 0.5);
  EXPECT_GT(motion->tracks, 50);
  ASSERT_EQ(motion->rests.size(), 1u);
  EXPECT_EQ(motion->rests[0].first, 0);
  EXPECT_EQ(motion->rests[0].last, 59);

  const AlignResult result = align_or_throw(clip);
  EXPECT_TRUE(result.cameras.rests());
  ASSERT_EQ(result.cameras.cameras.size(), 1u);
  const Camera& camera = result.cameras.cameras[0];
  EXPECT_EQ(camera.frame, -1);
  EXPECT_EQ(camera.intrinsics.fx, kPhoneFocal * kHeight);
  EXPECT_EQ(camera.intrinsics.cx, kWidth / 2.0);
  EXPECT_EQ(camera.intrinsics.cy, kHeight / 2.0);
  EXPECT_EQ(result.registered, 60);
}

TEST(Align, ARestingCameraHasTheLensThatTheFilmSpeaksOf) {
  const Clip clip(8, [&](int) { return wall_window(0); });
  const fs::path tagged = clip.folder / "tagged.mov";
  const std::string command = "ffmpeg -loglevel error -i '" + clip.video.string() +
                              "' -c copy -movflags use_metadata_tags -metadata " + test::kFocalTag + "=27 '" +
                              tagged.string() + "' > /dev/null 2>&1";
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "needs the ffmpeg program";
  for (const bool told : {true, false}) {
    AlignOptions options;
    if (told) options.kind = CameraKind::resting;
    const auto result = align_clip(tagged, {}, clip.folder / "work", options, {}, {});
    ASSERT_TRUE(result.ok()) << result.error().what;
    EXPECT_DOUBLE_EQ(result->cameras.cameras[0].intrinsics.fx, 27.0 / 36 * kWidth);
    EXPECT_NE(result->evidence.find("27 mm"), std::string::npos) << result->evidence;
  }
  EXPECT_EQ(align_or_throw(clip).evidence.find(" mm"), std::string::npos);
  AlignOptions options;  // whoever knows better is believed
  options.lens_mm = 54;
  const auto result = align_clip(tagged, {}, clip.folder / "work", options, {}, {});
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_DOUBLE_EQ(result->cameras.cameras[0].intrinsics.fx, 54.0 / 36 * kWidth);
  EXPECT_NE(result->evidence.find("54 mm"), std::string::npos) << result->evidence;
}

TEST(BackgroundMotion, APanIsMovingAndItsPathIsTheShift) {
  const Clip clip(50, [&](int frame) { return wall_window(1.2 * frame); });
  const auto motion = measure_background_motion(clip.video, {}, 0.75, {}, {});
  ASSERT_TRUE(motion.ok()) << motion.error().what;
  EXPECT_TRUE(motion->rests.empty());
  const double shift = 1.2 * 49 * 1000 / kWidth;
  EXPECT_NEAR(motion->frames.back().path, shift, 0.05 * shift);
}

TEST(BackgroundMotion, TheRestOfAMixedClipIsFoundToWithinAFewFrames) {
  const Clip clip(80, [&](int frame) {
    Image8 picture = wall_window(1.5 * std::min(frame, 40));
    draw_blob(picture, frame);
    return picture;
  });
  const auto motion = measure_background_motion(clip.video, {}, 0.75, {}, {});
  ASSERT_TRUE(motion.ok()) << motion.error().what;
  ASSERT_EQ(motion->rests.size(), 1u);
  EXPECT_GE(motion->rests[0].first, 38);
  EXPECT_LE(motion->rests[0].first, 45);
  EXPECT_EQ(motion->rests[0].last, 79);
}

TEST(BackgroundMotion, ShotsThatDoNotServeAreNotLookedAt) {
  // Two shots from one camera at rest, and between them another one's pan.
  const auto filmed = [](int frame) { return frame >= 30 && frame < 60; };
  const Clip clip(90, [&](int frame) { return wall_window(filmed(frame) ? 500 + 3.0 * frame : 0); });
  const std::vector<FrameSpan> serve{{0, 29}, {60, 89}};
  const auto motion = measure_background_motion(clip.video, {}, 0.75, {}, {}, nullptr, {}, serve);
  ASSERT_TRUE(motion.ok()) << motion.error().what;
  EXPECT_LT(motion->motion, 0.75);
  EXPECT_EQ(motion->frames.size(), 60u);
  for (const FrameMotion& f : motion->frames) EXPECT_FALSE(filmed(f.frame)) << f.frame;
}

TEST(BackgroundMotion, ATexturelessBackgroundCountsAsStaticAndSaysSo) {
  std::mt19937 random(3);
  const Clip clip(30, [&](int) {
    Image8 picture(kWidth, kHeight, 3);
    for (auto& value : picture.data) value = std::uint8_t(128 + random() % 3);
    return picture;
  });
  const AlignResult result = align_or_throw(clip);
  EXPECT_TRUE(result.cameras.rests());
  EXPECT_NE(result.evidence.find("too little texture"), std::string::npos) << result.evidence;
}

TEST(BackgroundMotion, WhatTheMaskCoversDoesNotCount) {
  // The right half pans, the left half rests; with the right half masked the camera rests.
  const Image8 rest = wall_window(0);
  const Clip clip(40, [&](int frame) {
    Image8 picture = wall_window(1.5 * frame);
    for (int y = 0; y < kHeight; ++y) std::copy_n(rest.at(0, y), 3 * 90, picture.at(0, y));
    return picture;
  });
  const auto mask = [](int, const Image8& rgb) {
    Image8 ignore(rgb.width, rgb.height, 1, 0);
    for (int y = 0; y < rgb.height; ++y)
      for (int x = 85; x < rgb.width; ++x) *ignore.at(x, y) = 255;
    return ignore;
  };
  const auto masked = measure_background_motion(clip.video, mask, 0.75, {}, {});
  const auto whole = measure_background_motion(clip.video, {}, 0.75, {}, {});
  ASSERT_TRUE(masked.ok() && whole.ok());
  EXPECT_LT(masked->motion, 0.75);
  EXPECT_GT(whole->motion, 20);
}

TEST(ChooseKeyframes, AreSpacedAlongTheTravelAndTakeTheSharpest) {
  BackgroundMotion motion;
  for (int i = 0; i < 200; ++i) {
    const double way = std::min(4.0 * i, 396.0);
    motion.frames.push_back({i, way, way, i % 5 == 0 ? 9.0 : 1.0});
  }
  const auto chosen = choose_keyframes(motion, 80);
  EXPECT_EQ(chosen.size(), 11u);  // 396 / 35
  int resting = 0;
  for (int frame : chosen) {
    EXPECT_EQ(frame % 5, 0) << frame;
    resting += frame >= 100;
  }
  EXPECT_LE(resting, 1);  // a rest adds nothing
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  EXPECT_LE(choose_keyframes(motion, 6).size(), 6u);
}

TEST(ChooseKeyframes, ALongSweepGetsWideStepsUpToTheCount) {
  BackgroundMotion motion;
  for (int i = 0; i < 600; ++i) motion.frames.push_back({i, 9.0 * i, 9.0 * i, 1.0});
  const auto chosen = choose_keyframes(motion, 80);
  ASSERT_EQ(chosen.size(), 59u);  // 5391 / 90
  for (std::size_t i = 1; i < chosen.size(); ++i) EXPECT_NEAR(chosen[i] - chosen[i - 1], 10, 1) << i;
  EXPECT_EQ(choose_keyframes(motion, 40).size(), 40u);
}

TEST(BackgroundMotion, AShakingHandTravelsNowhere) {
  const Clip clip(60, [&](int frame) { return wall_window(20 + 2.0 * std::sin(1.3 * frame)); });
  const auto motion = measure_background_motion(clip.video, {}, 0.75, {}, {});
  ASSERT_TRUE(motion.ok()) << motion.error().what;
  EXPECT_GT(motion->frames.back().path, 30);
  EXPECT_LT(motion->frames.back().travel, 20);
}

TEST(BackgroundMotion, AFastPanTravelsItsWholeWay) {
  const Clip clip(25, [&](int frame) { return wall_window(12.0 * frame); });
  const auto motion = measure_background_motion(clip.video, {}, 0.75, {}, {});
  ASSERT_TRUE(motion.ok()) << motion.error().what;
  const double shift = 12.0 * 24 * 1000 / kWidth;
  EXPECT_NEAR(motion->frames.back().travel, shift, 0.1 * shift);
}

TEST(Sway, WideShakingDiffersFromAWalkThereAndBack) {
  // 10 px of 320 to either side, three times a second: every swing counts as travel, but it leads nowhere.
  const Clip shaken(60, [&](int frame) { return wall_window(30 + 10.0 * std::sin(0.95 * frame)); });
  const auto shaking = measure_background_motion(shaken.video, {}, 0.75, {}, {});
  ASSERT_TRUE(shaking.ok()) << shaking.error().what;
  EXPECT_GT(shaking->frames.back().travel, 120);
  const Sway hand = measure_sway(*shaking);
  EXPECT_NEAR(hand.reach, 20 * 1000.0 / kWidth, 8);
  EXPECT_GT(hand.crossings, 3);
  EXPECT_TRUE(is_shaking(hand));

  // There and back within four seconds, as far as half the picture.
  const Clip walked(80, [&](int frame) { return wall_window(90 - 80.0 * std::cos(0.0785 * frame)); });
  const auto walking = measure_background_motion(walked.video, {}, 0.75, {}, {});
  ASSERT_TRUE(walking.ok()) << walking.error().what;
  const Sway walk = measure_sway(*walking);
  EXPECT_NEAR(walk.reach, 160 * 1000.0 / kWidth, 30);
  EXPECT_LT(walk.crossings, 0.6);
  EXPECT_FALSE(is_shaking(walk));
}

TEST(BackgroundMotion, StopsWhenAsked) {
  const Clip clip(20, [&](int) { return wall_window(0); });
  std::stop_source stop;
  stop.request_stop();
  const auto motion = measure_background_motion(clip.video, {}, 0.75, {}, stop.get_token());
  ASSERT_FALSE(motion.ok());
  EXPECT_EQ(motion.error().code, ErrorCode::cancelled);
}

TEST(MovingStretch, IsTheLongestBetweenRests) {
  BackgroundMotion motion;
  for (int frame = 0; frame < 100; frame += 2) motion.frames.push_back({frame});
  motion.rests = {{0, 11}, {20, 31}, {70, 98}};
  const auto stretch = moving_stretch(motion);
  ASSERT_TRUE(stretch.has_value());
  EXPECT_EQ(stretch->first, 32);
  EXPECT_EQ(stretch->last, 68);
  motion.rests = {{0, 98}};
  EXPECT_FALSE(moving_stretch(motion).has_value());
  motion.rests.clear();
  EXPECT_EQ(moving_stretch(motion)->last, 98);
}

}  // namespace
}  // namespace likeness
