// Claims about the room behind a moving camera: learnt from the pictures outside the mattes, it can be seen
// from new places, and the person leaves no trace in it.
#include "core/train/room.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rigid.h"
#include "core/image/metrics.h"
#include "core/render/room_picture.h"
#include "tests/core/camera/textured_room.h"

namespace likeness {
namespace {

constexpr int kRoomSize = 64;

Intrinsics lens() {
  Intrinsics k;
  k.width = k.height = kRoomSize;
  k.fx = k.fy = 60, k.cx = k.cy = kRoomSize / 2.0;
  return k;
}

// Round a head at the room's middle; t = 0..1 along the way.
Camera camera_at(double t) {
  const double angle = -0.4 + 0.8 * t;
  return {0, lens(), look_at({1.2 * std::sin(angle), 0, -1.2 * std::cos(angle)}, {0, 0, 0.4})};
}

// A red person in the middle of the picture, masked.
TrainingView view_at(double t) {
  TrainingView view;
  view.camera = camera_at(t);
  view.rgb = render_room(lens(), view.camera.cam_from_world);
  view.has_plate = false;
  Image8 alpha(kRoomSize, kRoomSize, 1, 0);
  for (int y = 20; y < kRoomSize; ++y)
    for (int x = 22; x < 42; ++x) {
      *alpha.at(x, y) = 255;
      view.rgb.at(x, y)[0] = 255, view.rgb.at(x, y)[1] = view.rgb.at(x, y)[2] = 0;
    }
  view.alpha = TiledMask(alpha);
  return view;
}

std::vector<TrainingView> views_of(int count) {
  std::vector<TrainingView> views;
  for (int i = 0; i < count; ++i) views.push_back(view_at((i + 0.5) / count));
  return views;
}

const FieldCube kCube{Vec3f(-2.1f, -2.1f, -2.1f), 4.2f};

TEST(Room, IsSeenFromNewPlacesWithoutThePerson) {
  const auto views = views_of(20);
  RoomOptions options;
  options.steps = 100, options.rays_per_step = 1024;
  const auto room = train_room(views, kCube, options, {}, {});
  ASSERT_TRUE(room.ok()) << room.error().what;
  const RoomScene scene = make_room_scene(*room);
  const Camera between = camera_at(0.5);
  const Image truth = to_float(render_room(lens(), between.cam_from_world));
  const Image seen = to_float(room_picture(scene, between));
  Image grey(kRoomSize, kRoomSize, 3);
  for (float& v : grey.data) v = 0.5f;
  // Coarse steps of a quick test: far nearer to the truth than without a room, and no trace of the person.
  EXPECT_LT(mse(truth, seen), 0.6 * mse(truth, grey));
  Image8 person(kRoomSize, kRoomSize, 1, 0);
  for (int y = 20; y < kRoomSize; ++y)
    for (int x = 22; x < 42; ++x) *person.at(x, y) = 255;
  Image red(kRoomSize, kRoomSize, 3);
  for (std::size_t i = 0; i < red.data.size(); i += 3) red.data[i] = 1;
  EXPECT_LT(mse(truth, seen, person), 0.2 * mse(truth, red, person));
}

TEST(Room, IsTheSameForOneSeed) {
  const auto views = views_of(8);
  RoomOptions options;
  options.steps = 12, options.rays_per_step = 256;
  const auto first = train_room(views, kCube, options, {}, {}),
             again = train_room(views, kCube, options, {}, {});
  ASSERT_TRUE(first.ok() && again.ok());
  EXPECT_EQ(first->field.parameters, again->field.parameters);
  options.seed = 1;
  EXPECT_NE(train_room(views, kCube, options, {}, {})->field.parameters, first->field.parameters);
}

TEST(Room, HoldsNothingBetweenCameraAndPerson) {
  const auto views = views_of(8);
  RoomOptions options;
  options.steps = 1, options.rays_per_step = 64;
  const auto room = train_room(views, kCube, options, {}, {});
  ASSERT_TRUE(room.ok());
  const Vec3f eye = inverse(views[3].camera.cam_from_world).translation().cast<float>();
  const int n = room->occupancy.resolution;
  for (const float way : {0.05f, 0.3f, 0.5f, 1.0f}) {  // of the way to the head, which is at the origin
    const Vec3f cell = ((1 - way) * eye - kCube.origin) * (float(n) / kCube.side);
    EXPECT_FALSE(room->occupancy.occupied(int(cell.x()), int(cell.y()), int(cell.z()))) << way;
  }
}

TEST(Room, StopsWhenAskedAndNeedsMattes) {
  auto views = views_of(8);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(train_room(views, kCube, {}, {}, stop.get_token()).error().code, ErrorCode::cancelled);
  auto close = views;
  for (TrainingView& view : close) view.alpha = TiledMask(Image8(view.rgb.width, view.rgb.height, 1, 255));
  EXPECT_EQ(train_room(close, kCube, {}, {}, {}).error().code, ErrorCode::not_found);
  views[2].alpha = {};
  EXPECT_FALSE(train_room(views, kCube, {}, {}, {}).ok());
}

TEST(RoomCube, HoldsThePointsButForOutliers) {
  std::vector<Vec3f> points;
  for (int i = 0; i < 500; ++i) points.emplace_back(std::sin(float(i)), 0.5f * std::cos(3.f * float(i)), 2.f);
  points.emplace_back(500, 0, 0);
  const FieldCube cube = room_cube(views_of(8), points);
  EXPECT_GT(cube.side, 2);
  EXPECT_LT(cube.side, 3);
  EXPECT_LT(cube.origin.x(), -0.9f);
  const FieldCube unknown = room_cube(views_of(8), {});
  EXPECT_GT(unknown.side, 4);
}

TEST(RoomCube, OfALandscapeHoldsThePartAboutThePerson) {
  std::vector<Vec3f> points;  // from where they stand to far hills
  for (int i = 0; i < 500; ++i) points.emplace_back(std::sin(float(i)), 0.1f, 1 + float(i));
  const auto views = views_of(8);
  const FieldCube cube = room_cube(views, points);
  for (const TrainingView& view : views)
    for (const Vec3f& at : {Vec3f(view.pose.world_from_head.translation().cast<float>()),
                            Vec3f(inverse(view.camera.cam_from_world).translation().cast<float>())}) {
      const Vec3f inside = (at - cube.origin) / cube.side;
      EXPECT_GT(inside.minCoeff(), 0) << at.transpose();
      EXPECT_LT(inside.maxCoeff(), 1) << at.transpose();
    }
  EXPECT_GT(cube.origin.z() + cube.side, 20);
}

}  // namespace
}  // namespace likeness
