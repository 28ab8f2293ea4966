// Claims about the built-in head: a sound mesh, a symmetric face of human proportions, lids and lips that
// close, joints that follow the tissue.
#include "core/head/builtin_head.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/head/pose_head.h"
#include "tests/core/head/builtin.h"

namespace likeness {
namespace {

std::vector<Vec3f> posed_with(std::initializer_list<std::pair<const char*, float>> actions) {
  const HeadModel& model = builtin();
  Articulation articulation = neutral_articulation(model);
  for (const auto& [name, amount] : actions) {
    const NamedAction* action = find_action(model, name);
    EXPECT_NE(action, nullptr) << name;
    if (action != nullptr) add_action(articulation, *action, amount);
  }
  return pose_head(model, shape_head(model, Eigen::VectorXf()), articulation);
}

// For each vertex the one at its mirror image, found by position in the template (eyeballs and lips
// included).
std::vector<int> mirror_twins(const HeadModel& model) {
  const auto key = [](const Vec3f& p, float sign) {
    return std::array<long, 3>{std::lround(sign * p.x() * 1e7f), std::lround(p.y() * 1e7f),
                               std::lround(p.z() * 1e7f)};
  };
  std::multimap<std::array<long, 3>, int> at;
  for (int v = 0; v < model.vertex_count(); ++v) at.emplace(key(model.vertices[v], 1), v);
  std::vector<int> twins(model.vertex_count(), -1);
  for (int v = 0; v < model.vertex_count(); ++v) {
    const auto found = at.find(key(model.vertices[v], -1));
    if (found != at.end()) twins[v] = found->second;
  }
  return twins;
}

float distance(const std::array<Vec3f, kLandmarkCount>& points, int a, int b) {
  return (points[a] - points[b]).norm();
}

TEST(BuiltinHead, HasSoundTrianglesInItsNeutralPose) {
  const HeadModel& model = builtin();
  EXPECT_GE(model.vertex_count(), 8000);
  EXPECT_LE(model.vertex_count(), 18000);
  std::map<std::pair<int, int>, int> edges;
  std::vector<bool> used(model.vertex_count(), false);
  for (const Triangle& t : model.triangles) {
    ASSERT_GE(t.minCoeff(), 0);
    ASSERT_LT(t.maxCoeff(), model.vertex_count());
    const Vec3f a = model.vertices[t[0]], b = model.vertices[t[1]], c = model.vertices[t[2]];
    EXPECT_GT((b - a).cross(c - a).norm(), 1e-11f) << t.transpose();  // m^2
    for (int k = 0; k < 3; ++k) {
      used[t[k]] = true;
      ++edges[{t[k], t[(k + 1) % 3]}];
    }
  }
  EXPECT_TRUE(std::all_of(used.begin(), used.end(), [](bool u) { return u; }));
  // Every directed edge at most once: the surface is consistently oriented and nowhere joined threefold.
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, 1) << edge.first << ' ' << edge.second;
}

TEST(BuiltinHead, IsOpenOnlyAtTheBustTheTeethAndNothingElse) {
  const HeadModel& model = builtin();
  std::set<std::pair<int, int>> edges;
  for (const Triangle& t : model.triangles)
    for (int k = 0; k < 3; ++k) edges.emplace(t[k], t[(k + 1) % 3]);
  for (const auto& [a, b] : edges) {
    if (edges.count({b, a}) > 0) continue;
    const HeadPart part = model.parts[a];
    const bool teeth = part == HeadPart::teeth || part == HeadPart::gums_tongue;
    EXPECT_TRUE(teeth || (part == HeadPart::torso && model.vertices[a].y() < -0.3f))
        << "border at vertex " << a << " of part " << int(part) << ": " << model.vertices[a].transpose();
  }
}

TEST(BuiltinHead, EnclosesAVolumeFromOutside) {
  // Outward triangles make the signed volume of a closed part positive: each eyeball is close to its sphere.
  const HeadModel& model = builtin();
  for (const HeadPart part : {HeadPart::left_eyeball, HeadPart::right_eyeball}) {
    double volume = 0;
    for (const Triangle& t : model.triangles)
      if (model.parts[t[0]] == part)
        volume += model.vertices[t[0]].cast<double>().dot(
                      model.vertices[t[1]].cast<double>().cross(model.vertices[t[2]].cast<double>())) /
                  6;
    const double radius = std::cbrt(volume * 3 / (4 * std::numbers::pi));
    EXPECT_NEAR(radius, 0.012, 0.0006);
  }
}

TEST(BuiltinHead, HasWeightsAndRegressorsThatSumToOne) {
  const HeadModel& model = builtin();
  ASSERT_EQ(model.skinning_weights.rows(), model.vertex_count());
  EXPECT_LT((model.skinning_weights.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-5f);
  EXPECT_GE(model.skinning_weights.minCoeff(), 0);
  ASSERT_EQ(model.joint_regressor.cols(), model.vertex_count());
  EXPECT_LT((model.joint_regressor.cast<double>().rowwise().sum().array() - 1).abs().maxCoeff(), 1e-4);
}

TEST(BuiltinHead, JointsFollowTheSizeOfTheHeadAndEyesStayInTheirSockets) {
  const HeadModel& model = builtin();
  const HeadShape neutral = shape_head(model, Eigen::VectorXf());
  for (int c = 0; c < model.identity_count(); ++c) {
    Eigen::VectorXf identity = Eigen::VectorXf::Zero(model.identity_count());
    identity[c] = 2;
    const HeadShape shape = shape_head(model, identity);
    // The eye joint stays the centre of its eyeball: every point of it at one distance.
    float nearest = 1, farthest = 0;
    for (int v = 0; v < model.vertex_count(); ++v)
      if (model.parts[v] == HeadPart::left_eyeball) {
        const float r = (shape.vertices[v] - shape.joints[kLeftEye]).norm();
        nearest = std::min(nearest, r), farthest = std::max(farthest, r);
      }
    EXPECT_LT(farthest - nearest, 1e-4f) << "identity " << c;
    for (int j = 0; j < kJointCount; ++j)
      EXPECT_LT((shape.joints[j] - neutral.joints[j]).norm(), 0.02f) << "identity " << c << " joint " << j;
  }
}

TEST(BuiltinHead, IsSymmetric) {
  const HeadModel& model = builtin();
  const std::vector<int> twins = mirror_twins(model);
  EXPECT_EQ(std::count(twins.begin(), twins.end(), -1), 0);
  for (int c = 0; c < model.identity_count(); ++c) {
    float worst = 0;
    for (int v = 0; v < model.vertex_count(); ++v) {
      const Eigen::Vector3f a = model.identity_basis.block<3, 1>(3 * v, c);
      const Eigen::Vector3f b = model.identity_basis.block<3, 1>(3 * twins[v], c);
      worst = std::max(worst, (a - Vec3f(-b.x(), b.y(), b.z())).norm());
    }
    EXPECT_LT(worst, 1e-4f) << "identity " << c;
  }
}

TEST(BuiltinHead, MirrorsLeftExpressionsToRightOnes) {
  const HeadModel& model = builtin();
  const std::vector<int> twins = mirror_twins(model);
  int pairs = 0;
  for (int c = 0; c < model.expression_count(); ++c) {
    std::string name = model.expression_names[c];
    if (!name.ends_with("_L") && name != "jawLeft" && name != "mouthLeft") continue;
    name.replace(name.size() - (name.ends_with("_L") ? 1 : 4), std::string::npos,
                 name.ends_with("_L") ? "R" : "Right");
    const auto found = std::find(model.expression_names.begin(), model.expression_names.end(), name);
    ASSERT_NE(found, model.expression_names.end()) << name;
    const auto other = found - model.expression_names.begin();
    float worst = 0, largest = 0;
    for (int v = 0; v < model.vertex_count(); ++v) {
      const Eigen::Vector3f a = model.expression_basis.block<3, 1>(3 * v, c);
      const Eigen::Vector3f b = model.expression_basis.block<3, 1>(3 * twins[v], other);
      worst = std::max(worst, (a - Vec3f(-b.x(), b.y(), b.z())).norm());
      largest = std::max(largest, a.norm());
    }
    EXPECT_LT(worst, 2e-4f) << name;
    EXPECT_GT(largest, 0.5e-3f) << name;
    ++pairs;
  }
  EXPECT_GE(pairs, 18);
}

TEST(BuiltinHead, HasHumanProportions) {
  const HeadModel& model = builtin();
  const auto l = landmark_positions(model, model.vertices);
  const HeadShape shape = shape_head(model, Eigen::VectorXf());
  EXPECT_NEAR((shape.joints[kLeftEye] - shape.joints[kRightEye]).norm(), 0.063, 0.003);
  EXPECT_NEAR(distance(l, 36, 45), 0.090, 0.006);    // outer corners of the eyes
  EXPECT_NEAR(distance(l, 39, 42), 0.0355, 0.005);   // inner corners
  EXPECT_NEAR(distance(l, 48, 54), 0.051, 0.005);    // mouth
  EXPECT_NEAR(distance(l, 31, 35), 0.026, 0.006);    // nose
  EXPECT_NEAR(distance(l, 27, 8), 0.115, 0.010);     // nasion to chin
  EXPECT_NEAR(distance(l, 2, 14), 0.139, 0.012);     // cheeks
  EXPECT_NEAR(l[30].z() - l[51].z(), 0.013, 0.006);  // the nose stands out of the lips
  EXPECT_GT(l[0].x() * l[16].x(), -1);
  EXPECT_LT(l[0].x(), 0);  // the subject's right comes first
  EXPECT_LT(l[36].x(), l[39].x());
  EXPECT_GT(l[37].y(), l[41].y());
  EXPECT_GT(l[51].y(), l[57].y());
  for (int i = 0; i < 17; ++i) EXPECT_NEAR(l[i].x(), -l[16 - i].x(), 5e-4f);
}

TEST(BuiltinHead, EmbedsLandmarksInTriangles) {
  const HeadModel& model = builtin();
  for (int i = 0; i < kLandmarkCount; ++i) {
    ASSERT_LT(model.landmark_triangle[i], int(model.triangles.size()));
    EXPECT_NEAR(model.landmark_barycentric[i].sum(), 1, 1e-4);
    EXPECT_GE(model.landmark_barycentric[i].minCoeff(), -1e-4f);
    EXPECT_EQ(model.parts[model.triangles[model.landmark_triangle[i]][0]] == HeadPart::teeth, false);
  }
}

TEST(BuiltinHead, LipsMeetAtRestAndPartWithTheJaw) {
  const HeadModel& model = builtin();
  const auto gap = [&](const std::vector<Vec3f>& vertices) {
    const auto l = landmark_positions(model, vertices);
    float widest = 0;
    for (const auto& [upper, lower] : {std::pair{61, 67}, {62, 66}, {63, 65}})
      widest = std::max(widest, l[upper].y() - l[lower].y());
    return widest;
  };
  EXPECT_LT(gap(posed_with({})), 0.0025f);
  EXPECT_GT(gap(posed_with({{"jawOpen", 1}})), 0.025f);
  EXPECT_GT(gap(posed_with({{"jawOpen", 0.3f}})), 0.007f);
  EXPECT_LT(gap(posed_with({{"jawOpen", 0.5f}, {"mouthClose", 1}})), 0.003f);
}

TEST(BuiltinHead, BlinkClosesTheLidsOverTheEyeball) {
  const HeadModel& model = builtin();
  const auto open = landmark_positions(model, posed_with({}));
  const std::vector<Vec3f> closed = posed_with({{"eyeBlink_L", 1}, {"eyeBlink_R", 1}});
  const auto shut = landmark_positions(model, closed);
  EXPECT_GT(open[43].y() - open[47].y(), 0.007f);
  for (const auto& [upper, lower] : {std::pair{43, 47}, {44, 46}, {38, 40}, {37, 41}})
    EXPECT_LT(std::abs(shut[upper].y() - shut[lower].y()), 0.001f);
  // Rays at the eyeball from the front meet a lid first, except in a slit of less than a millimetre.
  const Vec3f centre = shape_head(model, Eigen::VectorXf()).joints[kLeftEye];
  int seen = 0, rays = 0;
  for (float x = -0.008f; x <= 0.008f; x += 0.001f) {
    for (float y = -0.008f; y <= 0.008f; y += 0.0005f) {
      const float ox = centre.x() + x, oy = centre.y() + y;
      float best = -1;
      bool ball = false;
      for (const Triangle& t : model.triangles) {
        const Vec3f &a = closed[t[0]], &b = closed[t[1]], &c = closed[t[2]];
        if (std::max({a.x(), b.x(), c.x()}) < ox || std::min({a.x(), b.x(), c.x()}) > ox) continue;
        if (std::max({a.y(), b.y(), c.y()}) < oy || std::min({a.y(), b.y(), c.y()}) > oy) continue;
        const float d = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
        if (std::abs(d) < 1e-14f) continue;
        const float v = ((ox - a.x()) * (c.y() - a.y()) - (oy - a.y()) * (c.x() - a.x())) / d;
        const float w = ((b.x() - a.x()) * (oy - a.y()) - (b.y() - a.y()) * (ox - a.x())) / d;
        if (v < 0 || w < 0 || v + w > 1) continue;
        const float z = a.z() + v * (b.z() - a.z()) + w * (c.z() - a.z());
        if (z > best) best = z, ball = model.parts[t[0]] == HeadPart::left_eyeball;
      }
      ++rays, seen += ball;
    }
  }
  EXPECT_GT(rays, 400);
  EXPECT_LE(seen, 3);
}

TEST(BuiltinHead, LidsNeverCutTheEyeball) {
  const HeadModel& model = builtin();
  const Vec3f centre = shape_head(model, Eigen::VectorXf()).joints[kLeftEye];
  for (const auto& actions : {std::initializer_list<std::pair<const char*, float>>{},
                              {{"eyeBlink_L", 1.0f}},
                              {{"eyeWide_L", 1.0f}},
                              {{"eyeSquint_L", 1.0f}},
                              {{"eyeLookDown_L", 1.0f}},
                              {{"browDown_L", 1.0f}},
                              {{"cheekSquint_L", 1.0f}}}) {
    const std::vector<Vec3f> posed = posed_with(actions);
    for (int v = 0; v < model.vertex_count(); ++v) {
      const HeadPart part = model.parts[v];
      if (part != HeadPart::face && part != HeadPart::left_eye_socket) continue;
      EXPECT_GT((posed[v] - centre).norm(), 0.0120f)
          << (actions.size() ? actions.begin()->first : "rest") << ' ' << v;
    }
  }
}

TEST(BuiltinHead, LidsKeepToTheEyeballInEveryIdentity) {
  const HeadModel& model = builtin();
  for (int c = 0; c < model.identity_count(); ++c) {
    for (const float amount : {-2.0f, 2.0f}) {
      Eigen::VectorXf identity = Eigen::VectorXf::Zero(model.identity_count());
      identity[c] = amount;
      const HeadShape shape = shape_head(model, identity);
      float nearest = 1, radius = 0;
      for (int v = 0; v < model.vertex_count(); ++v) {
        const float r = (shape.vertices[v] - shape.joints[kLeftEye]).norm();
        if (model.parts[v] == HeadPart::left_eyeball) radius = std::max(radius, r);
        if (model.parts[v] == HeadPart::face || model.parts[v] == HeadPart::left_eye_socket)
          nearest = std::min(nearest, r);
      }
      EXPECT_GT(nearest, radius - 0.0001f) << "identity " << c << " at " << amount;
    }
  }
}

TEST(BuiltinHead, KnowsTheUsualActionsByName) {
  const HeadModel& model = builtin();
  EXPECT_EQ(model.name, "built-in");
  for (const char* name :
       {"jawOpen",        "browDown_L",       "browInnerUp_R",   "browOuterUp_L",   "cheekPuff_L",
        "cheekSquint_R",  "eyeBlink_L",       "eyeLookDown_L",   "eyeLookIn_R",     "eyeLookOut_L",
        "eyeLookUp_R",    "eyeSquint_L",      "eyeWide_R",       "jawForward",      "jawLeft",
        "jawRight",       "mouthClose",       "mouthDimple_L",   "mouthFrown_R",    "mouthFunnel",
        "mouthLeft",      "mouthLowerDown_L", "mouthPress_R",    "mouthPucker",     "mouthRight",
        "mouthRollLower", "mouthRollUpper",   "mouthShrugLower", "mouthShrugUpper", "mouthSmile_L",
        "mouthStretch_R", "mouthUpperUp_L",   "noseSneer_R"})
    EXPECT_NE(find_action(model, name), nullptr) << name;
  EXPECT_NEAR(find_action(model, "jawOpen")->jaw.x(), 25 * std::numbers::pi / 180, 1e-3);
  EXPECT_GE(model.identity_count(), 20);
  EXPECT_EQ(model.expression_names.size(), std::size_t(model.expression_count()));
}

TEST(BuiltinHead, MovesTheCornersOfTheMouthTheWayTheirNamesSay) {
  const HeadModel& model = builtin();
  const auto rest = landmark_positions(model, posed_with({}));
  const auto smile = landmark_positions(model, posed_with({{"mouthSmile_L", 1}}));
  EXPECT_GT(smile[54].y() - rest[54].y(), 0.003f);
  EXPECT_LT((smile[48] - rest[48]).norm(), 0.0005f);  // one side only
  const auto frown = landmark_positions(model, posed_with({{"mouthFrown_R", 1}}));
  EXPECT_LT(frown[48].y() - rest[48].y(), -0.003f);
  const auto pucker = landmark_positions(model, posed_with({{"mouthPucker", 1}}));
  EXPECT_LT(distance(pucker, 48, 54), 0.8f * distance(rest, 48, 54));
  const auto brow = landmark_positions(model, posed_with({{"browInnerUp_L", 1}}));
  EXPECT_GT(brow[22].y() - rest[22].y(), 0.003f);
  const auto down = landmark_positions(model, posed_with({{"jawOpen", 1}}));
  EXPECT_LT(down[8].y() - rest[8].y(), -0.02f);
  EXPECT_LT((down[30] - rest[30]).norm(), 0.001f);
}

TEST(BuiltinHead, IsTheSameEveryTime) {
  EXPECT_EQ(make_builtin_head().hash, builtin().hash);
  EXPECT_EQ(builtin().hash.size(), 32u);
}

TEST(BuiltinHead, LaysEveryVertexInTheTextureSquare) {
  const HeadModel& model = builtin();
  ASSERT_EQ(model.uvs.size(), model.vertices.size());
  for (const Vec2f& uv : model.uvs) {
    EXPECT_GE(uv.minCoeff(), 0);
    EXPECT_LE(uv.maxCoeff(), 1);
  }
  // Each separate piece has its own corner outside the skin's disc.
  for (int v = 0; v < model.vertex_count(); ++v) {
    const HeadPart part = model.parts[v];
    const bool eyeball = part == HeadPart::left_eyeball || part == HeadPart::right_eyeball;
    const bool separate = eyeball || part == HeadPart::teeth || part == HeadPart::gums_tongue;
    if (separate) {
      EXPECT_GT((model.uvs[v] - Vec2f(0.5f, 0.5f)).norm(), 0.49f) << v;
    }
    const Vec2f q(std::abs(model.uvs[v].x() - 0.5f) + 0.5f, model.uvs[v].y());
    const bool in_eye_corner = q.x() > 0.86f && q.y() > 0.86f;
    EXPECT_EQ(in_eye_corner, eyeball) << v;
  }
}

}  // namespace
}  // namespace likeness
