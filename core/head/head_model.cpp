// Content hash, actions by name and the neutral articulation of a head model.
#include "core/head/head_model.h"

#include <cstddef>
#include <span>

#include "core/base/check.h"
#include "core/base/hash.h"

namespace likeness {
namespace {

template <class T>
void append_hash(std::string& out, const char* label, const T* data, std::size_t count) {
  out += label;
  out += ' ' + std::to_string(count) + ' ';
  out += hash_bytes(std::as_bytes(std::span<const T>(data, count)));
  out += '\n';
}

void append_hash(std::string& out, const char* label, const Eigen::MatrixXf& matrix) {
  out += std::to_string(matrix.rows()) + 'x' + std::to_string(matrix.cols()) + ' ';
  append_hash(out, label, matrix.data(), std::size_t(matrix.size()));
}

}  // namespace

Articulation neutral_articulation(const HeadModel& model) {
  Articulation articulation;
  articulation.expression = Eigen::VectorXf::Zero(model.expression_count());
  return articulation;
}

std::string content_hash(const HeadModel& model) {
  // Each array is hashed on its own and the list of hashes once more, so that no 20 MB copy is made.
  std::string list = "head model 1\n";
  append_hash(list, "vertices", model.vertices.data(), model.vertices.size());
  append_hash(list, "identity", model.identity_basis);
  append_hash(list, "expression", model.expression_basis);
  append_hash(list, "pose", model.pose_basis);
  append_hash(list, "regressor", model.joint_regressor);
  append_hash(list, "weights", model.skinning_weights);
  append_hash(list, "parents", model.parents.data(), model.parents.size());
  append_hash(list, "triangles", model.triangles.data(), model.triangles.size());
  append_hash(list, "landmark triangles", model.landmark_triangle.data(), model.landmark_triangle.size());
  append_hash(list, "landmark weights", model.landmark_barycentric.data(), model.landmark_barycentric.size());
  append_hash(list, "parts", model.parts.data(), model.parts.size());
  if (model.dynamic_contour)
    append_hash(list, "contour", model.dynamic_contour->rows.data(), model.dynamic_contour->rows.size());
  for (const std::string& name : model.expression_names) list += "name " + name + '\n';
  return hash_text(list);
}

const NamedAction* find_action(const HeadModel& model, std::string_view name) {
  for (const NamedAction& action : model.actions)
    if (action.name == name) return &action;
  return nullptr;
}

void add_action(Articulation& articulation, const NamedAction& action, float amount) {
  LIKENESS_CHECK(articulation.expression.size() == action.expression.size() || action.expression.size() == 0,
                 "%d coefficients in the articulation, %d in action %s", int(articulation.expression.size()),
                 int(action.expression.size()), action.name.c_str());
  if (action.expression.size() > 0) articulation.expression += amount * action.expression;
  articulation.jaw += amount * action.jaw;
  articulation.left_eye += amount * action.left_eye;
  articulation.right_eye += amount * action.right_eye;
}

}  // namespace likeness
