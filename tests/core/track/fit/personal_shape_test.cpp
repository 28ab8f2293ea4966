// Claims about fitting a person's own surface.
#include "core/track/fit/personal_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "core/head/pose_head.h"
#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

using Offsets = std::vector<Vec3f>;

const std::vector<Vec3f>& rest() {
  static const std::vector<Vec3f> vertices = shape_head(test_head(), test_identity()).vertices;
  return vertices;
}

const std::vector<int>& face_skin() {
  static const std::vector<int> vertices = [] {
    const HeadRegions regions = head_regions(test_head());
    std::vector<std::uint8_t> flags(regions.face.size());
    for (std::size_t t = 0; t < flags.size(); ++t) flags[t] = regions.face[t] && regions.skin[t];
    return region_vertices(test_head(), flags);
  }();
  return vertices;
}

// Where the skin bends freely: lids and lips keep their form.
const std::vector<int>& free_skin() {
  static const std::vector<int> vertices = [] {
    const HeadShape shape = shape_head(test_head(), test_identity());
    const auto landmarks = landmark_positions(test_head(), rest());
    std::vector<int> chosen;
    for (const int v : face_skin()) {
      const Vec3f& p = rest()[v];
      if ((p - shape.joints[kLeftEye]).norm() > 0.026f && (p - shape.joints[kRightEye]).norm() > 0.026f &&
          lip_distance(landmarks, p) > 0.014f)
        chosen.push_back(v);
    }
    return chosen;
  }();
  return vertices;
}

// A person whom no identity makes: waves of 3 mm over the face, along the normals.
Offsets wavy_person() {
  const auto normals = vertex_normals(rest(), test_head().triangles);
  Offsets offsets(rest().size(), Vec3f::Zero());
  for (const int v : face_skin()) {
    const Vec3f& p = rest()[v];
    offsets[v] = 0.003f * std::sin(140 * p.x() + 0.4f) * std::cos(110 * p.y()) * normals[v];
  }
  return offsets;
}

ShapePoint point_at(const Vec3f& place) {
  return {place.cast<double>(), 0.0003 * 0.0003 * Mat3d::Identity()};
}

std::vector<ShapePoint> points_on(const Offsets& offsets) {
  std::vector<ShapePoint> points;
  for (const int v : face_skin()) points.push_back(point_at(rest()[v] + offsets[v]));
  return points;
}

// rms over the free skin of what is wrong along the normals, m.
double error_of(const Offsets& found, const Offsets& truth) {
  const auto normals = vertex_normals(rest(), test_head().triangles);
  double sum = 0;
  for (const int v : free_skin())
    sum += std::pow(normals[v].dot((found.empty() ? Vec3f::Zero() : found[v]) - truth[v]), 2);
  return std::sqrt(sum / double(free_skin().size()));
}

// The least such error of any identity, without prior.
double best_identity_error(const Offsets& truth) {
  const HeadModel& model = test_head();
  const auto normals = vertex_normals(rest(), model.triangles);
  const auto rows = Eigen::Index(free_skin().size());
  Eigen::MatrixXd basis(rows, model.identity_count());
  Eigen::VectorXd wanted(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const int v = free_skin()[std::size_t(i)];
    basis.row(i) = (normals[v].transpose() * model.identity_basis.middleRows(3 * v, 3)).cast<double>();
    wanted[i] = normals[v].dot(truth[v]);
  }
  const Eigen::MatrixXd gram =
      basis.transpose() * basis +
      1e-12 * Eigen::MatrixXd::Identity(model.identity_count(), model.identity_count());
  return std::sqrt((wanted - basis * gram.ldlt().solve(basis.transpose() * wanted)).squaredNorm() /
                   double(rows));
}

Offsets fitted(std::span<const ShapePoint> points, std::span<const ShapeFrame> frames = {},
               const PersonalShapeOptions& options = {}) {
  auto offsets = fit_personal_shape(test_head(), test_identity(), points, frames, options, {}, {});
  EXPECT_TRUE(offsets.ok());
  return offsets ? *offsets : Offsets{};
}

// Points without the poses' errors, which bend those of a real clip.
PersonalShapeOptions sure_points() {
  PersonalShapeOptions options;
  options.point_m = 0.0004;
  options.rounds = 2;
  return options;
}

TEST(PersonalShape, PointsRecoverASurfaceThatNoIdentityReaches) {
  const Offsets truth = wavy_person();
  const double identity = best_identity_error(truth),
               found = error_of(fitted(points_on(truth), {}, sure_points()), truth);
  EXPECT_GT(identity, 0.0006);
  EXPECT_LT(found, 0.4 * identity);
}

TEST(PersonalShape, PointsOffTheSkinDoNotMoveIt) {
  const Offsets truth = wavy_person();
  std::vector<ShapePoint> points = points_on(truth);
  const Offsets clean = fitted(points, {}, sure_points());
  std::mt19937 random(3);
  std::uniform_real_distribution<float> away(0.005f, 0.02f);
  const auto normals = vertex_normals(rest(), test_head().triangles);
  const std::size_t count = points.size() / 6;  // a fringe over the forehead, and strays anywhere
  for (std::size_t i = 0; i < count; ++i) {
    const int v = face_skin()[(i * 7919) % face_skin().size()];
    points.push_back(point_at(rest()[v] + away(random) * normals[v]));
  }
  EXPECT_LT(error_of(fitted(points, {}, sure_points()), clean), 0.0003);
}

TEST(PersonalShape, OnlyPointsStartedOnTheSkinCount) {
  std::vector<DenseFrame> frames(2);
  std::vector<HeadPoint> points(2);
  for (int f = 0; f < 2; ++f) {
    frames[f].intrinsics = {512, 512, 1000, 1000, 256, 256, 0, 0, 0, 0};
    frames[f].cam_from_head = facing_pose(0.4 * f, 0, Vec3d(0, 0, 0.6));
    for (HeadPoint& p : points) {
      p.track.point = Vec3d(0.02, 0.03, 0.08);
      p.track.seen.push_back({f, (frames[f].cam_from_head * p.track.point).hnormalized()});
    }
  }
  points[0].on_skin = true;
  const auto skin = skin_points(points, frames);
  ASSERT_EQ(skin.size(), 1u);
  // Along the mean line of sight two views know less than across it.
  const Vec3d depth = (frames[0].cam_from_head.linear().row(2) + frames[1].cam_from_head.linear().row(2))
                          .transpose()
                          .normalized();
  EXPECT_GT(depth.dot(skin[0].covariance * depth), 4 * skin[0].covariance(1, 1));
  EXPECT_LT(std::sqrt(skin[0].covariance(1, 1)), 0.0005);
}

// Pictures of a person broader about the jaw: bright on dark.
struct Seen {
  std::vector<Image8> pictures;
  std::vector<ShapeFrame> frames;
  Offsets truth;
};
Seen broad_person() {
  Seen seen;
  seen.truth.assign(rest().size(), Vec3f::Zero());
  for (const int v : face_skin()) {
    const Vec3f& p = rest()[v];
    const float side = p.x() / 0.055f;
    seen.truth[v] = Vec3f(0.004f * std::clamp(side, -1.0f, 1.0f), 0, 0);
  }
  std::vector<Vec3f> vertices = rest();
  for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v] += seen.truth[v];
  const Intrinsics k{384, 384, 900, 900, 192, 192, 0, 0, 0, 0};
  for (int i = 0; i < 8; ++i) {
    ShapeFrame frame;
    frame.intrinsics = k;
    frame.state.cam_from_head = facing_pose(0.22 * (i - 3.5), 0.05 * (i % 3 - 1), Vec3d(0, 0, 0.75));
    frame.state.expression = Eigen::VectorXd::Zero(test_head().expression_count());
    seen.pictures.push_back(silhouette(vertices, test_head().triangles, k, frame.state.cam_from_head));
    seen.frames.push_back(frame);
  }
  for (std::size_t i = 0; i < seen.frames.size(); ++i) seen.frames[i].grey = &seen.pictures[i];
  return seen;
}

TEST(PersonalShape, OutlinesBroadenTheJaw) {
  const Seen seen = broad_person();
  const Offsets found = fitted({}, seen.frames);
  ASSERT_FALSE(found.empty());
  const auto landmarks = [](const Offsets& o) {
    std::vector<Vec3f> moved = rest();
    for (std::size_t v = 0; v < moved.size(); ++v) moved[v] += o[v];
    return landmark_positions(test_head(), moved);
  };
  const auto was = landmarks(Offsets(rest().size(), Vec3f::Zero())), is = landmarks(found),
             should = landmarks(seen.truth);
  for (const auto& [right, left] : {std::pair(3, 13), {4, 12}}) {
    const float before = was[left].x() - was[right].x(), after = is[left].x() - is[right].x(),
                wanted = should[left].x() - should[right].x();
    EXPECT_LT(std::abs(after - wanted), 0.4f * (wanted - before)) << left;
  }
}

TEST(PersonalShape, HeldOutFramesChangeNothing) {
  Seen seen = broad_person();
  for (const int i : {2, 5}) seen.frames[std::size_t(i)].held_out = true;
  PersonalShapeOptions quick;
  quick.rounds = 1;
  const Offsets before = fitted({}, seen.frames, quick);
  for (const int i : {2, 5}) {
    for (std::uint8_t& level : seen.pictures[std::size_t(i)].data) level = std::uint8_t(255 - level);
    seen.frames[std::size_t(i)].state.cam_from_head.translation().x() += 0.05;
    seen.frames[std::size_t(i)].state.expression.setConstant(0.5);
  }
  EXPECT_EQ(before, fitted({}, seen.frames, quick));
}

TEST(PersonalShape, OffsetsAreBoundedAndEyesMoveRigidly) {
  Offsets truth = wavy_person();
  for (Vec3f& o : truth) o *= 3;
  const HeadModel& model = test_head();
  PersonalShapeOptions options;
  options.max_m = 0.001;
  const Offsets found = fitted(points_on(truth), {}, options);
  Vec3f eye = Vec3f::Zero();
  for (int v = 0; v < model.vertex_count(); ++v) {
    EXPECT_LE(found[v].norm(), 0.00101f);
    if (model.parts[v] != HeadPart::left_eyeball) continue;
    if (eye.isZero()) eye = found[v];
    EXPECT_EQ(found[v], eye);
  }
}

TEST(PersonalShape, WithoutEvidenceThereIsNoShape) { EXPECT_TRUE(fitted({}).empty()); }

TEST(PersonalShape, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const auto offsets = fit_personal_shape(test_head(), test_identity(), points_on(wavy_person()), {}, {}, {},
                                          source.get_token());
  ASSERT_FALSE(offsets.ok());
  EXPECT_EQ(offsets.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
