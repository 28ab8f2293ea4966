// One frame of the torso: robust Gauss-Newton over its in-plane motion and its deformation, against a
// template.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/scene/torso_warp.h"
#include "core/track/torso/torso_picture.h"

namespace likeness {

// A canonical point q of the torso frame goes to turn(angle) (q + displacement - pivot) + pivot + shift,
// everything in the x-y plane of the reference torso.
struct TorsoMotion {
  double angle = 0;             // rad, about z
  Vec2d shift = Vec2d::Zero();  // m
};

// What may change besides the motion.
enum class TorsoFreedom { rigid, nodes, modes };

// Of one frame; `displacement` at the grid's nodes, `shape` where modes are followed.
struct TorsoState {
  TorsoMotion motion;
  std::vector<float> displacement;  // (rows, columns, 2) posed minus canonical, m; empty = none
  TorsoShape shape{};
};

struct TorsoView {
  const GreyLevel* level = nullptr;
  const TorsoFrame* frame = nullptr;
  Pose reference = Pose::Identity();  // world_from_torso of the reference frame
};

Pose motion_pose(const TorsoMotion& motion, const Vec2d& pivot);

// Where the picture shows a canonical point, in the level's pixels; false if behind the camera or hidden by
// the head.
bool seen_at(const TorsoView& view, const Pose& motion, const Vec3d& posed, Vec2d* px);

// Posed canonical point, torso frame before the motion: place + displacement.
Vec3d displaced(const TorsoGrid& grid, const std::vector<float>& displacement, const Vec3d& place);

// Mean absolute difference of relief, grey levels, at the start of the last iteration; 1e9 if too little is
// seen. With TorsoFreedom::nodes the grid is kept smooth; with modes the shape is pulled towards the training
// frames' spread.
double align_torso(const std::vector<TorsoPixel>& pixels, const TorsoView& view, const Vec2d& pivot,
                   const TorsoGrid& grid, const TorsoModes* modes, TorsoFreedom freedom, int iterations,
                   TorsoState* state);

// Sum over pixels of J^T J for displacements of the nodes, with the template itself as the picture, plus the
// smoothness: the metric of deformations, (2P, 2P).
Eigen::MatrixXd picture_metric(const std::vector<TorsoPixel>& pixels, const TorsoView& view,
                               const TorsoGrid& grid);

}  // namespace likeness
