// Claims about the check of real films: bars are cut off before anything is measured, and a camera is known
// by what its background does.
#include "core/check/clip_measures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/check/measure_camera.h"
#include "tests/core/camera/textured_room.h"
#include "tests/core/capture/demo_film.h"

namespace likeness {
namespace {

using test::demo_pictures;
using test::kDemoSide;

constexpr int kAbove = 48, kBeside = 60;

// The demo person between bars on all four sides.
Image8 barred(const Image8& frame) {
  Image8 out(frame.width + 2 * kBeside, frame.height + 2 * kAbove, 3);
  for (int y = 0; y < frame.height; ++y)
    std::copy_n(frame.at(0, y), 3 * frame.width, out.at(kBeside, y + kAbove));
  return out;
}

TEST(MeasureClip, BarsAreCutOffBeforeAnythingIsMeasured) {
  const test::FilmFolder folder;
  std::vector<Image8> frames;
  for (const Image8& picture : demo_pictures()) frames.push_back(barred(picture));
  test::write_film(folder.path / "barred.mp4", frames, {.frames_per_second = 25});
  const auto clip = measure_clip(folder.path / "barred.mp4", {}, "none", {}, {});
  ASSERT_TRUE(clip) << clip.error().what;
  EXPECT_NEAR(clip->film.x, kBeside, 2);
  EXPECT_NEAR(clip->film.y, kAbove, 2);
  EXPECT_NEAR(clip->film.width, kDemoSide, 4);
  EXPECT_NEAR(clip->film.height, kDemoSide, 4);
  EXPECT_EQ(clip->info.width, clip->film.width);
  EXPECT_EQ(clip->whole_width, kDemoSide + 2 * kBeside);
  int faces = 0;
  for (const Look& look : clip->looks) {
    if (!look.face) continue;
    ++faces;
    EXPECT_LT(look.face->x + look.face->width, kDemoSide) << "in the film's pixels";
    EXPECT_LT(look.cut_share, 0.2) << "a bar is not where a head was cut off";
  }
  EXPECT_GT(faces, 2);
  const ClipFacts facts = clip_facts(*clip);
  EXPECT_NE(parts_sentence(facts.parts).find("bars round it"), std::string::npos);
  EXPECT_EQ(facts.mask.prior, MaskPrior::none);
}

TEST(MeasureClip, APersonNetworkThatCannotBeReadIsAnError) {
  const test::FilmFolder folder;
  test::write_film(folder.path / "film.mp4", {demo_pictures().begin(), demo_pictures().begin() + 3});
  EXPECT_FALSE(measure_clip(folder.path / "film.mp4", {}, folder.path / "absent.onnx", {}, {}));
}

// A wall without a person; where the camera looks, in px.
CameraMeasures camera_over_wall(double (*x)(int), double (*y)(int)) {
  constexpr int kWidth = 320, kHeight = 240, kFrames = 50;
  std::vector<Image8> frames;
  for (int f = 0; f < kFrames; ++f) {
    Image8 picture(kWidth, kHeight, 3);
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u)
        for (int c = 0; c < 3; ++c)
          picture.at(u, v)[c] = std::uint8_t(40 + 170 * wall_texture((u + x(f)) / 3, (v + y(f)) / 3, 4));
    frames.push_back(picture);
  }
  const test::FilmFolder folder;
  test::write_film(folder.path / "wall.mp4", frames, {.frames_per_second = 25});
  const auto info = probe_video(folder.path / "wall.mp4");
  EXPECT_TRUE(info);
  const auto camera = measure_camera(folder.path / "wall.mp4", {}, {}, *info, {}, {}, {});
  EXPECT_TRUE(camera) << (camera ? "" : camera.error().what);
  return camera ? *camera : CameraMeasures{};
}

TEST(MeasureCamera, ACameraAtRestAndOneInAHandAreToldApart) {
  const auto still = [](int) { return 0.0; };
  const CameraMeasures rests = camera_over_wall(still, still);
  EXPECT_TRUE(rests.rests);
  EXPECT_EQ(rests.kind, CameraKind::resting);
  EXPECT_TRUE(rests.sure);
  EXPECT_NE(rests.evidence, "");
  const CameraMeasures held = camera_over_wall([](int f) { return 12 * std::sin(f / 6.0); },
                                               [](int f) { return 8 * std::cos(f / 5.0); });
  EXPECT_FALSE(held.rests);
  EXPECT_EQ(held.kind, CameraKind::handheld);
  EXPECT_TRUE(held.sure);
  EXPECT_NE(held.evidence, "");
}

}  // namespace
}  // namespace likeness
