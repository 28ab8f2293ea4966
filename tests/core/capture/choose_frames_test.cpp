// Claims about frame choice and sharpness.
#include "core/capture/choose_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/capture/hold_out.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;

std::vector<CaptureFrame> even_frames(int count, double sharpness = 100) {
  std::vector<CaptureFrame> frames;
  for (int i = 0; i < count; ++i) frames.push_back({i, i / 25.0, sharpness, false, false, ""});
  return frames;
}

std::vector<FaceSample> faces_everywhere(int count) {
  std::vector<FaceSample> samples;
  for (int i = 0; i < count; i += 5) samples.push_back({i, FaceBox{100, 100, 80, 80, 1}, false});
  return samples;
}

int used(const std::vector<CaptureFrame>& frames) {
  return int(std::count_if(frames.begin(), frames.end(), [](const auto& f) { return f.used; }));
}

TEST(ChooseTrainingFrames, RefusesExactlyTheBlurredOnesAndSaysWhy) {
  auto frames = even_frames(200);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].sharpness = 100 + 50 * std::sin(0.02 * double(i));
  const std::set<int> blurred = {0, 31, 90, 91, 150};
  for (const int i : blurred) frames[i].sharpness *= 0.3;
  hold_out_tail(frames, 0.1);
  choose_training_frames(frames, faces_everywhere(200), {}, {}, {});
  for (const CaptureFrame& f : frames) {
    EXPECT_EQ(f.used, !f.held_out && !blurred.contains(f.frame)) << f.frame;
    EXPECT_EQ(f.refused.empty(), f.held_out || f.used) << f.frame;
  }
  EXPECT_THAT(frames[31].refused, HasSubstr("Blurred"));
}

TEST(ChooseTrainingFrames, LeavesHeldOutFramesAloneHoweverBlurred) {
  auto frames = even_frames(100);
  hold_out_tail(frames, 0.1);
  for (auto& f : frames) {
    if (f.held_out) f.sharpness = f.frame % 2 ? 0 : 1;
  }
  choose_training_frames(frames, faces_everywhere(50), {}, {}, {.max_frames = 10});
  for (std::size_t i = 90; i < 100; ++i) {
    EXPECT_TRUE(frames[i].held_out);
    EXPECT_FALSE(frames[i].used);
    EXPECT_TRUE(frames[i].refused.empty());
  }
}

TEST(ChooseTrainingFrames, FramesKeptApartStaySoAndDecideNothing) {
  auto frames = even_frames(120), others = frames;
  for (std::size_t i = 40; i < 80; ++i) {
    for (auto* all : {&frames, &others}) (*all)[i].apart = true, (*all)[i].refused = "Seen from between.";
    others[i].sharpness = 9000;  // beside which every other frame would be blurred
  }
  std::vector<float> calm(120, 0.2f), wild = calm;
  for (std::size_t i = 40; i < 80; ++i) wild[i] = 50;
  choose_training_frames(frames, faces_everywhere(120), calm, {}, {.max_frames = 30});
  choose_training_frames(others, faces_everywhere(120), wild, {}, {.max_frames = 30});
  EXPECT_EQ(used(frames), 30);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].used, others[i].used) << i;
    if (!frames[i].apart) continue;
    EXPECT_FALSE(frames[i].used) << i;
    EXPECT_EQ(frames[i].refused, "Seen from between.");
  }
}

TEST(ChooseTrainingFrames, ThinsEvenlyToTheLimit) {
  for (const int limit : {1, 7, 50, 99, 180, 500}) {
    auto frames = even_frames(200);
    hold_out_tail(frames, 0.1);
    choose_training_frames(frames, faces_everywhere(200), {}, {}, {.max_frames = limit});
    EXPECT_EQ(used(frames), std::min(limit, 180));
    int last = -1, largest = 0, smallest = 1000;
    for (const CaptureFrame& f : frames) {
      if (!f.used) continue;
      if (last >= 0)
        largest = std::max(largest, f.frame - last), smallest = std::min(smallest, f.frame - last);
      last = f.frame;
    }
    if (limit > 1) {
      EXPECT_LE(largest - smallest, 1) << limit;
    }
  }
}

TEST(ChooseTrainingFrames, ALivelyStretchKeepsMoreOfItsFramesThanAStillOne) {
  // Two thirds of the time the face hardly moves; then it turns and speaks.
  auto frames = even_frames(3000);
  hold_out_tail(frames, 0.1);
  std::vector<float> change(3000, 0.2f);
  for (std::size_t i = 1800; i < 2700; ++i) change[i] = 3.0f;
  change[500] = 80;  // a cut is one step, not a movement
  choose_training_frames(frames, faces_everywhere(3000), change, {}, {.max_frames = 900});
  EXPECT_EQ(used(frames), 900);
  const auto kept = [&](std::size_t from, std::size_t to) {
    return std::count_if(frames.begin() + long(from), frames.begin() + long(to),
                         [](const CaptureFrame& f) { return f.used; });
  };
  EXPECT_GT(kept(1800, 2700), 500);
  EXPECT_GT(kept(0, 1800), 250);
  EXPECT_LT(kept(450, 550), 40);
  // What is held out does not ask what changes.
  for (std::size_t i = 0; i < 3000; ++i) EXPECT_EQ(frames[i].held_out, i >= 2700);
}

TEST(ChooseTrainingFrames, OfFramesThatMayStandForEachOtherTheSharpestStays) {
  auto frames = even_frames(3000);
  for (std::size_t i = 0; i < frames.size(); i += 3) frames[i].sharpness = 130;
  hold_out_tail(frames, 0.1);
  choose_training_frames(frames, faces_everywhere(3000), {}, {}, {.max_frames = 900});
  int sharp = 0;
  for (const CaptureFrame& f : frames) sharp += f.used && f.sharpness > 120;
  EXPECT_EQ(used(frames), 900);
  EXPECT_GT(sharp, 850);
}

TEST(ChooseTrainingFrames, RefusesStretchesWithoutAFaceButBridgesShortGaps) {
  auto frames = even_frames(300);
  auto samples = faces_everywhere(300);
  for (FaceSample& s : samples) {
    if (s.frame >= 50 && s.frame < 75) s.face.reset();    // one second
    if (s.frame >= 120 && s.frame < 245) s.face.reset();  // five seconds
  }
  hold_out_tail(frames, 0.1);
  choose_training_frames(frames, samples, {}, {}, {});
  for (int i = 45; i < 80; ++i) EXPECT_TRUE(frames[i].used) << i;
  for (int i = 160; i < 200; ++i) {
    EXPECT_FALSE(frames[i].used) << i;
    EXPECT_THAT(frames[i].refused, HasSubstr("No face"));
  }
}

// -- Sharpness

Image8 texture(int side, double blur_px) {
  // Blur is made by averaging: a sum of waves, each damped as a Gaussian of that width would.
  Image8 image(side, side, 3);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      double v = 128;
      for (int k = 1; k <= 6; ++k) {
        const double frequency = 2 * 3.14159265 * 3 * k / side;
        v += 25 * std::exp(-0.5 * std::pow(frequency * blur_px, 2)) *
             (std::sin(frequency * x + k) + std::cos(frequency * y));
      }
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = std::uint8_t(std::clamp(v, 0.0, 255.0));
    }
  }
  return image;
}

TEST(FaceSharpness, FallsWithBlur) {
  const FaceBox box{40, 40, 240, 240, 1};
  double last = 1e30;
  for (const double blur : {0.0, 1.0, 2.0, 4.0, 8.0}) {
    const double sharpness = face_sharpness(texture(320, blur), box);
    EXPECT_LT(sharpness, 0.95 * last) << blur;
    last = sharpness;
  }
}

TEST(FaceSharpness, HardlyDependsOnTheDistanceOfTheFace) {
  // Without the fixed size, halving the distance would change it sixteenfold; a quarter is left by the
  // resampling.
  const double near = face_sharpness(texture(640, 0), {80, 80, 480, 480, 1});
  const double far = face_sharpness(texture(320, 0), {40, 40, 240, 240, 1});
  EXPECT_NEAR(far / near, 1, 0.25);
}

TEST(FaceSharpness, IsTheSameForLumaAndGreyRgb) {
  const Image8 rgb = texture(200, 1);
  Image8 luma(200, 200, 1);
  for (std::size_t i = 0; i < luma.data.size(); ++i) luma.data[i] = rgb.data[3 * i];
  const FaceBox box{20, 20, 160, 160, 1};
  EXPECT_NEAR(face_sharpness(rgb, box), face_sharpness(luma, box), 1e-3);
}

}  // namespace
}  // namespace likeness
