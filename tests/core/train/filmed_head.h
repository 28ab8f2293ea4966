// A clip of the built-in head for tests of proxies: it looks into the camera, a few degrees to either side,
// painted with a smooth pattern that has no light in it; its scalp may be raised as by hair.
#pragma once

#include <cmath>

#include "core/head/builtin_head.h"
#include "core/scene/mesh_scene.h"
#include "core/synth/body_pose.h"
#include "core/train/head_marks.h"
#include "core/train/train.h"

namespace likeness {

struct FilmedHead {
  HeadModel model = make_builtin_head();
  HeadShape shape = shape_head(model, Eigen::VectorXf());
  float hair = 0;  // m that the scalp is raised by, well above the ears

  std::vector<Vec3f> posed(const Articulation& articulation) const {
    std::vector<Vec3f> vertices = pose_head(model, shape, articulation);
    const std::vector<Vec3f> normals = vertex_normals(vertices, model.triangles);
    const HeadMarks marks = head_marks(model, shape);
    for (std::size_t v = 0; v < vertices.size(); ++v)
      if (is_skin(model, v) && hairiness(marks, vertices[v]) >= 1 && vertices[v].y() > marks.brow + 0.02f)
        vertices[v] += hair * normals[v];
    return vertices;
  }
  Vec3f colour(std::size_t v) const {
    const Vec3f p = 40 * shape.vertices[v];
    return {0.55f + 0.2f * std::sin(p.x()), 0.5f + 0.2f * std::sin(p.y()), 0.45f + 0.2f * std::sin(p.z())};
  }
  // What a camera sees of it, and its silhouette.
  void draw(const TrainingView& view, Image8& rgb, Image8& alpha) const {
    const Intrinsics& k = view.camera.intrinsics;
    const Raster raster = rasterise(posed(view.pose.articulation), model.triangles, k,
                                    view.camera.cam_from_world * view.pose.world_from_head);
    rgb = Image8(k.width, k.height, 3), alpha = Image8(k.width, k.height, 1);
    for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
      if (raster.triangle[i] < 0) continue;
      Vec3f sum = Vec3f::Zero();
      for (int c = 0; c < 3; ++c)
        sum += raster.barycentric[i][c] *
               colour(std::size_t(model.triangles[std::size_t(raster.triangle[i])][c]));
      for (int c = 0; c < 3; ++c) rgb.data[3 * i + std::size_t(c)] = std::uint8_t(std::lround(255 * sum[c]));
      alpha.data[i] = 255;
    }
  }
};

// The head turns to either side by at most `turn_deg`.
inline TrainingSet filmed_set(const FilmedHead& head, int views, double turn_deg, int size = 128) {
  TrainingSet set;
  set.size = size;
  set.model = head.model;
  set.person.identity = Eigen::VectorXf::Zero(head.model.identity_count());
  set.has_torso = false;
  for (int v = 0; v < views; ++v) {
    TrainingView view;
    view.camera.intrinsics = {size, size, 2.2 * size, 2.2 * size, 0.5 * size, 0.5 * size};
    view.camera.cam_from_world.linear() = Vec3d(1, -1, -1).asDiagonal();  // before the face, looking at it
    view.camera.cam_from_world.translation() = Vec3d(0, 0, 0.8);
    const double turn = turn_deg * std::numbers::pi / 180 * (2.0 * v / std::max(1, views - 1) - 1);
    view.pose.world_from_head.linear() = head_turn(turn, 0, 0);
    view.pose.articulation = neutral_articulation(head.model);
    Image8 alpha;
    head.draw(view, view.rgb, alpha);
    view.alpha = TiledMask(alpha);
    set.views.push_back(std::move(view));
  }
  return set;
}

}  // namespace likeness
