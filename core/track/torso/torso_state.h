// How the torso of one frame moves and deforms, and where its picture then shows a point of it.
#pragma once

#include <vector>

#include "core/camera/camera.h"
#include "core/scene/torso_warp.h"
#include "core/track/torso/torso_frame.h"
#include "core/track/torso/torso_picture.h"

namespace likeness {

inline constexpr double kTorsoHeadMargin = 6;  // px about the head's outline that hide the torso, too

// A canonical point q of the torso frame goes to turn(angle) (q + displacement - pivot) + pivot + shift in
// the x-y plane of the reference torso, and by `depth` along its z.
struct TorsoMotion {
  double angle = 0;             // rad, about z
  Vec2d shift = Vec2d::Zero();  // m
  double depth = 0;             // m; stays 0 unless TorsoView::approaches
};

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
  bool approaches = false;            // the torso's distance is an unknown, too
  double head_depth = 0;              // by which the head has moved along the reference torso's z, m
};

Pose motion_pose(const TorsoMotion& motion, const Vec2d& pivot);

// Where the picture shows a canonical point, in the level's pixels; false if behind the camera or hidden by
// the head.
bool seen_at(const TorsoView& view, const Pose& motion, const Vec3d& posed, Vec2d* px);

// Posed canonical point, torso frame before the motion: place + displacement.
Vec3d displaced(const TorsoGrid& grid, const std::vector<float>& displacement, const Vec3d& place);

}  // namespace likeness
