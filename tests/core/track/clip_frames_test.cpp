// Claims about who is followed through a clip, on pictures composed of two rendered people.
#include "core/track/clip_frames.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <functional>

#include "core/head/builtin_head.h"
#include "core/synth/demo_stage.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 704, kHeight = 352, kFrames = 48;

// A person's picture, rendered once.
const Image8& person_picture(int seed) {
  static const auto render = [](int who) {
    DemoOptions options;
    options.width = options.height = 288;
    options.samples_per_pixel = 2;
    options.moving_share = 0;
    options.seed = who;
    DemoStage stage(make_builtin_head(), options);
    return stage.film(24, {}).rgb;
  };
  static const Image8 first = render(0), second = render(3);
  return seed == 0 ? first : second;
}

void paste(Image8& canvas, const Image8& picture, int x, int y, int side) {
  const Image8 part = resize(picture, side, side);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column)
      std::copy_n(part.at(column, row), 3, canvas.at(x + column, y + row));
}

// By dlib, whose detector leaves the most to do: the network sees covered faces, too.
class Following : public ::testing::Test {
 protected:
  void SetUp() override {
    if (auto detector = FaceDetector::load(kDlibLandmarks); !detector) GTEST_SKIP() << detector.error().what;
    std::string name = (fs::temp_directory_path() / "likeness_faces_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  Result<ClipFrames> follow(const std::function<void(Image8&, int)>& draw,
                            const std::set<int>& held_out = {}) {
    const fs::path path = folder_ / "clip.mp4";
    EncodeOptions lossless;  // else a picture carries traces of those around it
    lossless.crf = 0;
    auto writer = VideoWriter::create(path, kWidth, kHeight, lossless);
    for (int f = 0; f < kFrames; ++f) {
      Image8 canvas(kWidth, kHeight, 3, 120);
      draw(canvas, f);
      EXPECT_TRUE(writer->add(canvas).ok());
    }
    EXPECT_TRUE(writer->finish().ok());
    return read_clip_frames(path, {0, 0, kWidth, kHeight}, held_out, {.predictor = kDlibLandmarks},
                            Progress(), {});
  }
  static double centre_x(const ClipFrame& frame) { return frame.box.x + 0.5 * frame.box.width; }

  fs::path folder_;
};

TEST_F(Following, TheLargerOfTwoIsFollowedWhenTheySwapPlaces) {
  const auto clip = follow([](Image8& canvas, int f) {
    const bool swapped = f >= 24;
    paste(canvas, person_picture(0), swapped ? 380 : 20, 30, 288);
    paste(canvas, person_picture(1), swapped ? 40 : 420, 60, 216);
  });
  ASSERT_TRUE(clip.ok()) << clip.error().what;
  for (int f = 0; f < kFrames; ++f) {
    if (std::abs(f - 24) < 4) continue;  // the box is a median over a few frames
    EXPECT_EQ(centre_x(clip->frames[f]) > 352, f >= 24) << f;
  }
}

TEST_F(Following, WhoEntersLaterIsNotFollowed) {
  const auto clip = follow([](Image8& canvas, int f) {
    paste(canvas, person_picture(0), 30, 60, 240);
    if (f >= 20) paste(canvas, person_picture(1), 360, 10, 330);
  });
  ASSERT_TRUE(clip.ok()) << clip.error().what;
  for (const ClipFrame& frame : clip->frames) EXPECT_LT(centre_x(frame), 352) << frame.frame;
}

TEST_F(Following, HeldOutPicturesChangeNoTrainingFrame) {
  std::set<int> held_out;
  for (int f = 22; f < 28; ++f) held_out.insert(f);
  const auto clip_with = [&](bool somebody_else) {
    return follow(
        [&](Image8& canvas, int f) {
          paste(canvas, person_picture(0), 200 + f, 30, 288);
          if (somebody_else && held_out.contains(f)) paste(canvas, person_picture(1), 10, 10, 330);
        },
        held_out);
  };
  const auto a = clip_with(false), b = clip_with(true);
  ASSERT_TRUE(a.ok() && b.ok());
  for (int f = 0; f < kFrames; ++f) {
    if (held_out.contains(f)) continue;
    ASSERT_TRUE(a->frames[f].landmarks && b->frames[f].landmarks) << f;
    EXPECT_EQ(a->frames[f].grey.data, b->frames[f].grey.data) << f;
    EXPECT_EQ(a->frames[f].box.x, b->frames[f].box.x) << f;
    EXPECT_EQ(a->frames[f].box.width, b->frames[f].box.width) << f;
    EXPECT_EQ(a->frames[f].landmarks->points, b->frames[f].landmarks->points) << f;
  }
}

TEST_F(Following, ABarOverTheEyesDoesNotMoveTheBox) {
  const auto clip = follow([](Image8& canvas, int f) {
    paste(canvas, person_picture(0), 200, 30, 288);
    if (f >= 20 && f < 26)
      for (int y = 120; y < 190; ++y)
        for (int x = 200; x < 488; ++x) std::fill_n(canvas.at(x, y), 3, 20);
  });
  ASSERT_TRUE(clip.ok()) << clip.error().what;
  for (int f = 20; f < 26; ++f) {
    ASSERT_TRUE(clip->frames[f].landmarks) << f;
    EXPECT_NEAR(centre_x(clip->frames[f]), centre_x(clip->frames[10]), 0.15 * clip->frames[10].box.width)
        << f;
  }
}

// A hand over mouth and chin, in a picture whose person_picture(0) lies at (200, 30), 288 px.
void cover_mouth(Image8& canvas) {
  for (int y = 180; y < 270; ++y)
    for (int x = 260; x < 430; ++x) std::fill_n(canvas.at(x, y), 3, 90);
}

TEST_F(Following, AFaceInItsPlaceNeedsLessEvidenceThanAnother) {
  const auto detector = FaceDetector::load(kDlibLandmarks);
  ASSERT_TRUE(detector.ok());
  Image8 canvas(kWidth, kHeight, 3, 120);
  paste(canvas, person_picture(0), 200, 30, 288);
  const auto whole = detector->detect(canvas);
  ASSERT_EQ(whole.size(), 1U);
  cover_mouth(canvas);
  EXPECT_TRUE(detector->detect(canvas).empty());
  const auto again = detector->detect(canvas, &whole[0]);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_LT(again[0].score, 0);
  EXPECT_GT(overlap(again[0], whole[0]), 0.7);
  FaceBox elsewhere = whole[0];
  elsewhere.x += 0.6 * elsewhere.width;
  EXPECT_TRUE(detector->detect(canvas, &elsewhere).empty());
}

TEST_F(Following, AHandOverTheMouthLosesNoFaceButHidesAnUnknownOne) {
  const auto covered_from = [&](int first) {
    return follow([first](Image8& canvas, int f) {
      paste(canvas, person_picture(0), 200, 30, 288);
      if (f >= first) cover_mouth(canvas);
    });
  };
  const auto known = covered_from(8), unknown = covered_from(0);
  ASSERT_TRUE(known.ok() && unknown.ok());
  for (const ClipFrame& frame : known->frames) {
    EXPECT_TRUE(frame.detected) << frame.frame;
    EXPECT_NEAR(centre_x(frame), centre_x(known->frames[0]), 0.1 * frame.box.width) << frame.frame;
  }
  for (const ClipFrame& frame : unknown->frames) EXPECT_FALSE(frame.detected) << frame.frame;
}

}  // namespace
}  // namespace likeness
