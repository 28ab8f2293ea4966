// Blend shapes, pose correctives and linear blend skinning, as FLAME defines them:
//   s = template + B_id * identity + B_ex * expression          (joints are regressed from s)
//   p = skin(s + B_pose * f),  f = (R - I) of joints 1..4, row-major
#include "core/head/pose_head.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace likeness {
namespace {

using Mat3f = Eigen::Matrix3f;
using FlatMap = Eigen::Map<Eigen::VectorXf>;

static_assert(sizeof(Vec3f) == 3 * sizeof(float), "vertices are used as a flat vector");

Mat3f rotation_matrix(const Vec3f& rotation_vector) {
  const float angle = rotation_vector.norm();
  if (angle < 1e-8f) return Mat3f::Identity();
  return Eigen::AngleAxisf(angle, rotation_vector / angle).toRotationMatrix();
}

std::array<Vec3f, kJointCount> regress_joints(const HeadModel& model, const std::vector<Vec3f>& vertices) {
  const Eigen::Map<const Eigen::Matrix3Xf> points(vertices.front().data(), 3, Eigen::Index(vertices.size()));
  const Eigen::Matrix<float, 3, kJointCount> joints = points * model.joint_regressor.transpose();
  std::array<Vec3f, kJointCount> out;
  for (int j = 0; j < kJointCount; ++j) out[j] = joints.col(j);
  return out;
}

// Per joint: the transform of a point of the unposed head bound to this joint alone.
struct Skeleton {
  std::array<Mat3f, kJointCount> rotation;
  std::array<Vec3f, kJointCount> translation;
};

Skeleton pose_skeleton(const HeadModel& model, const std::array<Vec3f, kJointCount>& joints,
                       const std::array<Mat3f, kJointCount>& local) {
  std::array<Mat3f, kJointCount> rotation;
  std::array<Vec3f, kJointCount> position;
  Skeleton skeleton;
  for (int j = 0; j < kJointCount; ++j) {
    const int parent = model.parents[j];
    rotation[j] = parent < 0 ? local[j] : Mat3f(rotation[parent] * local[j]);
    position[j] =
        parent < 0 ? joints[j] : Vec3f(position[parent] + rotation[parent] * (joints[j] - joints[parent]));
    skeleton.rotation[j] = rotation[j];
    skeleton.translation[j] = position[j] - rotation[j] * joints[j];
  }
  return skeleton;
}

// Coefficients that are not zero, with the column of the basis they belong to.
struct Blend {
  float amount;
  const float* column;  // (3 V)
};

std::vector<Blend> expression_blends(const HeadModel& model, const Eigen::VectorXf& expression) {
  std::vector<Blend> blends;
  for (Eigen::Index e = 0; e < expression.size(); ++e)
    if (expression[e] != 0) blends.push_back({expression[e], model.expression_basis.col(e).data()});
  return blends;
}

std::vector<Blend> pose_blends(const HeadModel& model, const std::array<Mat3f, kJointCount>& local) {
  std::vector<Blend> blends;
  if (model.pose_basis.cols() == 0) return blends;
  for (int j = 1; j < kJointCount; ++j) {
    const Mat3f difference = local[j] - Mat3f::Identity();
    for (int entry = 0; entry < 9; ++entry) {
      const float feature = difference(entry / 3, entry % 3);
      if (feature != 0) blends.push_back({feature, model.pose_basis.col((j - 1) * 9 + entry).data()});
    }
  }
  return blends;
}

// Vertices that stay in the first cache while every blend shape is added to them.
constexpr std::size_t kChunk = 1024;

void add_blends(const std::vector<Blend>& blends, std::size_t begin, std::size_t end,
                std::vector<Vec3f>& vertices) {
  const auto first = Eigen::Index(3 * begin), count = Eigen::Index(3 * (end - begin));
  FlatMap flat(vertices[begin].data(), count);
  for (const Blend& blend : blends)
    flat += blend.amount * Eigen::Map<const Eigen::VectorXf>(blend.column + first, count);
}

void skin(const HeadModel& model, const Skeleton& skeleton, std::size_t begin, std::size_t end,
          std::vector<Vec3f>& vertices) {
  for (std::size_t v = begin; v < end; ++v) {
    Mat3f rotation = Mat3f::Zero();
    Vec3f translation = Vec3f::Zero();
    for (int j = 0; j < kJointCount; ++j) {
      const float weight = model.skinning_weights(Eigen::Index(v), j);
      if (weight == 0) continue;
      rotation += weight * skeleton.rotation[j];
      translation += weight * skeleton.translation[j];
    }
    vertices[v] = rotation * vertices[v] + translation;
  }
}

}  // namespace

HeadShape shape_head(const HeadModel& model, const Eigen::VectorXf& identity) {
  LIKENESS_CHECK(identity.size() <= model.identity_count(), "%d identity coefficients, the model has %d",
                 int(identity.size()), model.identity_count());
  LIKENESS_CHECK(!model.vertices.empty(), "head model without vertices");
  HeadShape shape;
  shape.vertices = model.vertices;
  if (identity.size() > 0)
    FlatMap(shape.vertices.front().data(), 3 * model.vertex_count()).noalias() +=
        model.identity_basis.leftCols(identity.size()) * identity;
  shape.joints = regress_joints(model, shape.vertices);
  return shape;
}

HeadShape shape_head(const HeadModel& model, const PersonShape& person) {
  HeadShape shape = shape_head(model, person.identity);
  if (person.offsets.empty()) return shape;
  LIKENESS_CHECK(person.offsets.size() == shape.vertices.size(), "%d offsets for %d vertices",
                 int(person.offsets.size()), int(shape.vertices.size()));
  for (std::size_t v = 0; v < shape.vertices.size(); ++v) shape.vertices[v] += person.offsets[v];
  shape.joints = regress_joints(model, shape.vertices);
  return shape;
}

std::vector<Vec3f> pose_head(const HeadModel& model, const HeadShape& shape,
                             const Articulation& articulation) {
  LIKENESS_CHECK(int(shape.vertices.size()) == model.vertex_count(), "shape has %d vertices, the model %d",
                 int(shape.vertices.size()), model.vertex_count());
  LIKENESS_CHECK(articulation.expression.size() <= model.expression_count(),
                 "%d expression coefficients, the model has %d", int(articulation.expression.size()),
                 model.expression_count());
  std::vector<Vec3f> posed = shape.vertices;

  // -- Blend shapes
  const std::vector<Blend> expression = expression_blends(model, articulation.expression);
  if (!expression.empty())
    parallel_ranges(posed.size(), kChunk,
                    [&](std::size_t begin, std::size_t end) { add_blends(expression, begin, end, posed); });
  const std::array<Vec3f, kJointCount> joints =
      expression.empty() ? shape.joints : regress_joints(model, posed);

  // -- Pose
  const std::array<Mat3f, kJointCount> local = {
      Mat3f::Identity(), rotation_matrix(articulation.neck), rotation_matrix(articulation.jaw),
      rotation_matrix(articulation.left_eye), rotation_matrix(articulation.right_eye)};
  if (std::all_of(local.begin(), local.end(), [](const Mat3f& r) { return r == Mat3f::Identity(); }))
    return posed;
  const std::vector<Blend> correctives = pose_blends(model, local);
  const Skeleton skeleton = pose_skeleton(model, joints, local);
  parallel_ranges(posed.size(), kChunk, [&](std::size_t begin, std::size_t end) {
    add_blends(correctives, begin, end, posed);
    skin(model, skeleton, begin, end, posed);
  });
  return posed;
}

std::array<Vec3f, kLandmarkCount> landmark_positions(const HeadModel& model,
                                                     const std::vector<Vec3f>& posed) {
  LIKENESS_CHECK(int(posed.size()) == model.vertex_count(), "%d vertices, the model has %d",
                 int(posed.size()), model.vertex_count());
  std::array<Vec3f, kLandmarkCount> landmarks;
  for (int l = 0; l < kLandmarkCount; ++l) {
    const Triangle& triangle = model.triangles[model.landmark_triangle[l]];
    const Vec3f& weight = model.landmark_barycentric[l];
    landmarks[l] =
        weight[0] * posed[triangle[0]] + weight[1] * posed[triangle[1]] + weight[2] * posed[triangle[2]];
  }
  return landmarks;
}

std::vector<Vec3f> vertex_normals(const std::vector<Vec3f>& vertices,
                                  const std::vector<Triangle>& triangles) {
  std::vector<Vec3f> normals(vertices.size(), Vec3f::Zero());
  for (const Triangle& triangle : triangles) {
    const Vec3f& corner = vertices[triangle[0]];
    // Twice the area times the unit normal, so the sum is area-weighted.
    const Vec3f normal = (vertices[triangle[1]] - corner).cross(vertices[triangle[2]] - corner);
    for (int k = 0; k < 3; ++k) normals[triangle[k]] += normal;
  }
  for (Vec3f& normal : normals) {
    const float length = normal.norm();
    normal = length > 0 ? Vec3f(normal / length)
                        : Vec3f(0, 0, 1);  // a vertex in no triangle still gets a unit vector
  }
  return normals;
}

}  // namespace likeness
