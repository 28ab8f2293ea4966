// Named actions from named expressions. See named_actions.h.
#include "core/head/named_actions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/head/pose_head.h"

namespace likeness {
namespace {

constexpr float kDegree = std::numbers::pi_v<float> / 180;
// Comfortable limits of gaze; a full eyeLook* shape of the lids corresponds to about this much.
constexpr float kLookUp = 25 * kDegree, kLookDown = 30 * kDegree, kLookSide = 30 * kDegree;
// Below this share of unexplained motion the jaw joint replaces the jawOpen shape.
constexpr float kSameMotion = 0.05f;

bool starts_with(const std::string& text, const char* start) { return text.rfind(start, 0) == 0; }

// Gaze of an eyeLook* action, rad: +x rotation looks down, +y to the subject's left.
Vec3f gaze_rotation(const std::string& name, bool left_eye) {
  const float outward = left_eye ? 1.0f : -1.0f;
  if (starts_with(name, "eyeLookUp")) return {-kLookUp, 0, 0};
  if (starts_with(name, "eyeLookDown")) return {kLookDown, 0, 0};
  if (starts_with(name, "eyeLookOut")) return {0, outward * kLookSide, 0};
  if (starts_with(name, "eyeLookIn")) return {0, -outward * kLookSide, 0};
  return Vec3f::Zero();
}

}  // namespace

JawMatch match_jaw_rotation(const HeadModel& model, int expression) {
  const HeadShape shape = shape_head(model, Eigen::VectorXf());
  const auto target = model.expression_basis.col(expression);
  const double target_norm = target.cast<double>().norm();
  if (target_norm == 0) return {};
  Articulation articulation = neutral_articulation(model);
  const auto residual = [&](float angle) {
    articulation.jaw = {angle, 0, 0};
    const std::vector<Vec3f> posed = pose_head(model, shape, articulation);
    double sum = 0;
    for (std::size_t v = 0; v < posed.size(); ++v)
      sum += (posed[v] - shape.vertices[v] - target.segment<3>(3 * Eigen::Index(v)))
                 .cast<double>()
                 .squaredNorm();
    return std::sqrt(sum) / target_norm;
  };
  // Golden section: the residual has one minimum in the angle over the range of a jaw.
  const float ratio = (std::sqrt(5.0f) - 1) / 2;
  float low = 0, high = 60 * kDegree;
  float a = high - ratio * (high - low), b = low + ratio * (high - low);
  double at_a = residual(a), at_b = residual(b);
  while (high - low > 1e-4f) {
    if (at_a < at_b) {
      high = b, b = a, at_b = at_a;
      a = high - ratio * (high - low), at_a = residual(a);
    } else {
      low = a, a = b, at_a = at_b;
      b = low + ratio * (high - low), at_b = residual(b);
    }
  }
  const float angle = (low + high) / 2;
  return {angle, float(residual(angle))};
}

std::vector<NamedAction> make_named_actions(const HeadModel& model) {
  std::vector<NamedAction> actions;
  const int count = model.expression_count();
  if (int(model.expression_names.size()) != count) return actions;
  for (int e = 0; e < count; ++e) {
    NamedAction action;
    action.name = model.expression_names[e];
    action.expression = Eigen::VectorXf::Zero(count);
    const JawMatch jaw = action.name == "jawOpen" ? match_jaw_rotation(model, e) : JawMatch{};
    if (jaw.relative_residual < kSameMotion)
      action.jaw = {jaw.angle, 0, 0};
    else
      action.expression[e] = model.expression_max.size() == count ? model.expression_max[e] : 1.0f;
    if (action.name.ends_with("_L")) action.left_eye = gaze_rotation(action.name, true);
    if (action.name.ends_with("_R")) action.right_eye = gaze_rotation(action.name, false);
    actions.push_back(std::move(action));
  }
  return actions;
}

}  // namespace likeness
