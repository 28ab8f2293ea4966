// Claims about colours carried over by the surface: a painted head is the same from everywhere, and what
// changes is found where it changes.
#include "core/holds/carried_colours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/core/holds/painted_head.h"

namespace likeness::test {
namespace {

struct Seen {
  HeadInPicture head;
  Image rgb;
};
Seen seen_from_yaw(double degrees) {
  static const SkinMap map = make_skin_map(painted_model(), painted_model().vertices);
  const Camera camera = camera_before_head(degrees, 128);
  Seen seen{head_in_picture(painted_model(), map, painted_model().vertices, camera.intrinsics,
                            camera.cam_from_world),
            {}};
  seen.rgb = painted_picture(painted_model().vertices, camera, Pose::Identity(), {}).rgb;
  return seen;
}

TEST(SkinMap, HasEveryPartOnItsSide) {
  const SkinMap map = make_skin_map(painted_model(), painted_model().vertices);
  std::array<int, kSkinParts> counts{};
  for (std::size_t t = 0; t < map.part.size(); ++t) {
    ++counts[std::size_t(map.part[t])];
    if (map.part[t] == SkinPart::none) continue;
    EXPECT_TRUE(map.skin[t]);
    const float x = painted_model().vertices[std::size_t(painted_model().triangles[t][0])].x();
    if (map.part[t] == SkinPart::left_cheek) {
      EXPECT_GT(x, -0.005f);
    }
    if (map.part[t] == SkinPart::right_cheek) {
      EXPECT_LT(x, 0.005f);
    }
  }
  for (int part = 1; part < kSkinParts; ++part) EXPECT_GT(counts[std::size_t(part)], 10) << part;
  EXPECT_FALSE(map.forehead_vertices.empty());
}

TEST(CarriedColours, APaintedHeadIsTheSameFromTheSide) {
  const Seen front = seen_from_yaw(0), side = seen_from_yaw(25);
  const CarriedColours carried = carry_colours(front.head, front.rgb, side.head);
  const ColourChange change = colour_change(carried, side.head, side.rgb, 8);
  EXPECT_GT(change.pixels, 500);
  EXPECT_LT(change.mean, 0.01);
  EXPECT_LT(change.drift, 0.005);
}

TEST(CarriedColours, SkinThatIsNotSeenFromTheFrontIsNotCompared) {
  const Seen front = seen_from_yaw(0), profile = seen_from_yaw(88);
  const CarriedColours carried = carry_colours(front.head, front.rgb, profile.head);
  for (std::size_t i = 0; i < carried.known.size(); ++i) {
    if (!carried.known[i]) continue;
    const Triangle& t = profile.head.map->triangles[std::size_t(profile.head.raster.triangle[i])];
    EXPECT_GT(profile.head.normals[std::size_t(t[0])].z(), 0) << i;
  }
}

TEST(ColourChange, FindsThePartWhoseColourMoved) {
  const Seen front = seen_from_yaw(0);
  Seen side = seen_from_yaw(20);
  const CarriedColours carried = carry_colours(front.head, front.rgb, side.head);
  const ColourChange before = colour_change(carried, side.head, side.rgb, 8);
  for (std::size_t i = 0; i < carried.known.size(); ++i) {
    const int t = side.head.triangle(i);
    if (t >= 0 && side.head.map->part[std::size_t(t)] == SkinPart::nose) side.rgb.data[3 * i + 2] += 0.1f;
  }
  const ColourChange after = colour_change(carried, side.head, side.rgb, 8);
  EXPECT_NEAR(after.drift, before.drift + 0.1, 0.01);
  EXPECT_GT(after.mean, before.mean);
  EXPECT_LT(after.mean, before.mean + 0.03);
  // A part seen by too few pixels says nothing.
  EXPECT_EQ(colour_change(carried, side.head, side.rgb, 1000000).drift, 0);
}

}  // namespace
}  // namespace likeness::test
