// The deformation field on a lattice, on the built-in head.
#include "core/scene/warp_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "core/head/builtin_head.h"
#include "core/head/named_actions.h"
#include "tests/core/scene/warp_lattice_reference.h"

namespace likeness {
namespace {

class WarpLatticeTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    model_ = new HeadModel(make_builtin_head());
    shape_ = new HeadShape(shape_head(*model_, PersonShape{}));
  }
  static void TearDownTestSuite() { delete model_, delete shape_; }

  static std::vector<Vec3f> posed(const std::string& name, float amount) {
    Articulation a = neutral_articulation(*model_);
    for (const NamedAction& action : model_->actions)
      if (action.name == name) {
        a.expression = amount * action.expression;
        a.jaw = amount * action.jaw;
      }
    return pose_head(*model_, *shape_, a);
  }
  static WarpFrame frame() { return *make_warp_frame(*model_, *shape_, neutral_articulation(*model_)); }

  static HeadModel* model_;
  static HeadShape* shape_;
};
HeadModel* WarpLatticeTest::model_ = nullptr;
HeadShape* WarpLatticeTest::shape_ = nullptr;

TEST_F(WarpLatticeTest, TheRestingFaceIsNotMoved) {
  const WarpFrame f = frame();
  const WarpLattice lattice = make_warp_lattice(f, posed("jawOpen", 0));
  for (const Vec3f& v : shape_->vertices) EXPECT_LT(displacement_at(lattice, v).norm(), 1e-5f);
}

TEST_F(WarpLatticeTest, SkinMapsBackToItsRestingPlace) {
  const WarpFrame f = frame();
  for (const std::string name : {"jawOpen", "mouthSmile_L", "mouthPucker", "browInnerUp_L"}) {
    const std::vector<Vec3f> now = posed(name, 1);
    const WarpLattice lattice = make_warp_lattice(f, now);
    std::vector<float> before, after;
    for (std::size_t k = 0; k < f.vertices.size(); ++k) {
      const auto v = std::size_t(f.vertices[k]);
      if (model_->parts[v] != HeadPart::face || (now[v] - f.rest[k]).norm() < 0.001f) continue;
      before.push_back((now[v] - f.rest[k]).norm());
      after.push_back((now[v] + displacement_at(lattice, now[v]) - f.rest[k]).norm());
    }
    ASSERT_GT(before.size(), 50u) << name;
    const auto median = [](std::vector<float> x) {
      std::nth_element(x.begin(), x.begin() + std::ptrdiff_t(x.size() / 2), x.end());
      return x[x.size() / 2];
    };
    EXPECT_LT(median(after), 0.15f * median(before)) << name;
  }
}

TEST_F(WarpLatticeTest, SurfaceWithDetailMapsBackToRest) {
  // A smile pushes 3 mm of skin out over both cheeks, which the model knows nothing of.
  const auto count = Eigen::Index(model_->vertices.size());
  ExpressionDetail detail;
  const NamedAction* smile = find_action(*model_, "mouthSmile_L");
  ASSERT_NE(smile, nullptr);
  const std::array<Vec3f, kLandmarkCount> marks = landmark_positions(*model_, shape_->vertices);
  std::vector<float> heights;
  for (Eigen::Index v = 0; v < count; ++v) {
    const Vec3f& p = shape_->vertices[std::size_t(v)];
    const float near = std::min((p - marks[48]).norm(), (p - marks[54]).norm());
    const float height = 0.003f * std::exp(-near * near / (0.02f * 0.02f));
    if (model_->parts[std::size_t(v)] != HeadPart::face || height < 1e-4f) continue;
    detail.vertices.push_back(std::int32_t(v));
    heights.push_back(height);
  }
  ASSERT_GT(heights.size(), 50u);
  detail.basis = Eigen::Map<Eigen::VectorXf>(heights.data(), Eigen::Index(heights.size()));
  detail.mean = Eigen::VectorXf::Zero(detail.basis.rows());
  detail.middle = Eigen::VectorXf::Zero(model_->expression_count() + 3);
  detail.rows = Eigen::MatrixXf::Zero(1, detail.middle.size());
  detail.rows.row(0).head(model_->expression_count()) = smile->expression.transpose();
  detail.rows /= smile->expression.squaredNorm();
  detail.low = Eigen::VectorXf::Zero(1), detail.high = Eigen::VectorXf::Ones(1);

  Articulation smiling = neutral_articulation(*model_);
  smiling.expression = smile->expression;
  const WarpFrame plain = frame(),
                  f = *make_warp_frame(*model_, *shape_, neutral_articulation(*model_), kWarpCell, &detail);
  const std::vector<Vec3f> bare = posed("mouthSmile_L", 1),
                           now = pose_detailed_head(*model_, *shape_, smiling, detail);
  const WarpLattice with = make_warp_lattice(f, now), without = make_warp_lattice(plain, bare);
  std::vector<float> known, unknown;
  for (std::size_t k = 0; k < detail.vertices.size(); ++k) {
    if (heights[k] < 0.002f) continue;
    const auto v = std::size_t(detail.vertices[k]);
    const Vec3f rest = shape_->vertices[v];
    ASSERT_GT((now[v] - bare[v]).norm(), 0.0019f);
    known.push_back((now[v] + displacement_at(with, now[v]) - rest).norm());
    unknown.push_back((now[v] + displacement_at(without, now[v]) - rest).norm());
  }
  ASSERT_GT(known.size(), 5u);
  const auto median = [](std::vector<float> x) {
    std::nth_element(x.begin(), x.begin() + std::ptrdiff_t(x.size() / 2), x.end());
    return x[x.size() / 2];
  };
  EXPECT_LT(median(known), 0.4f * median(unknown));
  // Without detail the field is identical, to the bit.
  const ExpressionDetail none;
  const WarpFrame same = *make_warp_frame(*model_, *shape_, neutral_articulation(*model_), kWarpCell, &none);
  EXPECT_EQ(make_warp_lattice(same, bare).displacement, without.displacement);
}

TEST_F(WarpLatticeTest, EqualsPlainLoops) {
  const WarpFrame f = frame();
  for (const std::string name : {"jawOpen", "mouthPucker"}) {
    const std::vector<Vec3f> now = posed(name, 0.8f);
    const WarpLattice lattice = make_warp_lattice(f, now);
    const std::vector<Vec3f> plain = warp_lattice_reference(f, now);
    const DenseLattice dense = dense_lattice(lattice);
    ASSERT_EQ(dense.displacement.size(), 3 * plain.size());
    float most = 0, error = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      const std::int16_t* d = dense.displacement.data() + 3 * i;
      most = std::max(most, plain[i].norm());
      error = std::max(error, (lattice.unit * Vec3f(d[0], d[1], d[2]) - plain[i]).norm());
    }
    EXPECT_GT(most, 0.005f) << name;
    EXPECT_LT(error, 1e-4f * most) << name;  // rounding to counts is 3e-5
  }
}

TEST_F(WarpLatticeTest, MatchesALatticeThatKeepsEveryNode) {
  const WarpFrame f = frame();
  const WarpLattice lattice = make_warp_lattice(f, posed("jawOpen", 1));
  const DenseLattice dense = dense_lattice(lattice);
  EXPECT_LT(lattice.bytes(), dense.displacement.size() * sizeof(std::int16_t) * 3 / 5);
  std::mt19937 random(1);
  const auto along = [&](int axis) {
    return std::uniform_real_distribution<float>(-2, float(f.nodes[std::size_t(axis)]) + 1)(random);
  };
  int moved = 0, still = 0;
  for (int i = 0; i < 200000; ++i) {
    const float x = along(0), y = along(1), z = along(2);
    const Vec3f p = f.origin + f.cell * Vec3f(x, y, z), way = displacement_at(lattice, p);
    ASSERT_EQ(way, displacement_at(dense, p)) << x << " " << y << " " << z;
    ++(way.isZero(0) ? still : moved);
  }
  EXPECT_GT(moved, 20000);
  EXPECT_GT(still, 20000);
}

TEST_F(WarpLatticeTest, FadesToNothingAwayFromTheFace) {
  const WarpFrame f = frame();
  const WarpLattice lattice = make_warp_lattice(f, posed("jawOpen", 1));
  const Vec3f chin = shape_->vertices[std::size_t(f.vertices.front())];
  EXPECT_EQ(displacement_at(lattice, chin + Vec3f(0, 0, 1)), Vec3f::Zero());
  // On the way out from the lower lip the field shrinks.
  const auto landmarks = landmark_positions(*model_, posed("jawOpen", 1));
  const Vec3f lip = landmarks[57];
  const float at = displacement_at(lattice, lip).norm();
  EXPECT_GT(at, 0.01f);
  EXPECT_LT(displacement_at(lattice, lip + Vec3f(0, 0, 0.03f)).norm(), 0.5f * at);
  EXPECT_LT(displacement_at(lattice, lip + Vec3f(0, 0, 0.045f)).norm(), 0.1f * at);
}

TEST_F(WarpLatticeTest, IsContinuous) {
  const WarpFrame f = frame();
  const WarpLattice lattice = make_warp_lattice(f, posed("jawOpen", 0.5f));
  const Vec3f from = landmark_positions(*model_, posed("jawOpen", 0.5f))[66] + Vec3f(0, 0.02f, -0.02f);
  for (int i = 0; i < 400; ++i) {
    const Vec3f p = from + Vec3f(0, -0.0001f * float(i), 0.0001f * float(i));
    const float step =
        (displacement_at(lattice, p + Vec3f(0, 1e-5f, 0)) - displacement_at(lattice, p)).norm();
    EXPECT_LT(step, 1e-4f);
  }
}

TEST_F(WarpLatticeTest, AModelThatDoesNotMoveHasNoLattice) {
  HeadModel still = *model_;
  still.expression_basis.setZero();
  still.skinning_weights.col(kRoot) += still.skinning_weights.col(kJaw);
  still.skinning_weights.col(kJaw).setZero();
  still.pose_basis.resize(0, 0);
  const WarpFrame f = *make_warp_frame(still, *shape_, neutral_articulation(still));
  EXPECT_TRUE(f.vertices.empty());
  EXPECT_TRUE(make_warp_lattice(f, shape_->vertices).empty());
}

TEST_F(WarpLatticeTest, ManyPointsMatchPointsOneByOne) {
  const WarpFrame f = frame();
  const WarpLattice lattice = make_warp_lattice(f, posed("jawOpen", 0.8f));
  ASSERT_GT(lattice.mouth.open, 0);
  const Vec3f size = f.cell * Vec3f(float(f.nodes[0]), float(f.nodes[1]), float(f.nodes[2]));
  const float side = 1.2f * size.maxCoeff();  // beyond the lattice, too
  const Vec3f origin = f.origin + 0.5f * size - Vec3f::Constant(0.5f * side);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  for (const std::size_t count : {0, 1, 15, 16, 33, 20000}) {
    std::vector<float> at[3];
    std::vector<Vec3f> expected;
    for (std::size_t i = 0; i < count; ++i) {
      Vec3f p(unit(random), unit(random), unit(random));
      if (i % 4 == 3)
        p = (lattice.mouth.low + unit(random) * (lattice.mouth.high - lattice.mouth.low) - origin) / side;
      for (int a = 0; a < 3; ++a) at[a].push_back(p[a]);
      const Vec3f way = displacement_at(lattice, origin + side * p) / side;
      expected.push_back((p + way).cwiseMax(0.f).cwiseMin(1.f));
    }
    displace_points(lattice, origin, side, count, at[0].data(), at[1].data(), at[2].data());
    std::size_t apart = 0;  // on the edge of a lip, where the place jumps
    for (std::size_t i = 0; i < count; ++i)
      apart += (Vec3f(at[0][i], at[1][i], at[2][i]) - expected[i]).norm() > 2e-6f;
    EXPECT_LE(apart, count / 2000) << count;
  }
}

// The person comes from a file, which may say that a vertex lies anywhere.
TEST_F(WarpLatticeTest, AHeadOfImpossibleSizeHasNone) {
  for (const float far : {4000.f, 1e6f, 1e30f}) {
    HeadShape shape = *shape_;
    for (std::size_t v = 0; v < shape.vertices.size(); v += 10) shape.vertices[v].z() = far;
    const auto frame = make_warp_frame(*model_, shape, neutral_articulation(*model_), 0.099f);
    ASSERT_FALSE(frame.ok()) << far;
    EXPECT_FALSE(frame.error().fix.empty());
  }
  EXPECT_FALSE(make_warp_frame(*model_, *shape_, neutral_articulation(*model_), 0.00011f).ok());
}

TEST_F(WarpLatticeTest, AFaceFarOutsideMovesNothing) {
  const WarpFrame f = frame();
  for (const float far : {100.f, 1e12f, -1e30f, std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()}) {
    const std::vector<Vec3f> posed(model_->vertices.size(), Vec3f::Constant(far));
    const WarpLattice lattice = make_warp_lattice(f, posed);
    EXPECT_EQ(displacement_at(lattice, f.rest.front()), Vec3f(Vec3f::Zero())) << far;
  }
}

}  // namespace
}  // namespace likeness
