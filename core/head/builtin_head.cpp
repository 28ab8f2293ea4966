// Assembly of the built-in head: from millimetre fields over both halves to a HeadModel in metres.
#include "core/head/builtin_head.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/check.h"
#include "core/base/dense_solves.h"
#include "core/head/builtin_fields.h"
#include "core/head/builtin_landmarks.h"
#include "core/head/builtin_sculpt.h"
#include "core/head/drawn_landmarks.h"
#include "core/head/named_actions.h"

namespace likeness {
namespace {

using namespace builtin;

constexpr double kMetrePerMillimetre = 1e-3;  // per millimetre
constexpr float kJawOpenAngle = 25 * std::numbers::pi_v<float> / 180;

Eigen::MatrixXf basis_of(const std::vector<NamedField>& fields, std::size_t vertices) {
  Eigen::MatrixXf basis(3 * vertices, fields.size());
  for (std::size_t c = 0; c < fields.size(); ++c)
    for (std::size_t v = 0; v < vertices; ++v)
      basis.block<3, 1>(3 * v, c) = (fields[c].field[v] * kMetrePerMillimetre).cast<float>();
  return basis;
}

Eigen::MatrixXf skinning_of(const WholeHead& head) {
  Eigen::MatrixXf weights = Eigen::MatrixXf::Zero(head.vertices.size(), kJointCount);
  for (std::size_t i = 0; i < head.vertices.size(); ++i) {
    const HalfVertex& v = head.vertices[i];
    if (v.part == HeadPart::left_eyeball || v.part == HeadPart::right_eyeball) {
      weights(i, v.part == HeadPart::left_eyeball ? kLeftEye : kRightEye) = 1;
      continue;
    }
    const float turned = v.part == HeadPart::torso ? 0 : float(smoothstep(-160, -84, v.position.y()));
    const float jaw = turned * float(jaw_weight(v));
    weights(i, kJaw) = jaw;
    weights(i, kNeck) = turned - jaw;
    weights(i, kRoot) = 1 - turned;
  }
  return weights;
}

// Weights of the vertices within `reach` of a joint's height whose mean is the joint: of all that add up to
// one and put the joint exactly there, those closest to equal. The joint thus follows the tissue around it.
void regress_joint(const WholeHead& head, const Vec3d& joint, const std::vector<int>& vertices,
                   Eigen::MatrixXf& regressor, int row) {
  const int n = int(vertices.size());
  LIKENESS_CHECK(n >= 8, "joint %d has %d vertices around it", row, n);
  Eigen::MatrixXd a(4, n);
  for (int k = 0; k < n; ++k) a.col(k) << head.vertices[vertices[k]].position, 1;
  const Eigen::VectorXd equal = Eigen::VectorXd::Constant(n, 1.0 / n);
  const Eigen::Vector4d wanted(joint.x(), joint.y(), joint.z(), 1);
  const Eigen::Matrix4d gram = a * a.transpose();
  const Eigen::VectorXd w = equal + a.transpose() * solve_symmetric<4>(gram, wanted - a * equal);
  for (int k = 0; k < n; ++k) regressor(row, vertices[k]) = float(w[k]);
}

Eigen::MatrixXf joint_regressor_of(const WholeHead& head) {
  Eigen::MatrixXf regressor = Eigen::MatrixXf::Zero(kJointCount, head.vertices.size());
  const auto select = [&](auto&& wanted) {
    std::vector<int> chosen;
    for (int i = 0; i < int(head.vertices.size()); ++i)
      if (wanted(head.vertices[i])) chosen.push_back(i);
    return chosen;
  };
  const auto ring = [](double y, double half) {
    return [=](const HalfVertex& v) {
      return v.tissue == Tissue::skin && v.part != HeadPart::face && std::abs(v.position.y() - y) < half &&
             std::abs(v.position.x()) < 100;
    };
  };
  regress_joint(head, kRootJoint, select(ring(kRootJoint.y(), 12)), regressor, kRoot);
  regress_joint(head, kNeckJoint, select(ring(kNeckJoint.y(), 14)), regressor, kNeck);
  regress_joint(head, kJawJoint, select([](const HalfVertex& v) {
                  return v.tissue == Tissue::skin && v.lid == 0 &&
                         std::abs(v.position.y() - kJawJoint.y()) < 14 && v.position.z() > -25 &&
                         v.position.z() < 60;
                }),
                regressor, kJaw);
  for (const bool left : {true, false}) {
    const auto eye = select([&](const HalfVertex& v) {
      return v.part == (left ? HeadPart::left_eyeball : HeadPart::right_eyeball);
    });
    const Vec3d centre = left ? kEyeCentre : Vec3d(-kEyeCentre.x(), kEyeCentre.y(), kEyeCentre.z());
    regress_joint(head, centre, eye, regressor, left ? kLeftEye : kRightEye);
  }
  return regressor;
}

void fill_actions(HeadModel& model) {
  model.actions = make_named_actions(model);
  NamedAction open;
  open.name = "jawOpen";
  open.expression = Eigen::VectorXf::Zero(model.expression_count());
  open.jaw = Vec3f(kJawOpenAngle, 0, 0);
  model.actions.push_back(open);
}

}  // namespace

HeadModel make_builtin_head() {
  const WholeHead head = make_whole_head();
  HeadModel model;
  model.name = "built-in";
  for (const HalfVertex& v : head.vertices) {
    model.vertices.push_back((v.position * kMetrePerMillimetre).cast<float>());
    model.parts.push_back(v.part);
    model.uvs.push_back(v.uv.cast<float>());
  }
  model.triangles = head.triangles;
  const auto identity = identity_fields(head), expressions = expression_fields(head);
  model.identity_basis = basis_of(identity, head.vertices.size());
  model.expression_basis = basis_of(expressions, head.vertices.size());
  for (const NamedField& field : expressions) model.expression_names.push_back(field.name);
  model.expression_min = Eigen::VectorXf::Zero(model.expression_count());
  model.expression_max = Eigen::VectorXf::Ones(model.expression_count());
  model.pose_basis.resize(3 * model.vertex_count(), 0);
  model.skinning_weights = skinning_of(head);
  model.joint_regressor = joint_regressor_of(head);
  embed_landmarks(head, model);
  draw_landmarks(model, builtin_shifts());
  fill_actions(model);
  model.hash = content_hash(model);
  return model;
}

}  // namespace likeness
