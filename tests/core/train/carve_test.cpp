// Claims about carving with mattes.
#include "core/train/carve.h"

#include <gtest/gtest.h>

#include "core/head/builtin_head.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

// A camera 1 m before the cube's centre whose whole picture has one value in `person` and one in `head`.
CarveView plain_view(std::uint8_t person, std::uint8_t head) {
  CarveView view;
  view.intrinsics.width = view.intrinsics.height = 8;
  view.intrinsics.fx = view.intrinsics.fy = 8;
  view.intrinsics.cx = view.intrinsics.cy = 4;
  view.cam_from_field = Pose(Eigen::Translation3d(0, 0, 1));
  view.person = Image8(8, 8, 1), view.head = Image8(8, 8, 1);
  std::fill_n(view.person.at(0, 0), 64, person);
  std::fill_n(view.head.at(0, 0), 64, head);
  return view;
}

int cells_left(const std::vector<CarveView>& views, const CarveRule& rule) {
  constexpr int n = 4;
  OccupancyGrid grid = make_occupancy(n, true);
  FieldCube cube;
  cube.side = 0.1f;
  cube.origin = Vec3f::Constant(-0.05f);
  const std::vector<std::uint8_t> classes(n * n * n, 0);
  carve(grid, cube, views, classes, std::span(&rule, 1));
  int left = 0;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) left += grid.occupied(x, y, z);
  return left;
}

TEST(Carve, UnderTheHeadTheMatteSaysNothingAboutTheTorso) {
  std::vector<CarveView> views(16, plain_view(255, 255));  // a head stands there, and the person with it
  views[3] = views[9] = plain_view(0, 0);                  // twice it does not, and there is nobody
  EXPECT_EQ(cells_left(views, {0.8f, false}), 64);
  EXPECT_EQ(cells_left(views, {0.8f, true}), 0);
  views[3] = views[9] = plain_view(255, 0);  // twice it does not, and the person is still there
  EXPECT_EQ(cells_left(views, {0.8f, true}), 64);
}

TEST(Carve, AViewDoesNotVoteBeyondWhatItFilmed) {
  // Nobody stands in the left half of the picture, and the right half was not filmed.
  std::vector<CarveView> views(3, plain_view(0, 0));
  EXPECT_EQ(cells_left(views, {0.8f, false}), 0);
  CarveView whole = plain_view(255, 0);
  views.push_back(whole);
  EXPECT_EQ(cells_left(views, {0.8f, false}), 0);
  for (std::size_t v = 0; v < 3; ++v) views[v].inside = {0, 0, 4, 8};
  EXPECT_EQ(cells_left(views, {0.8f, false}), 32);
}

TEST(Carve, KeepsNothingWhereNoViewVotes) {
  const std::vector<CarveView> views(5, plain_view(255, 255));
  EXPECT_EQ(cells_left(views, {0.8f, true}), 0);
  EXPECT_EQ(cells_left({}, {0.8f, true}), 64);
}

TEST(Carve, ATorsoIsLookedForWhereItsDeformationCarriesIt) {
  // The person stands in the left half of the picture alone; the torso, canonical on the right, has moved
  // there.
  CarveView view = plain_view(0, 0);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 4; ++x) view.person.at(x, y)[0] = 255;
  const int half = cells_left({view}, {0.8f, false});
  EXPECT_EQ(half, 32);
  view.grid = {Vec2f(-0.05f, -0.05f), 0.1f, 2, 2};
  view.displacement.assign(8, 0.0f);
  EXPECT_EQ(cells_left({view}, {0.8f, false}), half);
  for (std::size_t node = 0; node < 4; ++node) view.displacement[2 * node] = -0.1f;
  EXPECT_EQ(cells_left({view}, {0.8f, false}), 64);
  for (std::size_t node = 0; node < 4; ++node) view.displacement[2 * node] = 0.1f;
  EXPECT_EQ(cells_left({view}, {0.8f, false}), 0);
}

TEST(Carve, BustIsNotPartOfTheHead) {
  TrainingSet set = ball_set(6, 64);
  set.model = make_builtin_head();
  set.person.identity = Eigen::VectorXf::Zero(set.model.identity_count());
  for (TrainingView& view : set.views) view.pose.articulation = neutral_articulation(set.model);
  const HeadShape shape = shape_head(set.model, set.person);
  const auto covered = [&](float base) {
    int count = 0;
    for (const CarveView& view : torso_carve_views(set, shape, base, 6))
      for (int y = 0; y < view.head.height; ++y)
        for (int x = 0; x < view.head.width; ++x) count += view.head.at(x, y)[0] > 0;
    return count;
  };
  EXPECT_GT(covered(-1.0f), 1.1 * covered(-0.10f));
  EXPECT_GT(covered(-0.10f), 0);
  EXPECT_EQ(covered(1.0f), 0);
}

}  // namespace
}  // namespace likeness
