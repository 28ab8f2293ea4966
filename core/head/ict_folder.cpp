// A head model from ICT-FaceKit's folder: see ict_folder.h.
#include "core/head/ict_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/dense_solves.h"
#include "core/base/files.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/head/drawn_landmarks.h"
#include "core/head/named_actions.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr float kMetrePerCentimetre = 0.01f;  // per centimetre
constexpr std::size_t kVertices = 24591;      // up to the eyeballs
constexpr int kMaxIdentities = 1000;
constexpr const char* kNeutral = "generic_neutral_mesh.obj";
constexpr const char* kJawOpen = "jawOpen";
constexpr double kJawAngle = 25.33 * std::numbers::pi / 180;
const Vec3d kJawJoint(0, -0.0054732505, 0.018191051);  // m
const Vec3d kRootJoint(0, -0.155, -0.030), kNeckJoint(0, -0.085, -0.010);

// The expressions of ICT-FaceKit's light model, in the order of its vertex_indices.json.
constexpr std::array kExpressions{
    "browDown_L",       "browDown_R",       "browInnerUp_L",  "browInnerUp_R",   "browOuterUp_L",
    "browOuterUp_R",    "cheekPuff_L",      "cheekPuff_R",    "cheekSquint_L",   "cheekSquint_R",
    "eyeBlink_L",       "eyeBlink_R",       "eyeLookDown_L",  "eyeLookDown_R",   "eyeLookIn_L",
    "eyeLookIn_R",      "eyeLookOut_L",     "eyeLookOut_R",   "eyeLookUp_L",     "eyeLookUp_R",
    "eyeSquint_L",      "eyeSquint_R",      "eyeWide_L",      "eyeWide_R",       "jawForward",
    "jawLeft",          "jawOpen",          "jawRight",       "mouthClose",      "mouthDimple_L",
    "mouthDimple_R",    "mouthFrown_L",     "mouthFrown_R",   "mouthFunnel",     "mouthLeft",
    "mouthLowerDown_L", "mouthLowerDown_R", "mouthPress_L",   "mouthPress_R",    "mouthPucker",
    "mouthRight",       "mouthRollLower",   "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper",
    "mouthSmile_L",     "mouthSmile_R",     "mouthStretch_L", "mouthStretch_R",  "mouthUpperUp_L",
    "mouthUpperUp_R",   "noseSneer_L",      "noseSneer_R"};

// Vertices at the 68 iBUG landmarks, subject's right jaw first. ICT-FaceKit publishes such a list with its
// light model; the numbers are facts about its mesh.
constexpr std::array<int, kLandmarkCount> kLandmarkVertices{
    1225, 1888, 1052, 367,  1719, 1722, 2199, 1447, 966,  3661, 4390, 3927, 3924, 2608, 3272, 4088, 3443,
    268,  493,  1914, 2044, 1401, 3615, 4240, 4114, 2734, 2509, 978,  4527, 4942, 4857, 1140, 2075, 1147,
    4269, 3360, 1507, 1542, 1537, 1528, 1518, 1511, 3742, 3751, 3756, 3721, 3725, 3732, 5708, 5695, 2081,
    0,    4275, 6200, 6213, 6346, 6461, 5518, 5957, 5841, 5702, 5711, 5533, 6216, 6207, 6470, 5517, 5966};

struct PartRange {
  HeadPart part;
  std::size_t end;  // first vertex after it
};
constexpr std::array<PartRange, 9> kParts{{{HeadPart::face, 9409},
                                           {HeadPart::scalp_neck, 11248},
                                           {HeadPart::mouth_socket, 13294},
                                           {HeadPart::left_eye_socket, 13678},
                                           {HeadPart::right_eye_socket, 14062},
                                           {HeadPart::gums_tongue, 17039},
                                           {HeadPart::teeth, 21451},
                                           {HeadPart::left_eyeball, 23021},
                                           {HeadPart::right_eyeball, kVertices}}};

Error bad_folder(const fs::path& where, std::string what) {
  return {ErrorCode::bad_input, std::move(what),
          "Choose the folder FaceXModel of ICT-FaceKit (https://github.com/ICT-VGL/ICT-FaceKit), complete "
          "and unchanged.",
          where.string()};
}

// The folder with the meshes: this one, or FaceXModel in it.
std::optional<fs::path> mesh_folder(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::path& candidate : {folder, folder / "FaceXModel"})
    if (fs::is_regular_file(candidate / kNeutral, ignored)) return candidate;
  return std::nullopt;
}

struct FolderFiles {
  std::vector<fs::path> identities, expressions;
  std::vector<std::string> expression_names;
};

FolderFiles find_meshes(const fs::path& meshes) {
  std::error_code ignored;
  FolderFiles files;
  for (int i = 0; i < kMaxIdentities; ++i) {
    const fs::path file = meshes / fmt::format("identity{:03}.obj", i);
    if (!fs::is_regular_file(file, ignored)) break;
    files.identities.push_back(file);
  }
  for (const char* name : kExpressions) {
    const fs::path file = meshes / (std::string(name) + ".obj");
    if (!fs::is_regular_file(file, ignored)) continue;
    files.expressions.push_back(file);
    files.expression_names.push_back(name);
  }
  return files;
}

// One morph target minus the neutral, m, into a column.
std::optional<Error> read_target(const fs::path& file, const std::vector<Vec3f>& neutral_cm,
                                 Eigen::Ref<Eigen::VectorXf> column) {
  const auto bytes = read_file(file);
  if (!bytes) return bytes.error();
  const auto mesh = parse_obj(*bytes, file.string(), false);
  if (!mesh) return mesh.error();
  if (mesh->vertices.size() != neutral_cm.size())
    return bad_folder(file, fmt::format("{} has {} vertices where the neutral mesh has {}.", file.string(),
                                        mesh->vertices.size(), neutral_cm.size()));
  for (std::size_t v = 0; v < kVertices; ++v)
    column.segment<3>(3 * Eigen::Index(v)) = kMetrePerCentimetre * (mesh->vertices[v] - neutral_cm[v]);
  return std::nullopt;
}

std::optional<Error> read_targets(const std::vector<fs::path>& files, const std::vector<Vec3f>& neutral_cm,
                                  Eigen::MatrixXf& basis) {
  basis.resize(3 * Eigen::Index(kVertices), Eigen::Index(files.size()));
  std::vector<std::optional<Error>> errors(files.size());
  parallel_for(files.size(), [&](std::size_t i) {
    errors[i] = read_target(files[i], neutral_cm, basis.col(Eigen::Index(i)));
  });
  for (const auto& error : errors)
    if (error) return error;
  return std::nullopt;
}

// Centre of the sphere that most of an eyeball's vertices lie on; iris and pupil do not, and drop out.
Vec3d sphere_centre(std::vector<Vec3d> points) {
  Vec3d centre = Vec3d::Zero();
  for (int round = 0; round < 4 && points.size() > 8; ++round) {
    Eigen::MatrixXd a(points.size(), 4);
    Eigen::VectorXd b(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      a.row(Eigen::Index(i)) << 2 * points[i].transpose(), 1;
      b[Eigen::Index(i)] = points[i].squaredNorm();
    }
    const Eigen::Vector4d solution = solve_symmetric<4>(a.transpose() * a, a.transpose() * b);
    centre = solution.head<3>();
    const double radius = std::sqrt(std::max(0.0, solution[3] + centre.squaredNorm()));
    std::vector<Vec3d> on;
    for (const Vec3d& p : points)
      if (std::abs((p - centre).norm() - radius) < 0.04 * radius) on.push_back(p);
    if (on.size() < points.size() / 4 || on.size() == points.size()) break;
    points = std::move(on);
  }
  return centre;
}

// Of all weights over these vertices that sum to one and put their mean at the joint, the ones closest to
// equal.
bool regress_joint_on(const HeadModel& model, const Vec3d& joint, const std::vector<int>& vertices,
                      Eigen::MatrixXf& regressor, int row) {
  const Eigen::Index n = Eigen::Index(vertices.size());
  if (n < 8) return false;
  Eigen::MatrixXd a(4, n);
  for (Eigen::Index k = 0; k < n; ++k)
    a.col(k) << model.vertices[std::size_t(vertices[std::size_t(k)])].cast<double>(), 1;
  const Eigen::VectorXd equal = Eigen::VectorXd::Constant(n, 1.0 / double(n));
  const Eigen::Vector4d wanted(joint.x(), joint.y(), joint.z(), 1);
  const Eigen::Matrix4d gram = a * a.transpose();
  const Eigen::VectorXd w = equal + a.transpose() * solve_symmetric<4>(gram, wanted - a * equal);
  if (!w.allFinite()) return false;
  for (Eigen::Index k = 0; k < n; ++k) regressor(row, vertices[std::size_t(k)]) = float(w[k]);
  return true;
}

bool lay_joints(HeadModel& model) {
  model.joint_regressor = Eigen::MatrixXf::Zero(kJointCount, model.vertex_count());
  const auto select = [&](auto&& wanted) {
    std::vector<int> chosen;
    for (int v = 0; v < model.vertex_count(); ++v)
      if (wanted(model.parts[std::size_t(v)], model.vertices[std::size_t(v)])) chosen.push_back(v);
    return chosen;
  };
  const auto skin = [](HeadPart part) { return part == HeadPart::face || part == HeadPart::scalp_neck; };
  const auto ring = [&](const Vec3d& joint, float half) {
    return select([&, half](HeadPart part, const Vec3f& p) {
      return skin(part) && std::abs(p.y() - float(joint.y())) < half && std::abs(p.x()) < 0.1f;
    });
  };
  bool good = regress_joint_on(model, kRootJoint, ring(kRootJoint, 0.012f), model.joint_regressor, kRoot) &&
              regress_joint_on(model, kNeckJoint, ring(kNeckJoint, 0.014f), model.joint_regressor, kNeck) &&
              regress_joint_on(model, kJawJoint, select([&](HeadPart part, const Vec3f& p) {
                                 return skin(part) && std::abs(p.y() - float(kJawJoint.y())) < 0.014f &&
                                        p.z() > -0.025f && p.z() < 0.06f;
                               }),
                               model.joint_regressor, kJaw);
  for (const auto& [part, joint] :
       {std::pair{HeadPart::left_eyeball, kLeftEye}, std::pair{HeadPart::right_eyeball, kRightEye}}) {
    const std::vector<int> ball = select([part = part](HeadPart p, const Vec3f&) { return p == part; });
    std::vector<Vec3d> points;
    for (const int v : ball) points.push_back(model.vertices[std::size_t(v)].cast<double>());
    good = good && regress_joint_on(model, sphere_centre(points), ball, model.joint_regressor, joint);
  }
  return good;
}

double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Weights, and the corrective that makes the jaw's turn equal to the jawOpen shape everywhere.
void lay_skin(HeadModel& model, const Eigen::VectorXf& jaw_open) {
  const Mat3d turn = rotation_about(Vec3d::UnitX(), kJawAngle);
  constexpr double kSteady = 0.001;  // m: near the axis the turn moves too little to determine a weight
  constexpr Eigen::Index kSineFeature = 9 + 7;  // R(2, 1) of the jaw, the second of four joints
  model.skinning_weights = Eigen::MatrixXf::Zero(model.vertex_count(), kJointCount);
  model.pose_basis = Eigen::MatrixXf::Zero(3 * model.vertex_count(), kPoseFeatureCount);
  for (int v = 0; v < model.vertex_count(); ++v) {
    const HeadPart part = model.parts[std::size_t(v)];
    if (part == HeadPart::left_eyeball || part == HeadPart::right_eyeball) {
      model.skinning_weights(v, part == HeadPart::left_eyeball ? kLeftEye : kRightEye) = 1;
      continue;
    }
    const Vec3d p = model.vertices[std::size_t(v)].cast<double>();
    const Vec3d moved = jaw_open.segment<3>(3 * v).cast<double>(),
                full = turn * (p - kJawJoint) + kJawJoint - p;
    const double above = smoothstep(-0.165, -0.075, p.y());  // the neck turns, the shoulders do not
    const double share = moved.dot(full) / (full.squaredNorm() + kSteady * kSteady);
    const double jaw = above * std::clamp(share, 0.0, 1.0);
    model.skinning_weights(v, kJaw) = float(jaw);
    model.skinning_weights(v, kNeck) = float(above - jaw);
    model.skinning_weights(v, kRoot) = float(1 - above);
    // The corrective comes before the skinning, which carries it: blended = (1 - w) I + w R.
    const Mat3d blended = (1 - jaw) * Mat3d::Identity() + jaw * turn;
    const Vec3d corrective = blended.inverse() * (moved - jaw * full) / std::sin(kJawAngle);
    model.pose_basis.block<3, 1>(3 * v, kSineFeature) = corrective.cast<float>();
  }
}

bool lay_landmarks(HeadModel& model) {
  for (std::size_t l = 0; l < kLandmarkVertices.size(); ++l) {
    const int wanted = kLandmarkVertices[l];
    bool found = false;
    for (std::size_t t = 0; t < model.triangles.size() && !found; ++t)
      for (int k = 0; k < 3 && !found; ++k)
        if (model.triangles[t][k] == wanted) {
          model.landmark_triangle[l] = int(t);
          model.landmark_barycentric[l] = Vec3f::Unit(k);
          found = true;
        }
    if (!found) return false;
  }
  return true;
}

}  // namespace

std::vector<fs::path> ict_folder_files(const fs::path& folder) {
  const auto meshes = mesh_folder(folder);
  if (!meshes) return {};
  FolderFiles files = find_meshes(*meshes);
  std::vector<fs::path> all{*meshes / kNeutral};
  all.insert(all.end(), files.identities.begin(), files.identities.end());
  all.insert(all.end(), files.expressions.begin(), files.expressions.end());
  return all;
}

Result<HeadModel> load_ict_folder(const fs::path& folder) {
  const auto meshes = mesh_folder(folder);
  if (!meshes) return bad_folder(folder, fmt::format("{} has no {}.", folder.string(), kNeutral));
  const fs::path neutral_file = *meshes / kNeutral;
  const auto bytes = read_file(neutral_file);
  if (!bytes) return bytes.error();
  const auto neutral = parse_obj(*bytes, neutral_file.string());
  if (!neutral) return neutral.error();
  if (neutral->vertices.size() < kVertices)
    return bad_folder(neutral_file, fmt::format("{} has {} vertices; ICT-FaceKit's mesh has 26719.",
                                                neutral_file.string(), neutral->vertices.size()));
  const FolderFiles files = find_meshes(*meshes);
  const auto open = std::find(files.expression_names.begin(), files.expression_names.end(), kJawOpen);
  if (open == files.expression_names.end())
    return bad_folder(folder, fmt::format("{} has no {}.obj.", meshes->string(), kJawOpen));

  HeadModel model;
  model.name = "ICT-FaceKit";
  for (std::size_t v = 0; v < kVertices; ++v)
    model.vertices.push_back(kMetrePerCentimetre * neutral->vertices[v]);
  for (const PartRange& range : kParts) model.parts.resize(range.end, range.part);
  for (const Triangle& t : neutral->triangles)
    if (std::size_t(t.maxCoeff()) < kVertices) model.triangles.push_back(t);
  for (const auto& [list, basis] : {std::pair{&files.identities, &model.identity_basis},
                                    std::pair{&files.expressions, &model.expression_basis}})
    if (const auto error = read_targets(*list, neutral->vertices, *basis)) return *error;
  model.expression_names = files.expression_names;
  model.expression_min = Eigen::VectorXf::Zero(model.expression_count());
  model.expression_max = Eigen::VectorXf::Ones(model.expression_count());
  if (!lay_joints(model) || !lay_landmarks(model))
    return bad_folder(
        folder, fmt::format("{} is not a head mesh in ICT-FaceKit's vertex order.", neutral_file.string()));
  draw_landmarks(model, ict_shifts());
  lay_skin(model, model.expression_basis.col(open - files.expression_names.begin()));
  model.actions = make_named_actions(model);
  model.hash = content_hash(model);
  return model;
}

}  // namespace likeness
