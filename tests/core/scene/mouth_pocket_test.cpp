// The mouth's inside in canonical space, on the built-in head.
#include "core/scene/mouth_pocket.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/head/builtin_head.h"
#include "core/head/head_model.h"
#include "core/scene/warp_lattice.h"

namespace likeness {
namespace {

class MouthPocketTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    model_ = new HeadModel(make_builtin_head());
    shape_ = new HeadShape(shape_head(*model_, PersonShape{}));
    frame_ = new WarpFrame(*make_warp_frame(*model_, *shape_, neutral_articulation(*model_)));
  }
  static void TearDownTestSuite() { delete model_, delete shape_, delete frame_; }

  static std::vector<Vec3f> posed(const std::string& name, float amount) {
    Articulation a = neutral_articulation(*model_);
    add_action(a, *find_action(*model_, name), amount);
    return pose_head(*model_, *shape_, a);
  }
  static Vec3f canonical(const WarpLattice& lattice, const Vec3f& p) {
    return p + displacement_at(lattice, p);
  }
  // The same deformation without the pocket.
  static WarpLattice folded(WarpLattice lattice) {
    lattice.mouth = {};
    return lattice;
  }
  // On the midline between the lips: from the lower (0) to the upper (1), `depth` m behind them.
  static Vec3f between(const std::vector<Vec3f>& face, float share, float depth) {
    const auto l = landmark_positions(*model_, face);
    return l[66] + share * (l[62] - l[66]) - Vec3f(0, 0, depth);
  }

  static HeadModel* model_;
  static HeadShape* shape_;
  static WarpFrame* frame_;
};
HeadModel* MouthPocketTest::model_ = nullptr;
HeadShape* MouthPocketTest::shape_ = nullptr;
WarpFrame* MouthPocketTest::frame_ = nullptr;

TEST_F(MouthPocketTest, ClosedLipsAreMovedAsWithoutAPocket) {
  for (const std::string name : {"mouthPucker", "mouthSmile_L", "browInnerUp_L", "mouthFrown_R"}) {
    const std::vector<Vec3f> face = posed(name, 1);
    const WarpLattice lattice = make_warp_lattice(*frame_, face), before = folded(lattice);
    EXPECT_EQ(lattice.mouth.open, 0) << name;
    for (const Vec3f& v : face) ASSERT_EQ(displacement_at(lattice, v), displacement_at(before, v)) << name;
  }
}

TEST_F(MouthPocketTest, TheOutsideOfAnOpenMouthIsMovedAsWithoutAPocket) {
  const auto rest = landmark_positions(*model_, shape_->vertices);
  const std::vector<Vec3f> face = posed("jawOpen", 0.7f);
  const WarpLattice lattice = make_warp_lattice(*frame_, face), before = folded(lattice);
  ASSERT_GT(lattice.mouth.open, 0.01f);
  int skin = 0, taken = 0;
  for (std::size_t v = 0; v < face.size(); ++v) {
    // All skin but the lips' inner side, which opens with them.
    const Vec3f& at = shape_->vertices[v];
    if (model_->parts[v] != HeadPart::face || (at.z() < rest[62].z() - 0.002f && std::abs(at.x()) < 0.02f &&
                                               std::abs(at.y() - rest[62].y()) < 0.02f))
      continue;
    ++skin;
    if (in_gap(lattice.mouth, face[v])) {
      ++taken;
      EXPECT_LT(std::abs(at.y() - rest[62].y()), 0.0015f);  // on the very line in which the lips meet
      continue;
    }
    ASSERT_EQ(displacement_at(lattice, face[v]), displacement_at(before, face[v]));
  }
  EXPECT_GT(skin, 4000);
  EXPECT_LT(taken, 12);
}

TEST_F(MouthPocketTest, PointsOfTheGapStayApart) {
  for (const float amount : {0.25f, 0.6f, 1.f}) {
    const std::vector<Vec3f> face = posed("jawOpen", amount);
    const WarpLattice lattice = make_warp_lattice(*frame_, face), before = folded(lattice);
    float folds = 1;
    for (const float depth : {0.f, 0.01f, 0.02f, 0.03f, 0.05f}) {
      int inside = 0;
      for (int i = 0; i < 40; ++i) {
        const Vec3f a = between(face, float(i) / 40, depth), b = between(face, float(i + 1) / 40, depth);
        folds = std::min(folds, (canonical(before, a) - canonical(before, b)).norm() / (a - b).norm());
        if (!in_gap(lattice.mouth, a) || !in_gap(lattice.mouth, b)) continue;
        ++inside;
        // Wider openings are pressed together in proportion, no further.
        EXPECT_GT((canonical(lattice, a) - canonical(lattice, b)).norm(), 0.4f * (a - b).norm());
        EXPECT_LT((canonical(lattice, a) - canonical(lattice, b)).norm(), 2.5f * (a - b).norm());
      }
      EXPECT_GE(inside, 30) << "opened by " << amount << ", " << depth << " m deep";
    }
    EXPECT_LT(folds, 0.2f);  // without the pocket they fall together
  }
}

TEST_F(MouthPocketTest, TeethKeepTheirPlaceHoweverWideTheMouth) {
  std::vector<Vec3f> first(std::size_t(model_->vertex_count()), Vec3f::Zero());
  std::vector<bool> seen(first.size());
  int again = 0;
  for (const float amount : {0.25f, 0.4f, 0.6f, 0.8f, 1.f}) {
    const std::vector<Vec3f> face = posed("jawOpen", amount);
    const WarpLattice lattice = make_warp_lattice(*frame_, face);
    for (std::size_t v = 0; v < face.size(); ++v) {
      if (model_->parts[v] != HeadPart::teeth || !in_gap(lattice.mouth, face[v])) continue;
      const Vec3f place = canonical(lattice, face[v]);
      if (seen[v]) {
        EXPECT_LT((place - first[v]).norm(), 2e-4f);
        ++again;
      }
      first[v] = place, seen[v] = true;
    }
  }
  EXPECT_GT(again, 500);
}

TEST_F(MouthPocketTest, ThePocketLiesWhereARestingHeadIsNotSeen) {
  const MouthGap gap = make_mouth_gap(frame_->mouth, posed("jawOpen", 1));
  float nearest = 1;
  int inside = 0;
  for (float x = gap.low.x(); x < gap.high.x(); x += 0.004f)
    for (float y = gap.low.y(); y < gap.high.y(); y += 0.004f)
      for (float z = gap.low.z(); z < gap.high.z(); z += 0.004f) {
        const Vec3f p(x, y, z);
        if (!in_gap(gap, p)) continue;
        ++inside;
        const Vec3f there = p + way_to_pocket(gap, p);
        for (const Vec3f& v : shape_->vertices) nearest = std::min(nearest, (v - there).norm());
      }
  EXPECT_GT(inside, 500);
  EXPECT_GT(nearest, 0.015f);
}

TEST_F(MouthPocketTest, TheGapOpensContinuously) {
  float before = 0;
  Vec3f place = Vec3f::Zero();
  for (int i = 0; i <= 100; ++i) {
    const std::vector<Vec3f> face = posed("jawOpen", 0.01f * float(i));
    const MouthGap gap = make_mouth_gap(frame_->mouth, face);
    EXPECT_LT(std::abs(gap.open - before), 0.0006f) << i;  // a hundredth of the whole, and a little
    before = gap.open;
    // What hangs between the lips in one proportion moves on without a jump.
    const Vec3f p = between(face, 0.5f, 0.002f);
    if (!in_gap(gap, p)) continue;
    const Vec3f there = p + way_to_pocket(gap, p);
    if (place != Vec3f::Zero()) {
      EXPECT_LT((there - place).norm(), 0.002f) << i;
    }
    place = there;
  }
  EXPECT_GT(before, 0.015f);
}

TEST_F(MouthPocketTest, ModelsWithoutTeethHaveAPocketToo) {
  HeadModel bare = *model_;
  bare.parts.assign(bare.vertices.size(), HeadPart::unknown);
  const WarpFrame frame = *make_warp_frame(bare, *shape_, neutral_articulation(bare));
  const std::vector<Vec3f> face = posed("jawOpen", 0.6f);
  const WarpLattice lattice = make_warp_lattice(frame, face);
  EXPECT_LT((frame.mouth.bite - frame_->mouth.bite).cwiseAbs().y(), 0.004f);
  const Vec3f a = between(face, 0.3f, 0.01f), b = between(face, 0.7f, 0.01f);
  ASSERT_TRUE(in_gap(lattice.mouth, a) && in_gap(lattice.mouth, b));
  EXPECT_GT((canonical(lattice, a) - canonical(lattice, b)).norm(), 0.5f * (a - b).norm());
}

}  // namespace
}  // namespace likeness
