// Claims about regions of a head, on a made-up one and, where present, on ICT-FaceKit.
#include "core/scene/head_regions.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "tests/core/head/ict_head.h"
#include "tests/core/head/synthetic_head.h"

namespace likeness {
namespace {

TEST(HeadRegions, MouthAndEyesFollowTheParts) {
  const HeadModel model = synthetic_head();
  const HeadRegions regions = head_regions(model);
  ASSERT_EQ(regions.face.size(), model.triangles.size());
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    EXPECT_LE(regions.mouth_interior[t] + regions.eyes[t] + regions.skin[t], 1);
    for (int k = 0; k < 3; ++k) {
      const HeadPart part = model.parts[model.triangles[t][k]];
      if (regions.eyes[t]) {
        EXPECT_TRUE(part == HeadPart::left_eyeball || part == HeadPart::right_eyeball);
      }
    }
  }
}

TEST(RegionTriangles, KeepFlaggedTrianglesAndTheirNumbers) {
  const HeadModel model = synthetic_head();
  std::vector<std::uint8_t> flags(model.triangles.size(), 0);
  flags[3] = flags[17] = 1;
  std::vector<int> source;
  const std::vector<Triangle> kept = region_triangles(model, flags, &source);
  EXPECT_EQ(source, (std::vector<int>{3, 17}));
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[1], model.triangles[17]);
  const std::vector<int> vertices = region_vertices(model, flags);
  EXPECT_TRUE(std::is_sorted(vertices.begin(), vertices.end()));
  for (const Triangle& triangle : kept)
    for (int k = 0; k < 3; ++k)
      EXPECT_TRUE(std::binary_search(vertices.begin(), vertices.end(), triangle[k]));
}

TEST(VertexNeighbours, AreMutual) {
  const HeadModel model = synthetic_head();
  const auto neighbours = vertex_neighbours(model.vertex_count(), model.triangles);
  for (int v = 0; v < model.vertex_count(); ++v)
    for (const int other : neighbours[v]) {
      EXPECT_NE(other, v);
      EXPECT_TRUE(std::binary_search(neighbours[other].begin(), neighbours[other].end(), v));
    }
}

void expect_sensible_regions(const HeadModel& model) {
  const HeadRegions regions = head_regions(model);
  const auto landmarks = landmark_positions(model, model.vertices);
  const auto highest = [&](const std::vector<std::uint8_t>& flags) {
    float y = -1;
    for (const int v : region_vertices(model, flags)) y = std::max(y, model.vertices[v].y());
    return y;
  };
  const auto lowest = [&](const std::vector<std::uint8_t>& flags) {
    float y = 1;
    for (const int v : region_vertices(model, flags)) y = std::min(y, model.vertices[v].y());
    return y;
  };
  // The face reaches from the chin to above the brows, but not to the crown; the head from the chin to the
  // crown.
  EXPECT_LT(lowest(regions.face), landmarks[8].y() + 0.003f);
  EXPECT_GT(highest(regions.face), landmarks[19].y() + 0.02f);
  EXPECT_LT(highest(regions.face), highest(regions.head) - 0.03f);
  EXPECT_GT(lowest(regions.head), landmarks[8].y() - 0.03f);
  EXPECT_NEAR(highest(regions.head), highest(std::vector<std::uint8_t>(model.triangles.size(), 1)), 1e-6f);
  // The shoulders' end of the neck is no head, and the face is part of the head.
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    if (regions.face[t]) {
      ASSERT_TRUE(regions.head[t]) << "triangle " << t;
    }
    const float y = model.vertices[model.triangles[t][0]].y();
    if (y < landmarks[8].y() - 0.045f) {
      ASSERT_FALSE(regions.head[t]) << "triangle " << t;
    }
  }
  // Brows, nose, eyes and mouth lie in the face; the jaw line is its border.
  for (int l = 17; l < kLandmarkCount; ++l)
    EXPECT_EQ(regions.face[model.landmark_triangle[l]], 1) << "landmark " << l;
}

TEST(HeadRegions, OfTheBuiltInHeadHoldWhatTheirNamesSay) { expect_sensible_regions(make_builtin_head()); }

TEST(HeadRegions, OfTheIctHeadHoldWhatTheirNamesSay) {
  LIKENESS_NEED_ICT_HEAD(model);
  expect_sensible_regions(model);
}

TEST(HeadRegions, FaceWithoutPartsIsTheFaceWithThem) {
  LIKENESS_NEED_ICT_HEAD(model);
  HeadModel unknown = model;
  std::fill(unknown.parts.begin(), unknown.parts.end(), HeadPart::unknown);
  const HeadRegions with = head_regions(model), without = head_regions(unknown);
  int either = 0, both = 0;
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    either += with.face[t] || without.face[t];
    both += with.face[t] && without.face[t];
  }
  EXPECT_GT(both, 0.9 * either);
}

}  // namespace
}  // namespace likeness
