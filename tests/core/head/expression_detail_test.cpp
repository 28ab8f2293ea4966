// Claims about detail by expression: what varies with the expression is learnt and predicted for unseen
// faces, the rest is left alone, and heights move vertices along their normals.
#include "core/head/expression_detail.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/head/pose_head.h"
#include "tests/core/head/builtin.h"

namespace likeness {
namespace {

// Two creases and a constant: what a person's maps are made of here.
struct Person {
  Eigen::VectorXf constant, smile, jaw;  // (V) m

  Person() {
    const auto count = Eigen::Index(builtin().vertex_count());
    constant = smile = jaw = Eigen::VectorXf::Zero(count);
    for (Eigen::Index v = 0; v < count; ++v) {
      if (builtin().parts[std::size_t(v)] != HeadPart::face) continue;
      constant[v] = 0.0005f * float(std::sin(0.3 * double(v)));
      (v % 3 == 0 ? smile : jaw)[v] = 0.001f * float(std::cos(0.1 * double(v)));
    }
  }
  Eigen::VectorXf height(const Articulation& a) const {
    return constant + (a.expression[3] - a.expression[4]) * smile + 4 * a.jaw.x() * jaw;
  }
};

// Motion like that of faces: smooth, all expressions at once.
Articulation performed(double t, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(0, 6.283);
  Articulation a = neutral_articulation(builtin());
  for (float& value : a.expression) {
    const double phase = any(random), pace = 0.05 + 0.02 * any(random);
    value = float(0.5 + 0.5 * std::sin(pace * t + phase));
  }
  a.jaw.x() = float(0.1 + 0.1 * std::sin(0.17 * t));
  return a;
}

std::vector<DetailFrame> frames_of(const Person& person, int count) {
  std::vector<DetailFrame> frames;
  for (int i = 0; i < count; ++i) {
    const Articulation a = performed(i);
    frames.push_back({i, person.height(a), a});
  }
  return frames;
}

// Of the model's vertices, as a detail makes it.
Eigen::VectorXf made(const ExpressionDetail& detail, const Eigen::VectorXf& scores) {
  Eigen::VectorXf all = Eigen::VectorXf::Zero(builtin().vertex_count());
  const Eigen::VectorXf height = detail.mean + detail.basis * scores;
  for (std::size_t k = 0; k < detail.vertices.size(); ++k) all[detail.vertices[k]] = height[Eigen::Index(k)];
  return all;
}

TEST(ExpressionDetail, PredictsTheCreasesOfUnseenFaces) {
  const Person person;
  const LearntDetail learnt = learn_detail(frames_of(person, 240));
  EXPECT_EQ(learnt.detail.components(), 2);
  EXPECT_GT(learnt.kept, 0.999);
  EXPECT_GT(learnt.explained, 0.95);
  ASSERT_TRUE(is_consistent(learnt.detail, builtin().vertex_count(), builtin().expression_count()));
  double error = 0, varied = 0;
  for (int i = 0; i < 40; ++i) {
    const Articulation a = performed(i + 0.5, 1);
    const Eigen::VectorXf truth = person.height(a);
    error += double((made(learnt.detail, detail_scores(learnt.detail, a)) - truth).squaredNorm());
    varied += double((made(learnt.detail, Eigen::VectorXf::Zero(2)) - truth).squaredNorm());
  }
  EXPECT_LT(error, 0.02 * varied);
}

TEST(ExpressionDetail, FramesOwnScoresReproduceItsMap) {
  const Person person;
  const std::vector<DetailFrame> frames = frames_of(person, 60);
  const LearntDetail learnt = learn_detail(frames);
  for (std::size_t i = 0; i < frames.size(); i += 7)
    EXPECT_LT((made(learnt.detail, learnt.scores.row(Eigen::Index(i)).transpose()) - frames[i].height)
                  .cwiseAbs()
                  .maxCoeff(),
              2.5e-5f);
}

TEST(ExpressionDetail, MapsUnrelatedToTheExpressionGiveTheirMean) {
  const Person person;
  std::vector<DetailFrame> frames = frames_of(person, 120);
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  for (DetailFrame& f : frames) f.height = person.constant + normal(random) * person.smile;
  const LearntDetail learnt = learn_detail(frames);
  EXPECT_LT(learnt.explained, 0.1);
  const Eigen::VectorXf scores = detail_scores(learnt.detail, performed(7.5));
  EXPECT_LT(scores.cwiseAbs().maxCoeff(), 0.5f);  // of deviations
}

TEST(ExpressionDetail, NeverGoesBeyondWhatTheMapsShowed) {
  const LearntDetail learnt = learn_detail(frames_of(Person(), 100));
  Articulation far = performed(3);
  far.expression.setConstant(0), far.expression[3] = 50;
  const Eigen::VectorXf scores = detail_scores(learnt.detail, far);
  EXPECT_TRUE((scores.array() <= learnt.detail.high.array()).all());
  EXPECT_TRUE((scores.array() >= learnt.detail.low.array()).all());
}

TEST(ExpressionDetail, FlatMapsChangeNothing) {
  std::vector<DetailFrame> frames = frames_of(Person(), 20);
  for (DetailFrame& f : frames) f.height.setZero();
  const LearntDetail learnt = learn_detail(frames);
  EXPECT_TRUE(learnt.detail.empty());
  const HeadShape shape = shape_head(builtin(), PersonShape{});
  EXPECT_EQ(pose_detailed_head(builtin(), shape, performed(2), learnt.detail),
            pose_head(builtin(), shape, performed(2)));
}

TEST(ExpressionDetail, HeightsMoveVerticesAlongTheirNormals) {
  const Person person;
  const LearntDetail learnt = learn_detail(frames_of(person, 100));
  const HeadShape shape = shape_head(builtin(), PersonShape{});
  const Articulation a = performed(11);
  const std::vector<Vec3f> plain = pose_head(builtin(), shape, a),
                           detailed = pose_detailed_head(builtin(), shape, a, learnt.detail),
                           normals = vertex_normals(plain, builtin().triangles);
  const Eigen::VectorXf truth = person.height(a);
  double error = 0, height = 0;
  for (std::size_t v = 0; v < plain.size(); ++v) {
    const Vec3f moved = detailed[v] - plain[v];
    EXPECT_LT((moved - moved.dot(normals[v]) * normals[v]).norm(), 1e-6f);
    if (builtin().parts[v] != HeadPart::face) {
      EXPECT_EQ(moved.norm(), 0) << v;
    }
    error += std::pow(double(moved.dot(normals[v]) - truth[Eigen::Index(v)]), 2);
    height += std::pow(double(truth[Eigen::Index(v)]), 2);
  }
  EXPECT_LT(error, 0.02 * height);
}

TEST(ExpressionDetail, DetectsInconsistentDetail) {
  const LearntDetail learnt = learn_detail(frames_of(Person(), 30));
  const int v = builtin().vertex_count(), e = builtin().expression_count();
  ASSERT_TRUE(is_consistent(learnt.detail, v, e));
  EXPECT_FALSE(is_consistent(learnt.detail, v, e + 1));
  EXPECT_FALSE(is_consistent(learnt.detail, learnt.detail.vertices.back(), e));
  ExpressionDetail broken = learnt.detail;
  broken.basis(0, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(is_consistent(broken, v, e));
  broken = learnt.detail;
  broken.mean.conservativeResize(broken.mean.size() - 1);
  EXPECT_FALSE(is_consistent(broken, v, e));
}

}  // namespace
}  // namespace likeness
