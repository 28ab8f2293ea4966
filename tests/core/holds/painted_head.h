// A head that is painted instead of learnt: what a perfect avatar of it shows is known from everywhere, and
// faults can be put where a test wants them.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "core/render/backend.h"
#include "core/scene/mesh_scene.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness::test {

inline const HeadModel& painted_model() {
  static const HeadModel model = make_builtin_head();
  return model;
}

// Looks at the head's origin from 0.7 m, from this far to the subject's left.
inline Camera camera_before_head(double yaw_deg, int side) {
  const double yaw = yaw_deg * std::numbers::pi / 180;
  Pose cam_from_head = Pose::Identity();
  cam_from_head.translate(Vec3d(0, 0, 0.7)).rotate(rotation_about(Vec3d::UnitX(), std::numbers::pi));
  cam_from_head.rotate(rotation_about(Vec3d::UnitY(), -yaw));
  return {-1, {side, side, 1.8 * side, 1.8 * side, 0.5 * side, 0.5 * side, 0, 0, 0, 0}, cam_from_head};
}

// What is wrong with a picture: called with it before it is handed out.
struct PaintedPicture {
  Image rgb, alpha;  // (h, w, 3) and (h, w, 1)
};
using SpoilPicture =
    std::function<void(const Camera& camera, const RenderState& state, PaintedPicture& picture)>;

// Each place of the surface has its own colour, the mouth's inside is dark, there is nothing beside the head.
inline PaintedPicture painted_picture(const std::vector<Vec3f>& posed, const Camera& camera,
                                      const Pose& world_from_head, const RenderState& state,
                                      const SpoilPicture& spoil = {}) {
  const HeadModel& model = painted_model();
  const Intrinsics& k = camera.intrinsics;
  const Raster raster = rasterise(posed, model.triangles, k, camera.cam_from_world * world_from_head);
  PaintedPicture picture{Image(k.width, k.height, 3, 0.5f), Image(k.width, k.height, 1)};
  for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
    if (raster.triangle[i] < 0) continue;
    const Triangle& triangle = model.triangles[std::size_t(raster.triangle[i])];
    bool inner = true;
    Vec3f at = Vec3f::Zero();
    for (int c = 0; c < 3; ++c) {
      const auto v = std::size_t(triangle[c]);
      const HeadPart part = model.parts[v];
      inner &= part == HeadPart::mouth_socket || part == HeadPart::gums_tongue || part == HeadPart::teeth;
      at += raster.barycentric[i][c] * model.vertices[v];
    }
    const Vec3f skin(0.7f + at.x(), 0.5f + at.y(), 0.4f - at.x());
    for (int c = 0; c < 3; ++c) picture.rgb.data[3 * i + std::size_t(c)] = inner ? 0.1f : skin[c];
    picture.alpha.data[i] = 1;
  }
  if (spoil) spoil(camera, state, picture);
  return picture;
}

// Paints the posed head for any avatar.
class PaintedBackend : public Backend {
 public:
  explicit PaintedBackend(SpoilPicture spoil = {}) : spoil_(std::move(spoil)) {}
  std::string name() const override { return "painted"; }
  Result<std::unique_ptr<FieldLearner>> make_learner(const LearntParts&, const LearnerShape&) override {
    return Error{ErrorCode::failed, "It only paints.", "", ""};
  }
  Result<std::unique_ptr<FrameRenderer>> make_renderer(const Avatar&) override {
    return std::unique_ptr<FrameRenderer>(std::make_unique<Painter>(spoil_));
  }

 private:
  class Painter : public FrameRenderer {
   public:
    explicit Painter(const SpoilPicture& spoil) : spoil_(spoil) {}
    Result<RenderedFrame> render(const Camera& camera, const RenderState& state,
                                 const RenderOptions&) override {
      static const HeadShape shape = shape_head(painted_model(), Eigen::VectorXf());
      const PaintedPicture picture =
          painted_picture(pose_head(painted_model(), shape, state.pose.articulation), camera,
                          state.pose.world_from_head, state, spoil_);
      RenderedFrame frame;
      frame.rgba = Image(picture.rgb.width, picture.rgb.height, 4);
      for (std::size_t i = 0; i < picture.alpha.data.size(); ++i) {
        const float alpha = picture.alpha.data[i];
        for (std::size_t c = 0; c < 3; ++c) frame.rgba.data[4 * i + c] = alpha * picture.rgb.data[3 * i + c];
        frame.rgba.data[4 * i + 3] = alpha;
      }
      return frame;
    }
    std::string backend() const override { return "painted"; }

   private:
    SpoilPicture spoil_;
  };
  SpoilPicture spoil_;
};

// An avatar that looks straight into its camera; its own fields are empty.
inline Avatar painted_avatar() {
  const HeadModel& model = painted_model();
  Avatar a = tiny_avatar();
  a.head_model_name = model.name, a.head_model_hash = model.hash;
  a.person.identity = Eigen::VectorXf::Zero(model.identity_count());
  a.person.offsets.clear();
  a.neutral = neutral_articulation(model);
  a.condition.mean = Eigen::VectorXf::Zero(model.expression_count() + 9);
  a.condition.rows = Eigen::MatrixXf::Zero(2, model.expression_count() + 9);
  a.head.occupancy = make_occupancy(8, false);
  a.torso.reset();
  a.world_from_head = Pose::Identity();
  a.world_from_torso = Pose::Identity();
  const Camera camera = camera_before_head(0, 160);
  a.cam_from_world = camera.cam_from_world, a.intrinsics = camera.intrinsics;
  a.plate = {};
  a.size = 160;
  return a;
}

}  // namespace likeness::test
