// A linear head model with FLAME's meaning (Li et al., SIGGRAPH Asia 2017): template + identity + expression
// blend shapes + pose correctives, then linear blend skinning over five joints. Metres; x to the subject's
// left, y up, z out of the face; origin the model's own.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/dynamic_contour.h"

namespace likeness {

enum Joint : int { kRoot = 0, kNeck = 1, kJaw = 2, kLeftEye = 3, kRightEye = 4, kJointCount = 5 };
inline constexpr int kLandmarkCount = 68;     // iBUG-68, subject's right jaw first
inline constexpr int kPoseFeatureCount = 36;  // (R - I) of joints 1..4, row-major

// What a vertex belongs to. unknown if a model file does not say.
enum class HeadPart : std::uint8_t {
  face,
  scalp_neck,
  mouth_socket,
  left_eye_socket,
  right_eye_socket,
  gums_tongue,
  teeth,
  left_eyeball,
  right_eyeball,
  torso,
  unknown
};

// A named facial action and what it means in the model's own coefficients.
struct NamedAction {
  std::string name;                                           // ARKit/ICT names: jawOpen, mouthSmile_L, ...
  Eigen::VectorXf expression;                                 // (E) coefficients at full action
  Vec3f jaw = Vec3f::Zero();                                  // rotation vector, rad, at full action
  Vec3f left_eye = Vec3f::Zero(), right_eye = Vec3f::Zero();  // of the eyeballs, rad (eyeLook*)
  float residual =
      0;  // share of the motion that the model cannot represent, 0..1; 0 if it is the model's own
};

// A person's shape, in a head model's terms.
struct PersonShape {
  Eigen::VectorXf identity;    // (I) standard deviations
  std::vector<Vec3f> offsets;  // (V) personal shape beyond the identity, head frame at rest, m; or empty
};

struct HeadModel {
  std::string name;                  // shown to the user: "built-in", "ICT-FaceKit", "FLAME 2020", ...
  std::string hash;                  // of the content: two models with one hash pose alike
  std::vector<Vec3f> vertices;       // (V) template, m
  Eigen::MatrixXf identity_basis;    // (3V, I) m per standard deviation; row 3v+axis
  Eigen::MatrixXf expression_basis;  // (3V, E) m per unit
  Eigen::MatrixXf pose_basis;        // (3V, 36) m per feature; may have 0 columns
  Eigen::MatrixXf joint_regressor;   // (5, V) rows sum to 1
  Eigen::MatrixXf skinning_weights;  // (V, 5) rows sum to 1
  std::array<int, kJointCount> parents{-1, 0, 1, 1, 1};
  std::vector<Triangle> triangles;  // (F)
  std::array<int, kLandmarkCount> landmark_triangle{};
  std::array<Vec3f, kLandmarkCount> landmark_barycentric{};
  std::vector<HeadPart> parts;                // (V)
  std::vector<std::string> expression_names;  // (E), or empty where the model names none (FLAME)
  std::vector<NamedAction> actions;
  Eigen::VectorXf expression_min, expression_max;  // (E) valid range of an expression, e.g. 0..1
  std::vector<Vec2f> uvs;                          // (V) texture coordinates, or empty
  std::optional<DynamicContour> dynamic_contour;   // of models whose jaw line is known per yaw (FLAME)

  int vertex_count() const { return int(vertices.size()); }
  int identity_count() const { return int(identity_basis.cols()); }
  int expression_count() const { return int(expression_basis.cols()); }
};

// Everything that moves within the head frame. Rotation vectors about the joints, rad.
struct Articulation {
  Eigen::VectorXf expression;  // (E)
  Vec3f neck = Vec3f::Zero(), jaw = Vec3f::Zero(), left_eye = Vec3f::Zero(), right_eye = Vec3f::Zero();
};

Articulation neutral_articulation(const HeadModel& model);

// Hash of everything that decides how the model poses and what its coefficients mean (not of its name).
std::string content_hash(const HeadModel& model);

// nullptr if the model has no such action.
const NamedAction* find_action(const HeadModel& model, std::string_view name);
// Adds `amount` (1 = full) of an action to what is already there. Rotation vectors are added.
void add_action(Articulation& articulation, const NamedAction& action, float amount);

}  // namespace likeness
