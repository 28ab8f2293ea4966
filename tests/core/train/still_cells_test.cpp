// Claims about the places where a field does not depend on the expression.
#include "core/train/still_cells.h"

#include <gtest/gtest.h>

#include <set>

#include "core/head/builtin_head.h"

namespace likeness {
namespace {

struct Face {
  HeadModel model = make_builtin_head();
  HeadShape shape = shape_head(model, {Eigen::VectorXf::Zero(model.identity_count()), {}});
  FieldCube cube{Vec3f(-0.16f, -0.18f, -0.16f), 0.36f};

  Articulation acting(const char* action, float amount) const {
    Articulation articulation = neutral_articulation(model);
    add_action(articulation, *find_action(model, action), amount);
    return articulation;
  }
  bool still(const OccupancyGrid& grid, const Vec3f& at) const {
    const Vec3f cell = (at - cube.origin) * (float(grid.resolution) / cube.side);
    return grid.occupied(int(cell.x()), int(cell.y()), int(cell.z()));
  }
};

TEST(StillCells, AreHairAndSkullButNotASpeakingMouth) {
  const Face face;
  const auto landmarks = landmark_positions(face.model, face.model.vertices);
  const std::vector<Articulation> speech = {face.acting("jawOpen", 0), face.acting("jawOpen", 0.6f)};
  const OccupancyGrid grid = still_cells(face.model, face.shape, speech, face.cube, 48);
  EXPECT_FALSE(face.still(grid, landmarks[57]));  // lower lip
  EXPECT_FALSE(face.still(grid, landmarks[8]));   // chin
  EXPECT_FALSE(face.still(grid, landmarks[57] + Vec3f(0, 0, 0.006f)));
  Vec3f crown = face.model.vertices[0];
  for (const Vec3f& v : face.model.vertices)
    if (v.y() > crown.y()) crown = v;
  EXPECT_TRUE(face.still(grid, crown));
  EXPECT_TRUE(face.still(grid, crown + Vec3f(0, 0.03f, 0)));
  EXPECT_TRUE(face.still(grid, landmarks[27]));  // root of the nose: no brow was raised
  const std::vector<Articulation> frown = {face.acting("browInnerUp_L", 0), face.acting("browInnerUp_L", 1)};
  EXPECT_FALSE(face.still(still_cells(face.model, face.shape, frown, face.cube, 48), landmarks[22]));
}

TEST(StillCells, AreAllOfAFaceThatNeverMoves) {
  const Face face;
  const std::vector<Articulation> rest(3, neutral_articulation(face.model));
  const OccupancyGrid grid = still_cells(face.model, face.shape, rest, face.cube, 16);
  for (int z = 0; z < 16; ++z)
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) EXPECT_TRUE(grid.occupied(x, y, z));
}

TEST(ShuffleConditions, ChangesStillSamplesOnlyAndTheSameWayEveryTime) {
  OccupancyGrid still = make_occupancy(4, false);
  set_occupied(still, 3, 0, 0, true);
  FieldSamples samples;
  samples.resize(10000);
  for (std::size_t i = 0; i < samples.count(); ++i) {
    samples.x[i] = i % 2 == 0 ? 0.9f : 0.1f;
    samples.y[i] = samples.z[i] = 0;
    samples.view[i] = 2;
  }
  FieldSamples again = samples;
  shuffle_conditions(still, 5, 5, 7, 11, samples);
  shuffle_conditions(still, 5, 5, 7, 11, again);
  EXPECT_EQ(samples.view, again.view);
  std::set<int> rows;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    if (i % 2 == 1) {
      EXPECT_EQ(samples.view[i], 2);
    } else {
      rows.insert(samples.view[i]);
    }
  }
  EXPECT_EQ(rows, (std::set<int>{5, 6, 7, 8, 9}));  // rows without a code
  shuffle_conditions(still, 5, 5, 7, 12, again);
  EXPECT_NE(samples.view, again.view);
}

}  // namespace
}  // namespace likeness
