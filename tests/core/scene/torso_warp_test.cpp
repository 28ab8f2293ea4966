// Claims about the torso's deformation: it is inverted accurately enough, and continues beyond the grid.
#include "core/scene/torso_warp.h"

#include <gtest/gtest.h>

#include <cmath>

namespace likeness {
namespace {

TorsoModes wavy_modes() {
  TorsoModes modes;
  modes.grid = {{-0.25f, -0.35f}, 0.04f, 13, 7};
  const std::size_t count = 2 * std::size_t(modes.grid.nodes());
  modes.mean.assign(count, 0.f);
  for (auto& mode : modes.modes) mode.assign(count, 0.f);
  for (int row = 0; row < 7; ++row)
    for (int column = 0; column < 13; ++column) {
      const std::size_t i = 2 * (std::size_t(row) * 13 + column);
      modes.mean[i + 1] = 0.001f;
      modes.modes[0][i] = 0.003f * std::sin(0.5f * float(column));
      modes.modes[1][i + 1] = 0.004f * std::cos(0.4f * float(column) + 0.5f * float(row));
      modes.modes[2][i] = 0.0005f * float(row);
    }
  return modes;
}

Vec2f posed_at(const TorsoModes& modes, const TorsoShape& shape, const Vec2f& canonical) {
  const auto d = posed_displacement(modes, shape);
  const GridPlace place = place_in(modes.grid, canonical.x(), canonical.y());
  Vec2f p = canonical;
  for (std::size_t k = 0; k < 4; ++k)
    p += place.weight[k] * Vec2f(d[2 * std::size_t(place.node[k])], d[2 * std::size_t(place.node[k]) + 1]);
  return p;
}

TEST(TorsoWarp, MapsBackToTheCanonicalTorso) {
  const TorsoModes modes = wavy_modes();
  const TorsoShape shape{1.5f, -2.f, 1.f};
  const TorsoField field = torso_field(modes, shape);
  for (const Vec2f& canonical : {Vec2f(0.f, -0.2f), Vec2f(-0.13f, -0.27f), Vec2f(0.11f, -0.19f)}) {
    const Vec2f posed = posed_at(modes, shape, canonical);
    EXPECT_GT((posed - canonical).norm(), 0.001f);
    const Vec3f point(posed.x(), posed.y(), 0.03f);
    const Vec3f back = point + torso_displacement(field, point);
    EXPECT_LT((back - Vec3f(canonical.x(), canonical.y(), 0.03f)).norm(), 3e-4f);
  }
}

TEST(TorsoWarp, IgnoresDepthAndContinuesBeyondTheBorder) {
  const TorsoField field = torso_field(wavy_modes(), {1.f, 1.f, -1.f});
  const Vec3f near = torso_displacement(field, {0.05f, -0.2f, 0.1f});
  const Vec3f far = torso_displacement(field, {0.05f, -0.2f, -0.2f});
  EXPECT_EQ(near, far);
  EXPECT_EQ(near.z(), 0.f);
  EXPECT_EQ(torso_displacement(field, {2.f, -0.19f, 0.f}), torso_displacement(field, {0.23f, -0.19f, 0.f}));
  EXPECT_TRUE(torso_displacement(field, {-2.f, 5.f, 0.f}).allFinite());
}

TEST(TorsoWarp, AFileWithFewerModesMovesTheTorsoAsBeforeAndOneWithMoreIsRefused) {
  const TorsoModes all = wavy_modes();
  TorsoModes taken;
  taken.grid = all.grid, taken.mean = all.mean;
  ASSERT_TRUE(take_modes({all.modes[0], all.modes[1], all.modes[2]}, taken));
  EXPECT_TRUE(is_consistent(taken));
  const std::vector<float> numbers{1.5f, -2.f, 1.f};
  const auto shape = take_shape(numbers);
  ASSERT_TRUE(shape.has_value());
  EXPECT_EQ(posed_displacement(taken, *shape), posed_displacement(all, {1.5f, -2.f, 1.f}));
  EXPECT_FALSE(take_modes(std::vector<std::vector<float>>(kTorsoModes + 1, all.mean), taken));
  EXPECT_FALSE(take_shape(std::vector<float>(kTorsoModes + 1)).has_value());
}

TEST(TorsoWarp, BelowTheHemItLooksAtTheHem) {
  TorsoModes modes = wavy_modes();
  modes.hem = TorsoHem{-0.2f, 0.1f, -0.3f};
  TorsoModes rigid;
  rigid.hem = modes.hem;
  const TorsoShape shape{1.5f, -2.f, 1.f};
  const TorsoField bent = torso_field(modes, shape), stiff = torso_field(rigid, shape);
  EXPECT_FALSE(stiff.empty());
  modes.hem.reset();
  const TorsoField endless = torso_field(modes, shape);
  for (const Vec3f& above : {Vec3f(0, -0.1f, 0.05f), Vec3f(0.2f, -0.15f, 0)}) {
    EXPECT_EQ(torso_displacement(bent, above), torso_displacement(endless, above));
    EXPECT_EQ(torso_displacement(stiff, above), Vec3f(0, 0, 0));
  }
  for (const Vec3f& below : {Vec3f(0, -0.3f, 0.05f), Vec3f(0.2f, -0.5f, 0)})
    for (const TorsoField* field : {&bent, &stiff}) {
      const Vec3f canonical = below + torso_displacement(*field, below);
      EXPECT_NEAR(canonical.y(), rigid.hem->at(canonical.x(), canonical.z()), 1e-6);
      EXPECT_EQ(canonical.z(), below.z());
    }
}

TEST(TorsoWarp, WithoutModesNothingMoves) {
  const TorsoField field = torso_field({}, {1.f, 2.f, 3.f});
  EXPECT_TRUE(field.empty());
  EXPECT_EQ(torso_displacement(field, {0.1f, 0.2f, 0.3f}), Vec3f(0.f, 0.f, 0.f));
}

}  // namespace
}  // namespace likeness
