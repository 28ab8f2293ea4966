// Claims about what the demo's people have beyond the head model.
#include "core/synth/personal_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/head/builtin_head.h"

namespace likeness {
namespace {

const HeadModel& model() {
  static const HeadModel instance = make_builtin_head();
  return instance;
}

PersonShape shape_of(int number) { return make_personal_shape(model(), demo_person(number), number, 0); }

TEST(PersonalShape, NoIdentityExplainsAFaceBetterThanTwoMillimetres) {
  for (int number = 0; number < 6; ++number) {
    const HeadShape shape = shape_head(model(), shape_of(number));
    EXPECT_GE(off_span_rms(model(), shape.vertices), 0.002) << number;
    const HeadShape spanned = shape_head(model(), shape_of(number).identity);
    EXPECT_LT(off_span_rms(model(), spanned.vertices), 0.00005) << number;
  }
}

// No vertex goes far, neighbours go together, and the two sides of the face differ.
TEST(PersonalShape, OffsetsAreSmoothBoundedAndAsymmetric) {
  for (int number = 0; number < 6; ++number) {
    const PersonShape person = shape_of(number);
    float most = 0, steepest = 0;
    for (const Triangle& t : model().triangles) {
      for (int k = 0; k < 3; ++k) {
        const std::size_t a = std::size_t(t[k]), b = std::size_t(t[(k + 1) % 3]);
        most = std::max(most, person.offsets[a].norm());
        if (model().parts[a] != HeadPart::face || model().parts[b] != HeadPart::face) continue;
        const float edge = (model().vertices[a] - model().vertices[b]).norm();
        if (edge > 0.001f)
          steepest = std::max(steepest, (person.offsets[a] - person.offsets[b]).norm() / edge);
      }
    }
    EXPECT_LT(most, 0.012f) << number;
    EXPECT_LT(steepest, 0.9f) << number;
    const HeadShape shape = shape_head(model(), person);
    const auto l = landmark_positions(model(), shape.vertices);
    float crooked = 0;
    for (const auto& [left, right] : {std::pair{14, 2}, {24, 19}, {35, 31}, {54, 48}, {11, 5}}) {
      Vec3f mirrored = l[std::size_t(right)];
      mirrored.x() = -mirrored.x();
      crooked = std::max(crooked, (l[std::size_t(left)] - mirrored).norm());
    }
    EXPECT_GT(crooked, 0.001f) << number;
  }
}

TEST(PersonalShape, LidsAndTeethKeepTheirPlace) {
  for (int number = 0; number < 6; ++number) {
    const PersonShape person = shape_of(number);
    const HeadShape shape = shape_head(model(), person);
    for (const bool left : {true, false}) {
      const HeadPart ball = left ? HeadPart::left_eyeball : HeadPart::right_eyeball;
      const HeadPart socket = left ? HeadPart::left_eye_socket : HeadPart::right_eye_socket;
      Vec3f with = Vec3f::Zero();
      for (int v = 0; v < model().vertex_count(); ++v)
        if (model().parts[std::size_t(v)] == ball) with = person.offsets[std::size_t(v)];
      for (int v = 0; v < model().vertex_count(); ++v) {
        const HeadPart part = model().parts[std::size_t(v)];
        if (part == ball) {
          EXPECT_LT((person.offsets[std::size_t(v)] - with).norm(), 1e-6f);
        } else if (part == socket) {
          EXPECT_LT((person.offsets[std::size_t(v)] - with).norm(), 0.0008f) << number << ' ' << v;
        }
      }
    }
    const auto l = landmark_positions(model(), shape.vertices);
    EXPECT_GT(l[62].y() - l[66].y(), -0.0005f) << number;  // the lips do not cross
  }
}

TEST(PersonalPlay, IsStillAtRestAndComesWithTheActionsPerformed) {
  const PersonShape person = shape_of(0);
  const HeadShape shape = shape_head(model(), person);
  const PersonalPlay play(model(), shape, demo_person(0));
  Articulation a = neutral_articulation(model());
  const auto rest = play.pose(a);
  for (std::size_t v = 0; v < rest.size(); ++v) ASSERT_EQ(rest[v], shape.vertices[v]);
  for (const char* side : {"mouthSmile_L", "mouthSmile_R"}) add_action(a, *find_action(model(), side), 1);
  const auto smiling = play.pose(a), spanned = pose_head(model(), shape, a);
  float most = 0;
  for (std::size_t v = 0; v < rest.size(); ++v) most = std::max(most, (smiling[v] - spanned[v]).norm());
  EXPECT_GT(most, 0.002f);
  EXPECT_LT(most, 0.008f);
}

// Of each action's displacement at least half (RMS) remains when the model's expressions, the jaw included,
// have done what they can.
TEST(PersonalPlay, LiesOutsideTheSpanOfTheExpressions) {
  const HeadModel& m = model();
  Eigen::MatrixXd span(3 * m.vertex_count(), m.expression_count() + 3);
  span.leftCols(m.expression_count()) = m.expression_basis.cast<double>();
  for (int axis = 0; axis < 3; ++axis) {
    Articulation a = neutral_articulation(m);
    a.jaw[axis] = 0.02f;
    const HeadShape shape = shape_head(m, Eigen::VectorXf());
    const auto turned = pose_head(m, shape, a);
    for (int v = 0; v < m.vertex_count(); ++v)
      span.block<3, 1>(3 * v, m.expression_count() + axis) =
          ((turned[std::size_t(v)] - shape.vertices[std::size_t(v)]) / 0.02f).cast<double>();
  }
  const Eigen::MatrixXd gram = span.transpose() * span;
  const Eigen::LDLT<Eigen::MatrixXd> solver(gram + 1e-9 * gram.trace() / double(gram.rows()) *
                                                       Eigen::MatrixXd::Identity(gram.rows(), gram.cols()));
  for (int number = 0; number < 6; ++number) {
    const HeadShape shape = shape_head(m, shape_of(number));
    const PersonalPlay play(m, shape, demo_person(number));
    for (const PersonalAction& action : play.actions()) {
      Eigen::VectorXd wanted(3 * m.vertex_count());
      for (int v = 0; v < m.vertex_count(); ++v)
        wanted.segment<3>(3 * v) = action.field[std::size_t(v)].cast<double>();
      const Eigen::VectorXd left = wanted - span * solver.solve(span.transpose() * wanted);
      EXPECT_GT(left.norm(), 0.5 * wanted.norm()) << number << ' ' << action.name;
    }
  }
}

}  // namespace
}  // namespace likeness
