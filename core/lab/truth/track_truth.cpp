// Alignment, pose errors and correlations: see track_truth.h.
#include "core/lab/truth/track_truth.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/mean_rotation.h"
#include "core/base/path_text.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/head/action_amounts.h"
#include "core/head/builtin_head.h"
#include "core/head/load_head_model.h"
#include "core/head/pose_head.h"
#include "core/project/project_views.h"
#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;
constexpr double kMinSpread = 0.02;  // of a true curve: less gives no meaningful correlation
constexpr float kEyesShut = 0.5f;    // of eyeBlink: beyond it no tracker sees the gaze

// One frame in both tracks, seen from its camera.
struct Pair {
  const TrackedFrame* truth = nullptr;
  const TrackedFrame* estimate = nullptr;
  Pose cam_from_truth = Pose::Identity(), cam_from_estimate = Pose::Identity();
};

double angle_between(const Mat3d& a, const Mat3d& b) { return rotation_angle(a.transpose() * b); }

// Each frame is weighted by the inverse of its residual, so that a few bad ones do not move the offset.
TruthAlignment align(const std::vector<Pair>& pairs, const Vec3d& eyes) {
  TruthAlignment alignment;
  Mat3d turn = Mat3d::Identity();
  for (int round = 0; round < 10; ++round) {
    Mat3d sum = Mat3d::Zero();
    for (const Pair& p : pairs) {
      const Mat3d between = p.cam_from_truth.linear().transpose() * p.cam_from_estimate.linear();
      sum += between / std::max(1e-3, round == 0 ? 1.0 : angle_between(between, turn));
    }
    turn = nearest_rotation(sum);
  }
  alignment.truth_head_from_head.linear() = turn;
  // R_T (turn s q + x) + t_T = s (R_E q + t_E) for the eyes' midpoint q, linear in (x, s).
  Eigen::Vector4d solution(0, 0, 0, 1);
  for (int round = 0; round < 20; ++round) {
    Eigen::Matrix4d normal = 1e-9 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const Pair& p : pairs) {
      Eigen::Matrix<double, 3, 4> rows;
      rows.leftCols<3>() = p.cam_from_truth.linear();
      rows.col(3) = p.cam_from_truth.linear() * (turn * eyes) - p.cam_from_estimate * eyes;
      const Vec3d target = -p.cam_from_truth.translation();
      const double weight = round == 0 ? 1 : 1 / std::max(1e-4, (rows * solution - target).norm());
      normal += weight * rows.transpose() * rows;
      right += weight * rows.transpose() * target;
    }
    solution = normal.ldlt().solve(right);
  }
  alignment.scale = solution[3];
  alignment.truth_head_from_head.translation() = solution.head<3>();
  return alignment;
}

PoseErrors pose_errors(const std::vector<Pair>& pairs, const TruthAlignment& a, const Vec3d& eyes) {
  std::vector<double> turn, along, across;
  for (const Pair& p : pairs) {
    const Pose truth = p.cam_from_truth * a.truth_head_from_head;
    turn.push_back(angle_between(truth.linear(), p.cam_from_estimate.linear()) * kDegreesPerRadian);
    const Vec3d at = truth * Vec3d(a.scale * eyes), found = a.scale * (p.cam_from_estimate * eyes);
    const Vec3d view = at.normalized(), error = found - at;
    along.push_back(100 * std::abs(error.dot(view)) / at.norm());
    across.push_back(1000 * (error - error.dot(view) * view).norm());
  }
  return {quantile(turn, 0.5),   quantile(turn, 0.95),  quantile(along, 0.5),
          quantile(along, 0.95), quantile(across, 0.5), quantile(across, 0.95)};
}

// Mean of both eyes: +yaw to the subject's left, +pitch up, rad.
Vec2d gaze_of(const Articulation& a) {
  return {0.5 * double(a.left_eye.y() + a.right_eye.y()), -0.5 * double(a.left_eye.x() + a.right_eye.x())};
}

std::vector<TruthCorrelation> correlations(const std::vector<Pair>& pairs, const ActionBasis& truth_basis,
                                           const ActionBasis& basis) {
  std::vector<Eigen::VectorXf> truth, found;
  for (const Pair& p : pairs) {
    truth.push_back(face_amounts(truth_basis, p.truth->pose.articulation));
    found.push_back(face_amounts(basis, p.estimate->pose.articulation));
  }
  std::vector<TruthCorrelation> list;
  std::vector<double> a, b;
  for (const std::string& name : compared_actions()) {
    const int t = action_index(truth_basis, name), f = action_index(basis, name);
    a.clear(), b.clear();
    for (std::size_t i = 0; t >= 0 && f >= 0 && i < pairs.size(); ++i)
      a.push_back(truth[i][t]), b.push_back(found[i][f]);
    list.push_back({name, course_correlation(a, b)});
  }
  const int blink = action_index(truth_basis, "eyeBlink_L");
  for (const int axis : {0, 1}) {
    a.clear(), b.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (blink >= 0 && truth[i][blink] > kEyesShut) continue;
      a.push_back(gaze_of(pairs[i].truth->pose.articulation)[axis]);
      b.push_back(gaze_of(pairs[i].estimate->pose.articulation)[axis]);
    }
    list.push_back({axis == 0 ? "gazeYaw" : "gazePitch", course_correlation(a, b)});
  }
  return list;
}

}  // namespace

std::optional<double> course_correlation(const std::vector<double>& truth, const std::vector<double>& found) {
  const std::size_t n = truth.size();
  if (n < 5) return std::nullopt;
  double mt = 0, mf = 0, tt = 0, ff = 0, tf = 0;
  for (std::size_t i = 0; i < n; ++i) mt += truth[i] / double(n), mf += found[i] / double(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double t = truth[i] - mt, f = found[i] - mf;
    tt += t * t, ff += f * f, tf += t * f;
  }
  if (std::sqrt(tt / double(n)) < kMinSpread) return std::nullopt;
  return ff > 0 ? tf / std::sqrt(tt * ff) : 0.0;
}

const std::vector<std::string>& compared_actions() {
  static const std::vector<std::string> names{"jawOpen",       "mouthSmile_L",  "mouthSmile_R", "mouthPucker",
                                              "browInnerUp_L", "browInnerUp_R", "eyeBlink_L",   "eyeBlink_R"};
  return names;
}

Result<TrackTruth> read_track_truth(const fs::path& folder) {
  TrackTruth truth;
  auto track = read_track(folder / "track_truth.json");
  if (!track) return track.error();
  truth.track = std::move(*track);
  auto cameras = read_cameras(folder / "cameras_truth.json");
  if (!cameras) return cameras.error();
  truth.cameras = std::move(*cameras);
  if (truth.track.head_model_file.empty()) {
    truth.model = make_builtin_head();
  } else {
    auto model = load_head_model(path_of_text(truth.track.head_model_file));
    if (!model) return model.error();
    truth.model = std::move(*model);
  }
  if (truth.model.hash != truth.track.head_model_hash) {
    return Error{
        ErrorCode::bad_input,
        fmt::format("The truth was written with another {} head than this one.", truth.track.head_model_name),
        "Write the demo again: likeness demo FOLDER", folder.string()};
  }
  if (const auto fits = check_track_fits(truth.track, truth.model); !fits)
    return Error{ErrorCode::bad_input, fits.error().what, "Write the demo again: likeness demo FOLDER",
                 folder.string()};
  return truth;
}

namespace {

// Distance of these vertices of the fitted head, aligned, to the true head's skin at rest, rms, m.
double distance_to_truth(const std::vector<Vec3f>& vertices, const std::vector<int>& chosen,
                         const HeadModel& truth_model, const PersonShape& truth,
                         const TruthAlignment& alignment) {
  const MeshScene surface(shape_head(truth_model, truth).vertices,
                          region_triangles(truth_model, head_regions(truth_model).skin));
  double sum = 0;
  int count = 0;
  for (const int v : chosen) {
    const Vec3d at = alignment.truth_head_from_head * Vec3d(alignment.scale * vertices[v].cast<double>());
    const auto nearest = surface.closest(at.cast<float>());
    if (!nearest) continue;
    sum += double(nearest->distance) * nearest->distance;
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

std::vector<int> face_vertices(const HeadModel& model) {
  const HeadRegions regions = head_regions(model);
  std::vector<std::uint8_t> face_skin(model.triangles.size());
  for (std::size_t t = 0; t < face_skin.size(); ++t) face_skin[t] = regions.face[t] && regions.skin[t];
  return region_vertices(model, face_skin);
}

}  // namespace

double shape_error(const HeadModel& model, const PersonShape& fitted, const HeadModel& truth_model,
                   const PersonShape& truth, const TruthAlignment& alignment) {
  return distance_to_truth(shape_head(model, fitted).vertices, face_vertices(model), truth_model, truth,
                           alignment);
}

RestError rest_error(const HeadModel& model, const PersonShape& fitted, const Articulation& neutral,
                     const HeadModel& truth_model, const PersonShape& truth,
                     const TruthAlignment& alignment) {
  constexpr float kMouth = 0.010f;  // m around the lips' landmarks
  const std::vector<Vec3f> posed = pose_head(model, shape_head(model, fitted), neutral);
  const auto own = landmark_positions(model, posed),
             true_ones = landmark_positions(truth_model, shape_head(truth_model, truth).vertices);
  std::vector<int> mouth = face_vertices(model);
  std::erase_if(mouth, [&](int v) {
    return std::none_of(own.begin() + 48, own.end(),
                        [&](const Vec3f& p) { return (p - posed[std::size_t(v)]).norm() < kMouth; });
  });
  return {1000 * distance_to_truth(posed, mouth, truth_model, truth, alignment),
          1000 * (alignment.scale * double((own[54] - own[48]).norm()) -
                  double((true_ones[54] - true_ones[48]).norm()))};
}

Result<TruthComparison> compare_with_truth(const Track& estimate, const HeadModel& model,
                                           const TrackTruth& truth, const std::set<int>& held_out) {
  const HeadShape shape = shape_head(model, estimate.person);
  const Vec3d eyes = 0.5 * (shape.joints[kLeftEye] + shape.joints[kRightEye]).cast<double>();
  TruthComparison result;
  std::vector<Pair> training, tested;
  for (const TrackedFrame& frame : estimate.frames) {
    const TrackedFrame* true_frame = find_tracked(truth.track, frame.frame);
    const Camera* camera = find_camera(truth.cameras, frame.frame);
    if (true_frame == nullptr || camera == nullptr) continue;
    const bool is_held_out = held_out.contains(frame.frame);
    TruthScore& score = is_held_out ? result.held_out : result.training;
    ++score.frames;
    score.good += frame.status == FrameStatus::good;
    score.weak += frame.status == FrameStatus::weak;
    score.lost += frame.status == FrameStatus::lost;
    if (frame.status == FrameStatus::lost) continue;
    (is_held_out ? tested : training)
        .push_back({true_frame, &frame, camera->cam_from_world * true_frame->pose.world_from_head,
                    camera->cam_from_world * frame.pose.world_from_head});
  }
  if (training.size() < 5) {
    return Error{ErrorCode::failed,
                 fmt::format("Only {} training frames are tracked, too few to compare.", training.size()),
                 "Use a longer demo, or look at the track's overlay for what went wrong.", "study truth"};
  }
  result.alignment = align(training, eyes);
  const ActionBasis truth_basis = action_basis(truth.model), basis = action_basis(model);
  result.shape_rms_mm =
      1000 * shape_error(model, estimate.person, truth.model, truth.track.person, result.alignment);
  const bool calibrated = estimate.neutral.expression.size() == model.expression_count();
  result.rest =
      rest_error(model, estimate.person, calibrated ? estimate.neutral : neutral_articulation(model),
                 truth.model, truth.track.person, result.alignment);
  result.training.pose = pose_errors(training, result.alignment, eyes);
  result.training.correlations = correlations(training, truth_basis, basis);
  result.held_out.pose = pose_errors(tested, result.alignment, eyes);
  result.held_out.correlations = correlations(tested, truth_basis, basis);
  return result;
}

}  // namespace likeness
