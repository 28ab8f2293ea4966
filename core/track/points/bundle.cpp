#include "core/track/points/bundle.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>

#include "core/base/dense_solves.h"
#include "core/base/mean_rotation.h"
#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

using PoseBlock = std::array<double, 6>;  // rotation vector, translation

PoseBlock block_from(const Pose& pose) {
  const Vec3d w = vector_from_turn(pose.linear()), t = pose.translation();
  return {w.x(), w.y(), w.z(), t.x(), t.y(), t.z()};
}

Pose pose_from(const PoseBlock& b) {
  Pose pose = Pose::Identity();
  pose.linear() = turn_from_vector({b[0], b[1], b[2]});
  pose.translation() = Vec3d(b[3], b[4], b[5]);
  return pose;
}

struct Reprojection {
  Vec2d ray;
  double focal_px;
  template <class T>
  bool operator()(const T* pose, const T* point, T* residual) const {
    T p[3];
    ceres::AngleAxisRotatePoint(pose, point, p);
    const T z = p[2] + pose[5];
    residual[0] = ((p[0] + pose[3]) / z - T(ray.x())) * T(focal_px);
    residual[1] = ((p[1] + pose[4]) / z - T(ray.y())) * T(focal_px);
    return true;
  }
};

struct PosePrior {
  Mat3d head_from_cam;  // transposed prior rotation
  Vec3d translation;
  double turn_weight, shift_weight;
  template <class T>
  bool operator()(const T* pose, T* residual) const {
    T turn[9], off[9], vector[3];  // column-major
    ceres::AngleAxisToRotationMatrix(pose, turn);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        off[3 * c + r] = T(0);
        for (int k = 0; k < 3; ++k) off[3 * c + r] += turn[3 * k + r] * T(head_from_cam(k, c));
      }
    ceres::RotationMatrixToAngleAxis(off, vector);
    for (int k = 0; k < 3; ++k) {
      residual[k] = T(turn_weight) * vector[k];
      residual[3 + k] = T(shift_weight) * (pose[3 + k] - T(translation[k]));
    }
    return true;
  }
};

// b halfway (by `share`) between a and c; on rotation vectors; the blocks are kept clear of their
// wrap-around.
struct Smooth {
  double share, turn_weight, shift_weight;
  template <class T>
  bool operator()(const T* a, const T* b, const T* c, T* residual) const {
    for (int k = 0; k < 6; ++k)
      residual[k] = T(k < 3 ? turn_weight : shift_weight) * (b[k] - T(1 - share) * a[k] - T(share) * c[k]);
    return true;
  }
};

// The point about which the head turns, and its depth while it rests.
struct NeckRest {
  Vec3d place = Vec3d::Zero();  // head frame, m
  double depth = 0;             // camera frame, m
};

struct NeckDepth {
  NeckRest rest;
  double weight;
  template <class T>
  bool operator()(const T* pose, T* residual) const {
    const T place[3] = {T(rest.place.x()), T(rest.place.y()), T(rest.place.z())};
    T turned[3];
    ceres::AngleAxisRotatePoint(pose, place, turned);
    residual[0] = T(weight) * (turned[2] + pose[5] - T(rest.depth));
    return true;
  }
};

// For coordinates `first` and, if it exists, `first` + 1: rows of two, like those of the reprojections. Ceres
// has its elimination of points compiled for a uniform row height, which is three to five times as fast.
struct PointPrior {
  Vec3d start;
  double weight;
  int first;
  template <class T>
  bool operator()(const T* point, T* residual) const {
    for (int k = 0; k < 2; ++k)
      residual[k] = first + k < 3 ? T(weight) * (point[first + k] - T(start[first + k])) : T(0);
    return true;
  }
};

// Ends a solve between two iterations when asked to stop.
class StopBetweenIterations : public ceres::IterationCallback {
 public:
  explicit StopBetweenIterations(std::stop_token stop) : stop_(std::move(stop)) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return stop_.stop_requested() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  std::stop_token stop_;
};

double residual_px(const BundleFrame& frame, const Vec3d& point, const Vec2d& ray) {
  const Vec3d p = frame.cam_from_head * point;
  if (p.z() < 1e-3) return 1e6;
  return (p.hnormalized() - ray).norm() * frame.focal_px;
}

// A rotation vector of nearly pi flips sign from frame to frame; the frames' blocks are made continuous.
void unwrap(PoseBlock& block, const PoseBlock& before) {
  const Vec3d w(block[0], block[1], block[2]), b(before[0], before[1], before[2]);
  const double angle = w.norm();
  if (angle < 1e-9) return;
  const Vec3d other = w * (1 - 2 * std::acos(-1.0) / angle);
  if ((other - b).norm() < (w - b).norm())
    for (int k = 0; k < 3; ++k) block[k] = other[k];
}

// The point that moves least as the head turns: R place + t = rest, by least squares with errors linear
// beyond kNeckSway.
NeckRest find_neck(const std::vector<BundleFrame>& frames, const std::vector<int>& keys) {
  constexpr double kNeckSway = 0.004;  // m
  constexpr double kNeckReach = 0.05;  // m from the model's origin; only turns determine it
  Eigen::Matrix<double, 6, 1> solution = Eigen::Matrix<double, 6, 1>::Zero();  // place, rest
  for (int round = 0; round < 10; ++round) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (const int k : keys) {
      Eigen::Matrix<double, 3, 6> rows;
      rows << frames[k].cam_from_head.linear(), -Mat3d::Identity();
      const Vec3d target = -frames[k].cam_from_head.translation();
      const double error = (rows * solution - target).norm();
      const double weight = round == 0 ? 1 : kNeckSway / std::max(kNeckSway, error);
      normal += weight * rows.transpose() * rows;
      right += weight * rows.transpose() * target;
    }
    normal.diagonal().head<3>().array() +=
        double(keys.size()) * kNeckSway * kNeckSway / (kNeckReach * kNeckReach);
    solution = solve_symmetric<6>(normal, right);
  }
  return {solution.head<3>(), solution[5]};
}

// Whether the neck keeps its depth in the given poses: not if the person comes nearer or the camera moves
// back.
bool neck_rests(const std::vector<BundleFrame>& frames, const std::vector<int>& keys) {
  constexpr double kRoam = 0.05, kRoaming = 0.2;  // m; share of the frames
  const NeckRest neck = find_neck(frames, keys);
  const auto away = std::ranges::count_if(
      keys, [&](int k) { return std::abs((frames[k].cam_from_head * neck.place).z() - neck.depth) > kRoam; });
  return double(away) <= kRoaming * double(keys.size());
}

double turn_of(const std::vector<BundleFrame>& frames, const std::vector<int>& keys) {
  std::vector<Mat3d> turns;
  for (const int k : keys) turns.push_back(frames[k].cam_from_head.linear());
  return turn_about_mean(turns);
}

double point_prior_for(double turn, const BundleOptions& options) {
  const double most = std::max(options.max_point_prior, options.point_prior);
  return std::clamp(options.point_prior * options.full_turn / std::max(turn, 1e-6), options.point_prior,
                    most);
}

void solve_round(std::vector<BundleFrame>& frames, const std::vector<BundleFrame>& priors,
                 std::vector<BundleTrack>& tracks, const std::vector<Vec3d>& starts,
                 const std::vector<int>& keys, const BundleOptions& options, double loss_px,
                 const std::stop_token& stop) {
  std::vector<int> slot(frames.size(), -1);
  std::vector<PoseBlock> blocks(keys.size());
  for (std::size_t k = 0; k < keys.size(); ++k) {
    slot[keys[k]] = static_cast<int>(k);
    blocks[k] = block_from(frames[keys[k]].cam_from_head);
    if (k > 0) unwrap(blocks[k], blocks[k - 1]);
  }
  ceres::Problem problem;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (!tracks[t].kept) continue;
    int used = 0;
    for (const BundleObservation& o : tracks[t].seen) used += slot[o.frame] >= 0;
    if (used < 3) continue;
    for (const BundleObservation& o : tracks[t].seen)
      if (slot[o.frame] >= 0)
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Reprojection, 2, 6, 3>(
                                     new Reprojection{o.ray, frames[o.frame].focal_px}),
                                 new ceres::CauchyLoss(loss_px), blocks[slot[o.frame]].data(),
                                 tracks[t].point.data());
    for (const int first : {0, 2})
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PointPrior, 2, 3>(
                                   new PointPrior{starts[t], options.point_prior, first}),
                               nullptr, tracks[t].point.data());
    ordering->AddElementToGroup(tracks[t].point.data(), 0);
  }
  const NeckRest neck = find_neck(frames, keys);
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (options.neck_rest > 0)
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<NeckDepth, 1, 6>(new NeckDepth{neck, options.neck_rest}),
          new ceres::HuberLoss(1.0), blocks[k].data());
    const Pose& prior = priors[keys[k]].cam_from_head;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PosePrior, 6, 6>(new PosePrior{
            prior.linear().transpose(), prior.translation(), options.turn_prior, options.shift_prior}),
        new ceres::CauchyLoss(1.0), blocks[k].data());
    ordering->AddElementToGroup(blocks[k].data(), 1);
    if (k == 0 || k + 1 == keys.size()) continue;
    const double before = keys[k] - keys[k - 1], after = keys[k + 1] - keys[k];
    const double relax = before * after;  // a second difference grows with the square of the step
    if (before + after > 20) continue;
    if (frames[keys[k - 1]].shot != frames[keys[k + 1]].shot) continue;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Smooth, 6, 6, 6, 6>(
            new Smooth{before / (before + after), options.turn_smooth / relax, options.shift_smooth / relax}),
        nullptr, blocks[k - 1].data(), blocks[k].data(), blocks[k + 1].data());
  }
  ceres::Solver::Options solver;
  // Points reappear throughout a clip, so the reduced system is dense even if stored as sparse.
  solver.linear_solver_type =
      int(keys.size()) <= options.max_dense ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = 20;
  solver.function_tolerance = 1e-4;
  solver.num_threads = 1;  // sums in one order: the same clip gives the same track
  solver.logging_type = ceres::SILENT;
  StopBetweenIterations callback(stop);
  solver.callbacks.push_back(&callback);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (std::size_t k = 0; k < keys.size(); ++k) frames[keys[k]].cam_from_head = pose_from(blocks[k]);
}

// Frames between the key frames, against the frozen points.
void solve_others(std::vector<BundleFrame>& frames, const std::vector<BundleTrack>& tracks,
                  const std::vector<int>& keys, const BundleOptions& options) {
  std::vector<bool> is_key(frames.size(), false);
  for (int k : keys) is_key[k] = true;
  std::vector<std::vector<PoseObservation>> seen(frames.size());
  for (const BundleTrack& t : tracks)
    if (t.kept)
      for (const BundleObservation& o : t.seen)
        if (!is_key[o.frame]) seen[o.frame].push_back({t.point, o.ray});
  parallel_for(frames.size(), [&](std::size_t f) {
    if (is_key[f] || !frames[f].known) return;
    if (const auto pose = solve_pose(seen[f], frames[f].focal_px, frames[f].cam_from_head, options))
      frames[f].cam_from_head = pose->cam_from_head;
  });
}

void drop_outliers(const std::vector<BundleFrame>& frames, std::vector<BundleTrack>& tracks, double track_px,
                   double single_px, std::size_t shortest) {
  std::vector<double> residuals;
  for (BundleTrack& t : tracks) {
    if (!t.kept) continue;
    residuals.clear();
    for (const BundleObservation& o : t.seen)
      residuals.push_back(residual_px(frames[o.frame], t.point, o.ray));
    std::vector<BundleObservation> good;
    for (std::size_t i = 0; i < t.seen.size(); ++i)
      if (residuals[i] <= single_px) good.push_back(t.seen[i]);
    if (median(residuals) > track_px || good.size() < shortest)
      t.kept = false;
    else
      t.seen = std::move(good);
  }
}

}  // namespace

Result<BundleSummary> bundle_adjust(std::vector<BundleFrame>& frames, std::vector<BundleTrack>& tracks,
                                    const BundleOptions& options, const Progress& progress,
                                    std::stop_token stop) {
  const std::vector<BundleFrame> priors = frames;
  std::vector<Vec3d> starts;
  for (const BundleTrack& t : tracks) starts.push_back(t.point);
  std::vector<int> known, keys;
  for (std::size_t f = 0; f < frames.size(); ++f)
    if (frames[f].known) known.push_back(static_cast<int>(f));
  const auto stride_for = [&](int keys) {
    return (known.size() + std::size_t(keys) - 1) / std::size_t(keys);
  };
  const std::size_t stride = std::clamp<std::size_t>(
      stride_for(options.key_frames), 1, std::max<std::size_t>(4, stride_for(options.max_key_frames)));
  for (std::size_t k = 0; k < known.size(); k += stride) keys.push_back(known[k]);
  BundleOptions used = options;
  if (options.neck_rest > 0 && !neck_rests(frames, keys)) used.neck_rest = 0;
  used.point_prior = point_prior_for(turn_of(frames, keys), options);
  try {
    for (int round = 0; round < options.rounds; ++round) {
      if (stop.stop_requested()) return cancelled_error();
      progress.report(static_cast<double>(round) / options.rounds, "solving head poses and points together");
      solve_round(frames, priors, tracks, starts, keys, used, round == 0 ? 0.7 : 0.5, stop);
      if (stop.stop_requested()) return cancelled_error();
      solve_others(frames, tracks, keys, options);
      const bool first = round == 0;
      drop_outliers(frames, tracks, first ? 3 : 1.5, first ? 6 : 3, 8);
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return Error{ErrorCode::failed, "The bundle adjustment of the head failed: " + std::string(e.what()),
                 "Run the fit again without dense tracking, or report this message.", "dense tracks"};
  }
  BundleSummary summary;
  std::vector<double> residuals;
  for (const BundleTrack& t : tracks) {
    if (!t.kept) continue;
    ++summary.tracks;
    for (const BundleObservation& o : t.seen)
      residuals.push_back(residual_px(frames[o.frame], t.point, o.ray));
  }
  summary.observations = static_cast<int>(residuals.size());
  summary.median_px = median(residuals);
  progress.report(1);
  return summary;
}

std::optional<SolvedPose> solve_pose(const std::vector<PoseObservation>& seen, double focal_px,
                                     const Pose& prior, const BundleOptions& options) {
  if (seen.size() < 8) return std::nullopt;
  Pose pose = prior;
  for (double loss : {4.0, 1.5, 0.5}) {
    for (int iteration = 0; iteration < 10; ++iteration) {
      Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
      Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
      for (const PoseObservation& o : seen) {
        const Vec3d turned = pose.linear() * o.point, p = turned + pose.translation();
        const double z = std::max(1e-3, p.z());
        const Vec2d r = (p.head<2>() / z - o.ray) * focal_px;
        const double weight = 1 / (1 + r.squaredNorm() / (loss * loss));  // Cauchy
        Eigen::Matrix<double, 2, 3> by_cam;
        by_cam << 1 / z, 0, -p.x() / (z * z), 0, 1 / z, -p.y() / (z * z);
        by_cam *= focal_px;
        Eigen::Matrix<double, 2, 6> rows;
        for (int k = 0; k < 3; ++k) rows.col(k) = by_cam * Vec3d::Unit(k).cross(turned);
        rows.rightCols<3>() = by_cam;
        hessian += weight * rows.transpose() * rows;
        gradient += weight * rows.transpose() * r;
      }
      // The prior acts as one more robust observation: strong enough for a frame with few points, without
      // bias otherwise.
      const Vec3d turn = vector_from_turn(pose.linear() * prior.linear().transpose());
      const Vec3d shift = pose.translation() - prior.translation();
      const double off = options.turn_prior * options.turn_prior * turn.squaredNorm() +
                         options.shift_prior * options.shift_prior * shift.squaredNorm();
      const double wt = options.turn_prior * options.turn_prior / (1 + off),
                   ws = options.shift_prior * options.shift_prior / (1 + off);
      hessian.diagonal().head<3>().array() += wt;
      hessian.diagonal().tail<3>().array() += ws;
      gradient.head<3>() += wt * turn;
      gradient.tail<3>() += ws * shift;
      const Eigen::Matrix<double, 6, 1> step = -solve_symmetric<6>(hessian, gradient);
      if (!step.allFinite()) return std::nullopt;
      pose.linear() = turn_from_vector(step.head<3>()) * pose.linear();
      pose.translation() += step.tail<3>();
      if (step.norm() < 1e-7) break;
    }
  }
  pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  SolvedPose solved{pose, 0, 0};
  std::vector<double> residuals;
  for (const PoseObservation& o : seen) {
    const Vec3d p = pose * o.point;
    const double r = p.z() > 1e-3 ? (p.hnormalized() - o.ray).norm() * focal_px : 1e6;
    if (r < 3) residuals.push_back(r);
  }
  solved.inliers = static_cast<int>(residuals.size());
  solved.median_px = median(residuals);
  if (solved.inliers < 8) return std::nullopt;
  return solved;
}

}  // namespace likeness
