// A synthetic person for tests: a ball-shaped head model whose lower front bulges with its one expression,
// and exact pictures of it (a patterned ball before a plate) in moving poses.
#pragma once

#include <cmath>
#include <numbers>

#include "core/base/rigid.h"
#include "core/head/pose_head.h"
#include "core/train/train.h"

namespace likeness {

inline constexpr float kBallRadius = 0.1f;

inline HeadModel ball_head() {
  constexpr int kRings = 16, kSectors = 24;
  HeadModel model;
  model.name = "ball";
  model.hash = "ball";
  for (int r = 0; r <= kRings; ++r)
    for (int s = 0; s < kSectors; ++s) {
      const float polar = float(r) * std::numbers::pi_v<float> / kRings;
      const float turn = 2 * float(s) * std::numbers::pi_v<float> / kSectors;
      model.vertices.push_back(kBallRadius * Vec3f(std::sin(polar) * std::sin(turn), std::cos(polar),
                                                   std::sin(polar) * std::cos(turn)));
    }
  const auto vertex = [](int r, int s) { return r * kSectors + s % kSectors; };
  for (int r = 0; r < kRings; ++r)
    for (int s = 0; s < kSectors; ++s) {
      model.triangles.push_back({vertex(r, s), vertex(r + 1, s), vertex(r + 1, s + 1)});
      model.triangles.push_back({vertex(r, s), vertex(r + 1, s + 1), vertex(r, s + 1)});
    }
  const auto v = Eigen::Index(model.vertices.size());
  model.identity_basis = Eigen::MatrixXf::Zero(3 * v, 1);
  model.expression_basis = Eigen::MatrixXf::Zero(3 * v, 2);
  for (Eigen::Index i = 0; i < v; ++i) {
    const Vec3f p = model.vertices[std::size_t(i)] / kBallRadius;
    if (p.y() < 0 && p.z() > 0) model.expression_basis(3 * i + 1, 0) = 0.02f * p.y();
    if (p.y() > 0.5f) model.expression_basis(3 * i + 2, 1) = 0.001f;
  }
  model.pose_basis = Eigen::MatrixXf::Zero(3 * v, kPoseFeatureCount);
  model.joint_regressor = Eigen::MatrixXf::Constant(kJointCount, v, 1.f / float(v));
  model.skinning_weights = Eigen::MatrixXf::Zero(v, kJointCount);
  model.skinning_weights.col(kNeck).setOnes();
  model.parts.assign(std::size_t(v), HeadPart::face);
  // Landmarks: nearest vertices to points on the front of the ball; only those that bound the face matter
  // here.
  for (int k = 0; k < kLandmarkCount; ++k) {
    Vec3f at(0, 0, 1);
    if (k == 8) at = Vec3f(0, -0.75f, 0.66f);
    if (k == 0 || k == 16) at = Vec3f(k == 0 ? -1.f : 1.f, 0.1f, 0.1f);
    if (k == 19 || k == 24) at = Vec3f(k == 19 ? -0.35f : 0.35f, 0.45f, 0.8f);
    if (k == 33) at = Vec3f(0, -0.1f, 1);
    if (k >= 48) at = Vec3f(0, -0.4f, 0.9f);
    int best = 0;
    for (std::size_t t = 0; t < model.triangles.size(); ++t) {
      const auto distance = [&](std::size_t u) {
        return (model.vertices[std::size_t(model.triangles[u][0])] / kBallRadius - at.normalized()).norm();
      };
      if (distance(t) < distance(std::size_t(best))) best = int(t);
    }
    model.landmark_triangle[std::size_t(k)] = best;
    model.landmark_barycentric[std::size_t(k)] = Vec3f(1, 0, 0);
  }
  model.expression_names = {"bulge", "top"};
  model.actions.push_back({"bulge", Eigen::VectorXf::Unit(2, 0), Vec3f::Zero()});
  model.expression_min = Eigen::VectorXf::Zero(2);
  model.expression_max = Eigen::VectorXf::Ones(2);
  return model;
}

// Colour of the ball at a unit normal of the head frame; the lower front brightens with the expression.
inline Vec3f ball_colour(const Vec3f& n, float expression) {
  const float stripe = 0.5f + 0.5f * std::sin(6 * n.x() + 4 * n.y());
  Vec3f c(0.3f + 0.5f * stripe, 0.4f + 0.3f * n.y(), 0.6f - 0.3f * stripe);
  if (n.y() < 0 && n.z() > 0) c += 0.3f * expression * n.z() * -n.y() * Vec3f(1, 1, 1);
  return c;
}

// turn: of the head about its own axis, beside its swaying, rad. shift: of the picture, px.
inline TrainingView ball_view(const Image8& plate, int size, double time, double turn = 0,
                              Vec3f (*colour)(const Vec3f& n, float expression) = ball_colour,
                              const Vec2d& shift = Vec2d::Zero()) {
  TrainingView view;
  view.camera.intrinsics = {
      size, size, 2.0 * size, 2.0 * size, 0.5 * size + shift.x(), 0.5 * size + shift.y()};
  view.pose.world_from_head.linear() = Vec3d(1, -1, -1).asDiagonal();
  view.pose.world_from_head.translation() = Vec3d(0.02 * std::sin(3 * time), 0.02 * std::cos(2 * time), 0.8);
  view.pose.world_from_head.rotate(rotation_about(Vec3d::UnitY(), 0.5 * std::sin(time) + turn));
  view.pose.world_from_torso = view.pose.world_from_head;
  view.pose.articulation.expression = Eigen::VectorXf::Zero(2);
  const float expression = float(0.5 + 0.5 * std::sin(5 * time));
  view.pose.articulation.expression[0] = expression;
  view.rgb = Image8(size, size, 3);
  Image8 alpha(size, size, 1);
  const Pose head_from_cam = inverse(view.pose.world_from_head);
  constexpr int kGrid = 4;  // samples a pixel, along an axis
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      Vec3f sum = Vec3f::Zero();
      int hits = 0;
      const Vec3f behind(plate.at(x, y)[0], plate.at(x, y)[1], plate.at(x, y)[2]);
      for (int s = 0; s < kGrid * kGrid; ++s) {
        const Vec2d pixel(x + (s % kGrid + 0.5) / kGrid, y + (s / kGrid + 0.5) / kGrid);
        const Vec3d o = head_from_cam.translation();
        const Vec3d d = (head_from_cam.linear() * ray_direction(view.camera.intrinsics, pixel)).normalized();
        const double b = o.dot(d), c = o.squaredNorm() - double(kBallRadius) * kBallRadius, root = b * b - c;
        if (root <= 0) {
          sum += behind;
          continue;
        }
        ++hits;
        sum += 255 * colour(((o + (-b - std::sqrt(root)) * d) / kBallRadius).cast<float>(), expression);
      }
      for (int c = 0; c < 3; ++c)
        view.rgb.at(x, y)[c] = std::uint8_t(std::clamp(sum[c] / (kGrid * kGrid) + 0.5f, 0.f, 255.f));
      alpha.at(x, y)[0] = std::uint8_t(255 * hits / (kGrid * kGrid));
    }
  view.alpha = TiledMask(alpha);
  return view;
}

inline Image8 gradient_plate(int size) {
  Image8 plate(size, size, 3);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      plate.at(x, y)[0] = std::uint8_t(40 + 120 * x / size);
      plate.at(x, y)[1] = std::uint8_t(40 + 120 * y / size);
      plate.at(x, y)[2] = 90;
    }
  return plate;
}

// Views at times 0.1 k; with_plate false: the mattes alone separate person and background.
inline TrainingSet ball_set(int views, int size, bool with_plate = true) {
  TrainingSet set;
  set.size = size;
  set.model = ball_head();
  set.person.identity = Eigen::VectorXf::Zero(1);
  set.has_torso = false;
  const Image8 plate = gradient_plate(size);
  for (int v = 0; v < views; ++v) {
    set.views.push_back(ball_view(plate, size, 0.37 * v));
    set.views.back().has_plate = with_plate;
  }
  if (with_plate) set.plate = plate;
  return set;
}

// So many steps of few rays, always the same ones.
inline TrainOptions short_training(std::uint64_t steps) {
  TrainOptions options;
  options.schedule.steps = steps;
  options.rays.per_step = 768;
  options.seed = 3;
  return options;
}

}  // namespace likeness
