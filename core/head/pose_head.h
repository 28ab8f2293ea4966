// Posing a head model: blend shapes, then skinning. The result is in the head frame (root rotation zero).
#pragma once

#include <vector>

#include "core/head/head_model.h"

namespace likeness {

// The model with a person baked in, so that posing costs only expression and skinning.
struct HeadShape {
  std::vector<Vec3f> vertices;              // (V) template + identity, m
  std::array<Vec3f, kJointCount> joints{};  // m
};

// identity: (I) standard deviations; shorter is padded with zero.
HeadShape shape_head(const HeadModel& model, const Eigen::VectorXf& identity);
// With the personal shape; offsets of another model are a programmer's mistake.
HeadShape shape_head(const HeadModel& model, const PersonShape& person);

// (V) vertices in the head frame, m.
std::vector<Vec3f> pose_head(const HeadModel& model, const HeadShape& shape,
                             const Articulation& articulation);

// The 68 landmarks of posed vertices, m.
std::array<Vec3f, kLandmarkCount> landmark_positions(const HeadModel& model, const std::vector<Vec3f>& posed);

// Area-weighted unit vertex normals.
std::vector<Vec3f> vertex_normals(const std::vector<Vec3f>& vertices, const std::vector<Triangle>& triangles);

}  // namespace likeness
