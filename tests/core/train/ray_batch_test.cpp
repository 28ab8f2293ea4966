// Claims about the background over which a training ray is composited.
#include "core/train/ray_batch.h"

#include <gtest/gtest.h>

#include "core/train/ray_choice.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

// A picture whose red says where a pixel is, before a plate of one colour that was seen on the left third,
// shown by a model of the room in the middle, and filled in on the right.
TEST(ChooseRays, PlateIsABackgroundOnlyWhereItWasSeen) {
  constexpr int kSize = 60, kSeenTo = 20, kRays = 3000;
  const Vec3f plate_colour = Vec3f(10, 200, 30) / 255;
  TrainingSet set;
  set.size = kSize;
  set.plate = Image8(kSize, kSize, 3);
  set.plate_known = Image8(kSize, kSize, 1);
  TrainingView view;
  view.rgb = Image8(kSize, kSize, 3, 50);
  view.has_plate = true;
  view.camera.intrinsics.width = view.camera.intrinsics.height = kSize;
  view.camera.intrinsics.fx = view.camera.intrinsics.fy = kSize;
  view.camera.intrinsics.cx = view.camera.intrinsics.cy = kSize / 2;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      for (int c = 0; c < 3; ++c) set.plate.at(x, y)[c] = std::uint8_t(std::lround(255 * plate_colour[c]));
      *set.plate_known.at(x, y) = x < kSeenTo ? 255 : x < 2 * kSeenTo ? 128 : 0;
      view.rgb.at(x, y)[0] = std::uint8_t(x);
    }
  view.alpha = TiledMask(Image8(kSize, kSize, 1, 255));
  set.views.push_back(view);

  RaySource source;
  source.set = &set;
  source.views.resize(1);
  RayBatch batch;
  choose_rays(source, MarchVolumes{}, false, 3, 0, kRays, batch);
  int over_plate = 0, seen = 0;
  for (int i = 0; i < kRays; ++i) {
    // For a pixel that is all person, the target is its colour, whatever is behind.
    const bool is_seen = std::lround(255 * batch.target[std::size_t(i)].x()) < kSeenTo;
    const bool is_over_plate = (batch.background[std::size_t(i)] - plate_colour).norm() < 1e-6f;
    EXPECT_TRUE(is_seen || !is_over_plate) << i;
    seen += is_seen, over_plate += is_over_plate;
  }
  // The others of the third have a random background.
  EXPECT_NEAR(seen, kRays / 3, kRays / 20);
  EXPECT_NEAR(over_plate, seen * 2 / 3, kRays / 20);
}

// Two views of one size, the second of a further clip that trains only on its left half.
TEST(ChooseRays, FurtherClipTrainsOnlyTheHeadAndAlwaysWithItsCode) {
  constexpr int kSize = 48, kRays = 6000;
  TrainingSet set = ball_set(2, kSize, false);
  set.views[1].further_clip = 2;
  Image8 taught(kSize, kSize, 1);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      *taught.at(x, y) = x < kSize / 2 ? 255 : 0;
      for (TrainingView& view : set.views) view.rgb.at(x, y)[0] = std::uint8_t(x);
    }
  set.views[1].teaches = TiledMask(taught);
  for (TrainingView& view : set.views) view.alpha = TiledMask(Image8(kSize, kSize, 1, 255));
  const OccupancyGrid everywhere = make_occupancy(8, true), none;
  MarchVolumes volumes;
  for (MarchVolume& volume : volumes.fields) volume = march_volume(everywhere, none);
  const FieldCube cube{Vec3f::Constant(-0.2f), 0.4f};
  std::vector<AvatarPose> poses;
  for (const TrainingView& view : set.views) poses.push_back(view.pose);
  RaySource source = make_ray_source(set, poses, shape_head(set.model, set.person), cube, &cube);
  RayBatch batch;
  choose_rays(source, volumes, true, 3, 0, kRays, batch);
  int further = 0, dropped = 0;
  for (std::size_t i = 0; i < batch.requests.size(); ++i) {
    RayRequest& ray = batch.requests[i];
    dropped += ray.view >= 2;
    if (ray.view % 2 == 0) continue;
    ++further;
    EXPECT_EQ(ray.view, 1) << "a ray without its view's code";
    EXPECT_LT(std::lround(255 * batch.target[i].x()), kSize / 2);
    MarchVolumes torso = volumes;
    torso.fields[0] = {};
    EXPECT_FALSE(meets_volume(ray, torso));
  }
  EXPECT_NEAR(further, kRays / 3, kRays / 50);
  EXPECT_NEAR(dropped, kRays / 3, kRays / 30);  // half of the others
  // Before the further clip's head is registered, it is not used.
  source.drawn = 1;
  choose_rays(source, volumes, true, 3, 1, kRays, batch);
  for (const RayRequest& ray : batch.requests) EXPECT_EQ(ray.view % 2, 0);
}

// Three views and two proxies of one size, told apart by their red.
TEST(ChooseRays, ProxiesHaveAShareThatFallsAndNeverACode) {
  constexpr int kSize = 48, kRays = 8000;
  TrainingSet set = ball_set(5, kSize, false);
  for (std::size_t v = 0; v < 5; ++v)
    for (std::uint8_t& value : set.views[v].rgb.data) value = std::uint8_t(10 * v);
  for (TrainingView& view : set.views)
    view.alpha = TiledMask(Image8(kSize, kSize, 1, 255)), view.has_plate = false;
  set.proxies.assign(set.views.begin() + 3, set.views.end());
  set.proxies[0].part = LearntPart::head, set.proxies[1].part = LearntPart::torso;
  set.views.resize(3);
  const OccupancyGrid everywhere = make_occupancy(8, true), none;
  MarchVolumes volumes;
  for (MarchVolume& volume : volumes.fields) volume = march_volume(everywhere, none);
  const FieldCube cube{Vec3f::Constant(-0.2f), 0.4f};
  std::vector<AvatarPose> poses;
  for (std::size_t v = 0; v < pictured(set); ++v) poses.push_back(picture_at(set, v).pose);
  RaySource source = make_ray_source(set, poses, shape_head(set.model, set.person), cube, &cube);
  ASSERT_EQ(source.views.size(), 5u);
  EXPECT_GT(source.views[3].face_x1, source.views[3].face_x0);
  EXPECT_EQ(source.views[4].face_x1, source.views[4].face_x0) << "a torso has no face";
  source.proxies_until = 10;
  const auto proxies_at = [&](std::uint64_t step) {
    RayBatch batch;
    choose_rays(source, volumes, true, 3, step, kRays, batch);
    int proxies = 0, with_code = 0;
    for (std::size_t i = 0; i < batch.requests.size(); ++i) {
      const int row = batch.requests[i].view;
      const bool proxy = row % 5 >= 3;
      EXPECT_EQ(std::lround(255 * batch.target[i].x()), 10 * (row % 5)) << "another picture's colour";
      proxies += proxy, with_code += proxy && row < 5;
      if (!proxy) continue;
      MarchVolumes other = volumes;  // without the proxy's own part
      other.fields[std::size_t(row % 5 - 3)] = {};
      EXPECT_FALSE(meets_volume(batch.requests[i], other)) << "a proxy shows one part alone";
    }
    EXPECT_EQ(with_code, 0);
    return proxies;
  };
  EXPECT_NEAR(proxies_at(9), kProxyShare * kRays, 2);
  EXPECT_NEAR(proxies_at(10), kLateProxyShare * kRays, 2);
  set.proxies.clear();
  poses.resize(3);
  source = make_ray_source(set, poses, shape_head(set.model, set.person), cube, &cube);
  RayBatch batch;
  choose_rays(source, volumes, true, 3, 0, kRays, batch);
  for (const RayRequest& ray : batch.requests) EXPECT_LT(ray.view, 6);
}

}  // namespace
}  // namespace likeness
