// Claims about the measurement of empty cells, on a ball whose density is known everywhere: a field that
// keeps to the canonical face loses nothing to a look-up there, one that moves its density against the head
// model's deformation loses what geometry says, and a grid of the posed head keeps more samples the more its
// poses move.
#include "core/lab/study/cull_study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/core/scene/constant_lattice.h"

namespace likeness {
namespace {

constexpr int kCells = 32;
constexpr float kSide = 0.2f, kRadius = 0.22f;  // m; of the ball, in cubes
const Vec3f kOrigin = Vec3f::Constant(-0.1f), kMiddle = Vec3f::Constant(0.5f);

enum LookUp { none, trained, posed, canonical, resting };

struct BallScene {
  Volume head;
  std::vector<WarpLattice> lattices;
  std::vector<Vec3f>
      residual;  // of a row: how far the field moves its density against the canonical face, cubes

  // A view a way; the last row is the face at rest.
  explicit BallScene(const std::vector<Vec3f>& ways) {
    head.cube = {kOrigin, kSide};
    head.allowed = make_occupancy(kCells, true);
    head.kept = make_occupancy(kCells, false);
    for (const Vec3f& way : ways) lattices.push_back(constant_lattice(kOrigin, kSide, kSide * way));
    residual.assign(ways.size() + 1, Vec3f::Zero());
  }
  CullScene scene() const {
    return {head, lattices, {}, [this](const FieldSamples& at, std::vector<float>& sigma) {
              sigma.resize(at.count());
              for (std::size_t i = 0; i < at.count(); ++i) {
                const Vec3f p = Vec3f(at.x[i], at.y[i], at.z[i]) - residual[std::size_t(at.view[i])];
                sigma[i] = (p - kMiddle).norm() < kRadius ? 40.f : 0.f;
              }
            }};
  }
  // As the view `row` shows it, by rays along z.
  CullTable measure(const LearntCells& cells, std::size_t row) const {
    CullView view;
    view.lattice = &lattices[std::min(row, lattices.size() - 1)];
    view.row = std::int32_t(row);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 60; ++x)
        view.rays.push_back(
            {Vec3f((float(x) + 0.5f) / 60, (float(y) + 0.5f) / 60, -1), Vec3f(0, 0, 1 / kSide)});
    CullTable table{};
    add_culled(scene(), make_occupancy(kCells, true), cells, view, 0.001f, table);
    return table;
  }
  LearntCells learn() const { return learn_cells(scene(), 24, 7); }
};

// Share of a ball's volume beyond a ball of another radius whose middle is `apart` away.
double share_beyond(double radius, double other, double apart) {
  if (apart + radius <= other) return 0;
  if (apart >= radius + other) return 1;
  const double sum = radius + other - apart;
  const double lens = std::numbers::pi * sum * sum *
                      (apart * apart + 2 * apart * (radius + other) - 3 * std::pow(radius - other, 2)) /
                      (12 * apart);
  return 1 - lens / (4.0 / 3 * std::numbers::pi * std::pow(radius, 3));
}

TEST(CullStudy, AFieldThatKeepsToTheCanonicalFaceLosesNothing) {
  const BallScene ball({Vec3f(0, 0, 0), Vec3f(0.15f, -0.05f, 0.1f)});
  const LearntCells cells = ball.learn();
  for (const std::size_t row : {0u, 1u}) {
    const CullTable table = ball.measure(cells, row);
    for (const LookUp l : {none, posed, canonical, resting}) {
      EXPECT_EQ(table[l].share_density_lost(), 0) << kCullLookups[l];
      EXPECT_EQ(table[l].share_light_lost(), 0) << kCullLookups[l];
    }
    EXPECT_GT(table[none].dense, 10000);
    EXPECT_EQ(table[none].kept, table[none].samples);
    EXPECT_EQ(table[trained].kept, table[none].samples);  // a full grid
    EXPECT_LT(table[canonical].kept, 0.3 * table[none].kept);
    EXPECT_LT(table[canonical].kept, 0.8 * table[posed].kept);  // one ball beside the union of two
  }
}

TEST(CullStudy, ADisplacedResidualIsFoundByAsMuchAsGeometrySays) {
  const double cell = 1.0 / kCells;
  double before = -1;
  for (const float apart : {0.f, 0.08f, 0.16f, 0.3f}) {
    BallScene ball({Vec3f(0.06f, 0, 0)});
    const LearntCells cells = ball.learn();
    ball.residual[0] = Vec3f(0, apart, 0);  // after the grid was learnt: a field that moves its density
    const CullTable table = ball.measure(cells, 0);
    const double lost = table[canonical].share_density_lost();
    // The grid holds the ball, and up to two cells round it.
    EXPECT_LE(lost, share_beyond(kRadius, kRadius, apart) + 0.01) << apart;
    EXPECT_GE(lost, share_beyond(kRadius, kRadius + 2 * std::sqrt(3.0) * cell, apart) - 0.01) << apart;
    EXPECT_NEAR(table[canonical].share_dense_lost(), lost, 1e-9);  // one density
    EXPECT_EQ(table[none].share_density_lost(), 0);
    EXPECT_GE(lost, before);
    if (apart > 0.1f) {
      EXPECT_GT(lost, before + 0.02);
      EXPECT_GT(table[canonical].share_light_lost(), 0.02);
    }
    before = lost;
  }
}

TEST(CullStudy, AGridLearntOverTheExpressionsKnowsTheirResidualsAndOneOfTheRestingFaceDoesNot) {
  BallScene ball({Vec3f(0, 0, 0), Vec3f(0, 0, 0)});
  ball.residual[1] = Vec3f(0.2f, 0, 0);
  const LearntCells cells = ball.learn();
  const CullTable table = ball.measure(cells, 1);
  EXPECT_EQ(table[canonical].share_density_lost(), 0);
  EXPECT_GT(table[resting].share_density_lost(), 0.1);
  EXPECT_LT(table[resting].kept, table[canonical].kept);
}

TEST(CullStudy, CellsThatAreAlwaysKeptAreNeverCulled) {
  BallScene ball({Vec3f(0, 0, 0)});
  ball.head.kept = make_occupancy(kCells, true);
  const LearntCells cells = ball.learn();
  ball.residual[0] = Vec3f(0.3f, 0, 0);
  const CullTable table = ball.measure(cells, 0);
  EXPECT_EQ(table[canonical].kept, table[none].kept);
  EXPECT_EQ(table[canonical].share_density_lost(), 0);
}

}  // namespace
}  // namespace likeness
