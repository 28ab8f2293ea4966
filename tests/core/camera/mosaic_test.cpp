// Claims about the mosaic of a wall, built from frames with known cameras, and about looking back at frames.
#include "core/camera/mosaic.h"

#include <gtest/gtest.h>

#include "core/image/metrics.h"
#include "tests/core/camera/swaying_wall.h"

namespace likeness {
namespace {

// Three channels, told apart.
Image8 tinted(const Image8& grey) {
  Image8 rgb(grey.width, grey.height, 3);
  for (std::size_t i = 0; i < grey.data.size(); ++i) {
    rgb.data[3 * i] = grey.data[i];
    rgb.data[3 * i + 1] = std::uint8_t(grey.data[i] / 2);
    rgb.data[3 * i + 2] = std::uint8_t(255 - grey.data[i]);
  }
  return rgb;
}

class MosaicOfASway : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    SwayOptions options;
    options.exposure = 0;
    clip_ = new SwayingClip(swaying_clip(
        sway_lens(), 40, [](int frame) { return hand_sway(frame / 6.0, 8, 0.03); }, options));
    colours_ = new std::vector<Image8>;
    for (const Image8& grey : clip_->greys) colours_->push_back(tinted(grey));
    auto solve = solve_handheld(clip_->frames(), clip_->lens, {}, {}, {});
    ASSERT_TRUE(solve.ok());
    solve_ = new HandheldSolve(std::move(*solve));
    auto mosaic = build_mosaic(all(), mosaic_intrinsics(*solve_, 240, 136), {}, {});
    ASSERT_TRUE(mosaic.ok());
    mosaic_ = new Mosaic(std::move(*mosaic));
  }
  static void TearDownTestSuite() {
    delete clip_;
    delete colours_;
    delete solve_;
    delete mosaic_;
  }
  static MosaicFrame frame(std::size_t i) {
    const HandheldCamera& camera = solve_->cameras[i];
    return {&(*colours_)[i], &clip_->persons[i], handheld_camera(*solve_, int(i), 240, 136), camera.gain,
            camera.bias};
  }
  static std::vector<MosaicFrame> all() {
    std::vector<MosaicFrame> frames;
    for (std::size_t i = 0; i < clip_->greys.size(); ++i) frames.push_back(frame(i));
    return frames;
  }
  static SwayingClip* clip_;
  static std::vector<Image8>* colours_;
  static HandheldSolve* solve_;
  static Mosaic* mosaic_;
};
SwayingClip* MosaicOfASway::clip_ = nullptr;
std::vector<Image8>* MosaicOfASway::colours_ = nullptr;
HandheldSolve* MosaicOfASway::solve_ = nullptr;
Mosaic* MosaicOfASway::mosaic_ = nullptr;

TEST_F(MosaicOfASway, ShowsTheWallToThirtyDecibels) {
  // Against the wall without noise and person, as a true camera sees it.
  std::mt19937 random(1);
  for (const std::size_t i : {5u, 20u, 33u}) {
    const Image8 truth = tinted(wall_picture(clip_->lens, clip_->truth[i], textured_wall, 1, 0, random));
    Image8 known;
    const Image8 shown = warp_mosaic(*mosaic_, frame(i).camera, &known);
    EXPECT_GT(psnr_from_mse(mse(to_float(shown), to_float(truth), known)), 30) << "frame " << i;
    EXPECT_GT(std::count(known.data.begin(), known.data.end(), 255), 0.8 * double(known.pixels()));
  }
}

TEST_F(MosaicOfASway, IsWiderThanTheFramesAndKnowsWhatNoFrameSaw) {
  EXPECT_GT(mosaic_->intrinsics.width, 240 + 20);
  EXPECT_EQ(mosaic_->colour.width, mosaic_->intrinsics.width);
  EXPECT_EQ(*mosaic_->known.at(0, mosaic_->known.height - 1), 0);
  const Intrinsics small = mosaic_intrinsics(*solve_, 240, 136, 10000);
  EXPECT_LE(small.width * small.height, 10600);
  EXPECT_NEAR(small.fx / small.width, mosaic_->intrinsics.fx / mosaic_->intrinsics.width, 0.02);
}

TEST_F(MosaicOfASway, LookingBackTellsTheRightCameraFromAWrongOne) {
  const auto frames = all();
  const LookBack right = look_back_together(*mosaic_, frames);
  EXPECT_GT(right.psnr, 30);
  EXPECT_GT(right.covered, 0.95);
  EXPECT_LT(right.off, 0.01);
  EXPECT_EQ(look_back(*mosaic_, frames).size(), frames.size());
  auto wrong = frames;
  for (MosaicFrame& frame : wrong) frame.camera.cam_from_world = Pose::Identity();
  EXPECT_LT(look_back_together(*mosaic_, wrong).psnr, right.psnr - 8);
  EXPECT_GT(look_back_together(*mosaic_, wrong).off, 0.1);
}

TEST_F(MosaicOfASway, FramesToBuildItFromCoverTheWall) {
  HandheldSolve solve = *solve_;
  for (HandheldCamera& camera : solve.cameras) camera.held_out = camera.frame >= 30;
  const auto chosen = mosaic_frames(solve, 8);
  EXPECT_GE(chosen.size(), 8u);
  EXPECT_LE(chosen.size(), 16u);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  EXPECT_LT(chosen.back(), 30);
}

TEST_F(MosaicOfASway, StopsOnRequestAndRefusesPicturesOfAnotherSize) {
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = build_mosaic(all(), mosaic_->intrinsics, {}, stop.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  MosaicFrame odd = frame(0);
  odd.camera.intrinsics.width = 100;
  EXPECT_FALSE(build_mosaic(std::vector{odd}, mosaic_->intrinsics, {}, {}).ok());
}

TEST(WarpMosaic, AveragesWhereTheMosaicIsFiner) {
  // Stripes of one pixel, seen by a camera with a quarter of the resolution, are grey.
  Mosaic mosaic;
  mosaic.intrinsics = sway_lens(400, 300);
  mosaic.colour = Image8(400, 300, 3);
  mosaic.known = Image8(400, 300, 1, 255);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 400; ++x)
      for (int c = 0; c < 3; ++c) mosaic.colour.at(x, y)[c] = x % 2 ? 200 : 100;
  Image8 known;
  const Image8 shown = warp_mosaic(mosaic, {0, sway_lens(100, 75)}, &known);
  for (int y = 2; y < 73; ++y)
    for (int x = 2; x < 98; ++x) {
      EXPECT_NEAR(shown.at(x, y)[0], 150, 2);
      EXPECT_EQ(*known.at(x, y), 255);
    }
}

}  // namespace
}  // namespace likeness
