// Claims about the matte stage with painted frames: the strokes hold, the plate learns from them only what it
// may, and without them nothing changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "tests/core/matte/made_scene.h"

namespace likeness {
namespace {

using namespace test;

// In the scenes the crop is the whole picture, so a pixel of the pictures is one of the source.
Stroke dab(StrokeMark mark, double x, double y, double radius) { return {mark, radius, {{x, y}}}; }

Image8 mask_of(const Scene& scene, int frame) {
  const auto mask = read_image(scene.folder / "masks" / frame_name(frame).filename());
  EXPECT_TRUE(mask.ok()) << frame;
  return mask.ok() ? *mask : Image8(kSize, kSize, 1);
}

// All that a matte leaves in the folder, by name.
std::map<std::string, std::string> results(const Scene& scene) {
  std::map<std::string, std::string> files;
  for (const char* name : {"plate.png", "plate.json", "plate_known.png"})
    files[name] = bytes_of(scene.folder / name);
  for (int frame = 0; frame < kFrames; ++frame) {
    const std::string name = frame_name(frame).filename().string();
    files[name] = bytes_of(scene.folder / "masks" / name);
  }
  return files;
}

Result<MatteResult> matte_with(const Scene& scene, const FrameStrokes& strokes) {
  return scene.matte({}, {}, {}, {}, strokes);
}

// A balloon of the skin's colour that touches the head from behind: what colours and plate take for hair.
constexpr int kRow = 44;  // of the picture, at the height of the cheeks
struct Balloon {
  Vec2d centre = Vec2d::Zero();  // left of the head
  double radius = 11;
};
Balloon add_balloon(Scene& scene, int frame) {
  const Image8& person = scene.alpha[std::size_t(frame)];
  Balloon balloon;
  int x_of_cheek = 0;
  while (*person.at(x_of_cheek, kRow) < 128) ++x_of_cheek;
  balloon.centre = Vec2d(x_of_cheek - 6, kRow);
  auto picture = read_image(scene.folder / frame_name(frame));
  EXPECT_TRUE(picture.ok());
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      if (*person.at(x, y) == 0 && (Vec2d(x + 0.5, y + 0.5) - balloon.centre).norm() < balloon.radius) {
        const std::uint8_t skin[] = {225, 170, 140};
        std::copy_n(skin, 3, picture->at(x, y));
      }
  EXPECT_TRUE(write_image(scene.folder / frame_name(frame), *picture).ok());
  return balloon;
}

TEST(MatteStrokes, WithoutStrokesNothingChanges) {
  const Scene plain("strokes_none");
  ASSERT_TRUE(plain.matte().ok());
  const auto before = results(plain);
  ASSERT_TRUE(matte_with(plain, {{3, {}}, {kHeldFrom, {}}}).ok());
  EXPECT_EQ(results(plain), before);
  // Nor do those of a frame that gets no matte.
  ASSERT_TRUE(matte_with(plain, {{1000, {dab(StrokeMark::person, 9, 9, 9)}}}).ok());
  EXPECT_EQ(results(plain), before);
}

TEST(MatteStrokes, BackgroundStrokesRemoveWhatWasTakenForThePerson) {
  constexpr int kFrame = 10;
  Scene scene("strokes_background");
  // In the neighbouring frames too: something in a single frame is taken for flicker.
  (void)add_balloon(scene, kFrame - 1);
  (void)add_balloon(scene, kFrame + 1);
  const Balloon balloon = add_balloon(scene, kFrame);
  ASSERT_TRUE(scene.matte().ok());
  const double wrong = scene.overlap(kFrame);
  const Image8 before = mask_of(scene, kFrame);
  ASSERT_GT(*before.at(int(balloon.centre.x()), kRow), 200) << "nothing to correct";
  // Most of it, and not to its very edge.
  const FrameStrokes strokes{
      {kFrame,
       {{StrokeMark::background,
         6,
         {balloon.centre + Vec2d(-3, 0), balloon.centre + Vec2d(-1, -3), balloon.centre + Vec2d(-1, 3)}}}}};
  ASSERT_TRUE(matte_with(scene, strokes).ok());
  EXPECT_GT(scene.overlap(kFrame), wrong + 0.02);
  const Image8 after = mask_of(scene, kFrame);
  EXPECT_EQ(*after.at(int(balloon.centre.x()) - 2, kRow), 0);
  EXPECT_EQ(*after.at(kSize / 2, kSize - 6), 255) << "the person stays";
}

TEST(MatteStrokes, PersonStrokesAddWhatWasTakenForBackgroundWithASoftRim) {
  constexpr int kFrame = 10;
  const Scene scene("strokes_person");
  ASSERT_TRUE(matte_with(scene, {{kFrame, {dab(StrokeMark::person, 12, 20, 8)}}}).ok());
  const Image8 mask = mask_of(scene, kFrame);
  EXPECT_EQ(*mask.at(12, 20), 255);
  EXPECT_EQ(*mask.at(12, 26), 255);
  EXPECT_EQ(*mask.at(12, 36), 0);
  int between = 0;
  for (int x = 0; x < 12; ++x) between += *mask.at(x, 20) > 5 && *mask.at(x, 20) < 250;
  EXPECT_GE(between, 1);
  EXPECT_EQ(*mask_of(scene, kFrame + 3).at(12, 20), 0) << "other frames keep theirs";
}

TEST(MatteStrokes, PaintedHoleStaysOpen) {
  constexpr int kFrame = 7;
  const Scene scene("strokes_hole");
  ASSERT_TRUE(matte_with(scene, {{kFrame, {dab(StrokeMark::background, kSize / 2, kSize - 10, 6)}}}).ok());
  const Image8 mask = mask_of(scene, kFrame);
  EXPECT_EQ(*mask.at(kSize / 2, kSize - 10), 0);
  EXPECT_EQ(*mask.at(kSize / 2 - 16, kSize - 10), 255);
}

// Where the plate was seen, at one pixel.
int known_at(const Scene& scene, int x, int y) {
  const auto known = read_image(scene.folder / "plate_known.png");
  EXPECT_TRUE(known.ok());
  return known.ok() ? *known->at(x, y) : -1;
}

FrameStrokes in_training_frames(const Stroke& stroke) {
  FrameStrokes strokes;
  for (int frame = 0; frame < kHeldFrom; ++frame) strokes[frame] = {stroke};
  return strokes;
}

TEST(MatteStrokes, PersonStrokesNeverReachThePlate) {
  const Scene scene("strokes_plate");
  ASSERT_TRUE(scene.matte().ok());
  ASSERT_EQ(known_at(scene, 12, 20), 255);
  ASSERT_TRUE(matte_with(scene, in_training_frames(dab(StrokeMark::person, 12, 20, 8))).ok());
  for (const int x : {6, 12, 18}) EXPECT_EQ(known_at(scene, x, 20), 0) << x;
  EXPECT_EQ(known_at(scene, 12, 60), 255);
}

TEST(MatteStrokes, BackgroundStrokesMayReachThePlate) {
  const Scene scene("strokes_free");
  const int x = kSize / 2, y = kSize - 10;
  ASSERT_TRUE(scene.matte().ok());
  ASSERT_EQ(known_at(scene, x, y), 0) << "the person is always there";
  ASSERT_TRUE(matte_with(scene, in_training_frames(dab(StrokeMark::background, x, y, 7))).ok());
  EXPECT_EQ(known_at(scene, x, y), 255);
  const auto plate = read_image(scene.folder / "plate.png");
  ASSERT_TRUE(plate.ok());
  EXPECT_GT(plate->at(x, y)[0], 100) << "the cloth's red, since that is what was said to be background";
}

TEST(MatteStrokes, HeldOutFramesStrokesReachOnlyTheirOwnMasks) {
  const Scene scene("strokes_leak");
  ASSERT_TRUE(scene.matte().ok());
  const auto before = results(scene);
  FrameStrokes strokes;
  for (int frame = kHeldFrom; frame < kFrames; ++frame)
    strokes[frame] = {dab(StrokeMark::person, 12, 20, 9),
                      dab(StrokeMark::background, kSize / 2, kSize - 10, 8)};
  ASSERT_TRUE(matte_with(scene, strokes).ok());
  for (const auto& [name, bytes] : results(scene)) {
    const bool held_out = name >= frame_name(kHeldFrom).filename().string() && name.front() == '0';
    EXPECT_EQ(bytes == before.at(name), !held_out) << name;
  }
}

TEST(MatteStrokes, HoldForAMovingCameraToo) {
  constexpr int kFrame = 12;
  const Scene scene("strokes_moving", Moves::always);
  ASSERT_TRUE(matte_with(scene, {{kFrame,
                                  {dab(StrokeMark::person, 12, 20, 8),
                                   dab(StrokeMark::background, kSize / 2, kSize - 10, 6)}}})
                  .ok());
  const Image8 mask = mask_of(scene, kFrame);
  EXPECT_EQ(*mask.at(12, 20), 255);
  EXPECT_EQ(*mask.at(kSize / 2, kSize - 10), 0);
}

}  // namespace
}  // namespace likeness
