// Claims about values spread over a mesh.
#include "core/train/fill_mesh.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

// A chain of eleven vertices.
std::vector<std::vector<int>> chain() {
  std::vector<std::vector<int>> neighbours(11);
  for (int v = 0; v < 11; ++v) {
    if (v > 0) neighbours[std::size_t(v)].push_back(v - 1);
    if (v < 10) neighbours[std::size_t(v)].push_back(v + 1);
  }
  return neighbours;
}

TEST(FillMesh, GoesStraightFromOneKnownValueToTheOther) {
  std::vector<float> values(11, -7), known(11, 0);
  values[0] = 1, values[10] = 3, known[0] = known[10] = 1;
  fill_mesh(chain(), known, std::vector<std::uint8_t>(11, 1), 400, values);
  for (int v = 0; v <= 10; ++v) EXPECT_NEAR(values[std::size_t(v)], 1 + 0.2f * float(v), 1e-3f);
}

TEST(FillMesh, DoesNotCrossWhatTakesNoPart) {
  std::vector<float> values(11, -7), known(11, 0);
  values[0] = 1, values[10] = 3, known[0] = known[10] = 1;
  std::vector<std::uint8_t> member(11, 1);
  member[5] = 0;
  fill_mesh(chain(), known, member, 400, values);
  EXPECT_NEAR(values[4], 1, 1e-3f);
  EXPECT_NEAR(values[6], 3, 1e-3f);
  EXPECT_EQ(values[5], -7);
}

TEST(FillMesh, LeavesAllAsItIsWhereNothingIsKnown) {
  std::vector<float> values(11, 2);
  values[3] = 5;
  const std::vector<float> before = values;
  fill_mesh(chain(), std::vector<float>(11, 0), std::vector<std::uint8_t>(11, 1), 10, values);
  EXPECT_EQ(values, before);
}

TEST(FillMesh, KeepsWhatIsHalfKnownNearIt) {
  std::vector<float> values(11, 0), known(11, 1);
  values[5] = 4, known[5] = 0.5f;
  fill_mesh(chain(), known, std::vector<std::uint8_t>(11, 1), 50, values);
  EXPECT_NEAR(values[5], 2, 1e-4f);
}

}  // namespace
}  // namespace likeness
