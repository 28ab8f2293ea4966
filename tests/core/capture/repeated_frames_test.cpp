// Claims about repeated pictures, in encoded films of the demo person.
#include "core/capture/repeated_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

#include "core/capture/capture.h"
#include "core/face/landmarks.h"
#include "core/video/decode.h"
#include "tests/core/capture/demo_film.h"

namespace likeness {
namespace {

using test::demo_pictures;

// Noise as a sensor's, another in every frame.
Image8 noisy(Image8 picture, int number) {
  std::mt19937 random{unsigned(number)};
  std::normal_distribution<float> noise(0, 3);
  for (std::uint8_t& level : picture.data)
    level = std::uint8_t(std::clamp(int(float(level) + noise(random)), 0, 255));
  return picture;
}

// The clip in which frame i shows picture shown(i).
std::vector<char> repeats_of(int frames, bool noise, const std::function<int(int)>& shown) {
  const test::FilmFolder folder;
  std::vector<Image8> pictures;
  for (int i = 0; i < frames; ++i) {
    const Image8& person = demo_pictures()[std::size_t(shown(i))];
    pictures.push_back(noise ? noisy(person, shown(i)) : person);
  }
  test::write_film(folder.path / "film.mp4", pictures);
  auto reader = VideoReader::open(folder.path / "film.mp4", VideoPixels::luma);
  EXPECT_TRUE(reader);
  DifferenceMeter meter;
  std::vector<float> differences;
  while (reader) {
    const auto frame = reader->next();
    EXPECT_TRUE(frame);
    if (!frame || !*frame) break;
    differences.push_back(meter.add((*frame)->rgb));
  }
  EXPECT_EQ(differences.size(), std::size_t(frames));
  return repeated_frames(differences);
}

TEST(RepeatedFrames, TheFifthOfAFilmSpreadOverMoreFrames) {
  // 24 frames a second in 30: every fifth picture is shown twice.
  for (const bool noise : {false, true}) {
    const auto shown = [](int i) { return i * 4 / 5; };
    const std::vector<char> repeats = repeats_of(60, noise, shown);
    int wrong = 0;
    for (int i = 1; i < 60; ++i) wrong += bool(repeats[std::size_t(i)]) != (shown(i) == shown(i - 1));
    EXPECT_LE(wrong, 2) << noise;
  }
}

TEST(RepeatedFrames, AScreenThatIsRecordedFourTimesAsOften) {
  const auto shown = [](int i) { return i / 4; };
  const std::vector<char> repeats = repeats_of(80, true, shown);
  int wrong = 0;
  for (int i = 1; i < 80; ++i) wrong += bool(repeats[std::size_t(i)]) != (shown(i) == shown(i - 1));
  EXPECT_LE(wrong, 3);
}

TEST(RepeatedFrames, APauseIsNoRepeat) {
  const auto none = [](const std::vector<char>& repeats) { return std::ranges::count(repeats, 1) == 0; };
  EXPECT_TRUE(none(repeats_of(test::kDemoFrames, false, [](int i) { return i; })));
  EXPECT_TRUE(none(repeats_of(test::kDemoFrames, true, [](int i) { return i; })));
  // A computed person, without any noise, who stops for a second.
  EXPECT_TRUE(none(repeats_of(60, false, [](int i) { return i < 20 ? i : i < 45 ? 20 : i - 25; })));
}

TEST(RepeatedFrames, DoNotTrainTwice) {
  if (const auto detector = FaceDetector::load(); !detector) GTEST_SKIP() << detector.error().what;
  const test::FilmFolder folder;
  std::vector<Image8> pictures;
  for (int i = 0; i < 60; ++i) pictures.push_back(demo_pictures()[std::size_t(i * 4 / 5)]);
  test::write_film(folder.path / "film.mp4", pictures);
  const auto capture =
      import_clip(folder.path / "film.mp4", folder.path / "project", {.size = 64}, Progress(), {});
  ASSERT_TRUE(capture) << capture.error().what;
  const auto repeated = std::ranges::count_if(
      capture->frames, [](const CaptureFrame& f) { return f.refused == "Repeats the frame before it."; });
  EXPECT_NEAR(double(repeated), 11, 3);    // of those that are not held out
  EXPECT_EQ(capture->frames.size(), 60u);  // the track follows all
}

}  // namespace
}  // namespace likeness
