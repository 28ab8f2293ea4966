// A small made-up head model for tests: an ellipsoid with random bases, so that every term of posing is
// exercised.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "core/base/npz.h"
#include "core/head/head_model.h"

namespace likeness {

// 10 x 12 grid on an ellipsoid of head size; 6 identity and 4 expression directions.
inline HeadModel synthetic_head(unsigned seed = 1) {
  constexpr int kRings = 10, kSpokes = 12, kIdentity = 6, kExpression = 4;
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  HeadModel model;
  model.name = "synthetic";
  for (int ring = 0; ring < kRings; ++ring)
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      const float polar = std::numbers::pi_v<float> * (ring + 0.5f) / kRings;
      const float around = 2 * std::numbers::pi_v<float> * spoke / kSpokes;
      model.vertices.emplace_back(0.08f * std::sin(polar) * std::sin(around), 0.12f * std::cos(polar),
                                  0.1f * std::sin(polar) * std::cos(around));
    }
  for (int ring = 0; ring + 1 < kRings; ++ring)
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      const int next = (spoke + 1) % kSpokes, a = ring * kSpokes + spoke, b = ring * kSpokes + next;
      model.triangles.emplace_back(a, a + kSpokes, b);
      model.triangles.emplace_back(b, a + kSpokes, b + kSpokes);
    }
  const int count = model.vertex_count();
  const auto random_matrix = [&](int rows, int columns, float scale) {
    Eigen::MatrixXf matrix(rows, columns);
    for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = scale * normal(random);
    return matrix;
  };
  model.identity_basis = random_matrix(3 * count, kIdentity, 0.003f);
  model.expression_basis = random_matrix(3 * count, kExpression, 0.003f);
  model.pose_basis = random_matrix(3 * count, kPoseFeatureCount, 0.002f);
  model.joint_regressor = random_matrix(kJointCount, count, 1).cwiseAbs();
  model.skinning_weights = random_matrix(count, kJointCount, 1).cwiseAbs();
  for (int j = 0; j < kJointCount; ++j) model.joint_regressor.row(j) /= model.joint_regressor.row(j).sum();
  for (int v = 0; v < count; ++v) model.skinning_weights.row(v) /= model.skinning_weights.row(v).sum();
  for (int l = 0; l < kLandmarkCount; ++l) {
    model.landmark_triangle[l] = (l * 3) % int(model.triangles.size());
    const Vec3f weight(0.2f + 0.001f * l, 0.3f, 0.5f - 0.001f * l);
    model.landmark_barycentric[l] = weight / weight.sum();
  }
  for (int v = 0; v < count; ++v) model.parts.push_back(HeadPart(v % 9));
  model.expression_names = {"jawOpen", "mouthSmile_L", "eyeLookUp_L", "eyeLookIn_R"};
  model.expression_min = Eigen::VectorXf::Zero(kExpression);
  model.expression_max = Eigen::VectorXf::Ones(kExpression);
  return model;
}

inline NpyArray text_array(const std::vector<std::string>& words) {
  NpyArray array;
  array.kind = 'U';
  std::size_t longest = 1;
  for (const std::string& word : words) longest = std::max(longest, word.size());
  array.item_bytes = int(4 * longest);
  array.shape = {words.size()};
  array.data.assign(words.size() * longest * 4, std::byte(0));
  for (std::size_t w = 0; w < words.size(); ++w)
    for (std::size_t c = 0; c < words[w].size(); ++c)
      array.data[(w * longest + c) * 4] = std::byte(words[w][c]);
  return array;
}

// The model as an archive in the FLAME key schema.
inline NpzArchive archive_of(const HeadModel& model) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::size_t count = model.vertices.size(), joints = kJointCount;
  const std::size_t identity = model.identity_count(), expression = model.expression_count();
  const auto matrix = [](std::vector<std::size_t> shape, const RowMajor& values) {
    return npy_from_floats(std::move(shape), std::span(values.data(), std::size_t(values.size())));
  };
  RowMajor shapes(3 * count, identity + expression);
  shapes << model.identity_basis, model.expression_basis;
  NpzArchive archive;
  archive["v_template"] = npy_from_floats({count, 3}, std::span(model.vertices.front().data(), 3 * count));
  archive["shapedirs"] = matrix({count, 3, identity + expression}, shapes);
  archive["posedirs"] = matrix({count, 3, std::size_t(model.pose_basis.cols())}, model.pose_basis);
  archive["J_regressor"] = matrix({joints, count}, model.joint_regressor);
  archive["weights"] = matrix({count, joints}, model.skinning_weights);
  std::vector<std::int32_t> tree(model.parents.begin(), model.parents.end());
  for (int j = 0; j < kJointCount; ++j) tree.push_back(j);
  archive["kintree_table"] = npy_from_ints({2, joints}, tree);
  archive["f"] = npy_from_ints({model.triangles.size(), 3},
                               std::span(model.triangles.front().data(), 3 * model.triangles.size()));
  archive["lmk_faces_idx"] = npy_from_ints({kLandmarkCount}, model.landmark_triangle);
  archive["lmk_bary_coords"] = npy_from_floats(
      {kLandmarkCount, 3}, std::span(model.landmark_barycentric[0].data(), 3 * kLandmarkCount));
  archive["n_shape"] = npy_from_ints({}, std::vector<std::int32_t>{std::int32_t(identity)});
  archive["n_expr"] = npy_from_ints({}, std::vector<std::int32_t>{std::int32_t(expression)});
  std::vector<std::int32_t> parts;
  for (const HeadPart part : model.parts) parts.push_back(int(part));
  archive["part_id"] = npy_from_ints({count}, parts);
  if (!model.expression_names.empty()) archive["expression_names"] = text_array(model.expression_names);
  return archive;
}

inline Eigen::VectorXf random_coefficients(int count, unsigned seed, float scale = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Eigen::VectorXf values(count);
  for (float& value : values) value = scale * normal(random);
  return values;
}

inline Articulation random_articulation(const HeadModel& model, unsigned seed) {
  Articulation articulation;
  articulation.expression = random_coefficients(model.expression_count(), seed, 0.5f);
  const Eigen::VectorXf angles = random_coefficients(12, seed + 100, 0.4f);
  articulation.neck = angles.segment<3>(0);
  articulation.jaw = angles.segment<3>(3);
  articulation.left_eye = angles.segment<3>(6);
  articulation.right_eye = angles.segment<3>(9);
  return articulation;
}

}  // namespace likeness
