#include "core/face/fit_frame.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "core/base/check.h"
#include "core/base/dense_solves.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr double kHuber = 2.0;            // sigmas
constexpr double kJawLineWeight = 0.4;    // its landmarks are less certain than the inner ones
constexpr double kTangentWeight = 0.2;    // and slide along the line
constexpr double kBoundWeight = 12.0;     // per unit beyond the range
constexpr double kJawBoundWeight = 60.0;  // per rad
constexpr double kBlinkChange = 0.15;     // lids close within two frames; nothing else on a face does

bool starts_with_any(std::string_view name, std::initializer_list<std::string_view> prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](std::string_view p) { return name.starts_with(p); });
}

// Residual of one landmark in sigmas, and the 2x2 matrix that maps working pixels to it.
struct Weighted {
  Vec2d residual;
  Eigen::Matrix2d scale;
};
Weighted weigh(const FaceObservation& o, const JawLine& line, int i, const Vec2d& error_px) {
  Eigen::Matrix2d scale = Eigen::Matrix2d::Identity() / o.sigma_px[i];
  if (i < kJawLineCount) {
    const Vec2d n = line.normal[i], t(-n.y(), n.x());
    scale.row(0) = n.transpose() * (kJawLineWeight / o.sigma_px[i]);
    scale.row(1) = t.transpose() * (kJawLineWeight * kTangentWeight / o.sigma_px[i]);
  }
  return {scale * error_px, scale};
}

double huber(double norm) { return norm <= kHuber ? 0.5 * norm * norm : kHuber * (norm - 0.5 * kHuber); }

// Adds weight^2/2 (value - target)^2 on one unknown.
void add_pull(FrameSystem* s, int index, double weight, double difference) {
  s->cost += 0.5 * weight * weight * difference * difference;
  if (s->hessian.size() == 0) return;
  s->hessian(index, index) += weight * weight;
  s->gradient[index] += weight * weight * difference;
}

void add_priors(const ExpressionPrior& prior, const FramePull& pull, const FrameFitOptions& options,
                const FaceState& state, FrameSystem* s) {
  if (options.free_pose && pull.turn_weight > 0) {
    // turn increments act from the left: d vector_from_turn(R target^T) = increment, near the target
    const Vec3d turn =
        vector_from_turn(state.cam_from_head.linear() * pull.cam_from_head.linear().transpose());
    for (int k = 0; k < 3; ++k) add_pull(s, k, pull.turn_weight, turn[k]);
  }
  if (options.free_pose && pull.shift_weight > 0) {
    const Vec3d shift = state.cam_from_head.translation() - pull.cam_from_head.translation();
    for (int k = 0; k < 3; ++k) add_pull(s, 3 + k, pull.shift_weight, shift[k]);
  }
  if (!options.free_face) return;
  add_pull(s, 6, prior.jaw_weight, state.jaw);
  if (state.jaw < 0) add_pull(s, 6, kJawBoundWeight, state.jaw);
  if (state.jaw > prior.jaw_high) add_pull(s, 6, kJawBoundWeight, state.jaw - prior.jaw_high);
  if (pull.jaw_weight > 0) add_pull(s, 6, pull.jaw_weight, state.jaw - pull.jaw);
  for (int e = 0; e < state.expression.size(); ++e) {
    const double x = state.expression[e];
    add_pull(s, 7 + e, prior.weight[e], x - prior.rest[e]);
    if (x < prior.low[e]) add_pull(s, 7 + e, kBoundWeight, x - prior.low[e]);
    if (x > prior.high[e]) add_pull(s, 7 + e, kBoundWeight, x - prior.high[e]);
    if (pull.expression_weight > 0)
      add_pull(s, 7 + e, prior.change[e] * pull.expression_weight, x - pull.expression[e]);
  }
}

// The halves of a face move together, unless the evidence says otherwise.
void add_pairs(const ExpressionPrior& prior, const FaceState& state, FrameSystem* s) {
  const double w = prior.pair_weight * prior.pair_weight;
  for (const auto& [left, right] : prior.pairs) {
    const double apart =
        (state.expression[left] - prior.rest[left]) - (state.expression[right] - prior.rest[right]);
    s->cost += 0.5 * w * apart * apart;
    if (s->hessian.size() == 0) continue;
    const int l = 7 + left, r = 7 + right;
    s->hessian(l, l) += w, s->hessian(r, r) += w;
    s->hessian(l, r) -= w, s->hessian(r, l) -= w;
    s->gradient[l] += w * apart, s->gradient[r] -= w * apart;
  }
}

// Landmarks of the upper and the lower lid over each other: subject's right eye, left.
constexpr std::array<std::array<std::array<int, 2>, 2>, 2> kLidPairs{
    {{{{37, 41}, {38, 40}}}, {{{43, 47}, {44, 46}}}}};

// The lids' heights against the evidence for them; adds to rows and residuals of its own.
void add_lids(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
              const FaceState& state, bool derivatives, bool with_identity, FrameSystem* s) {
  for (int side = 0; side < 2; ++side) {
    const LidEvidence& lids = observation.lids[side];
    if (!lids.known) continue;
    const double r = (lid_gap(head, person, side, state.expression) - lids.gap_m) / lids.sigma_m;
    s->cost += huber(std::abs(r));
    if (!derivatives) continue;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(s->hessian.rows());
    for (const auto& [upper, lower] : kLidPairs[side]) {
      row.segment(7, head.expression_count()) +=
          0.5 * (head.expression.row(3 * upper + 1) - head.expression.row(3 * lower + 1)).transpose();
      if (with_identity)
        row.tail(head.identity_count()) +=
            0.5 * (head.identity.row(3 * upper + 1) - head.identity.row(3 * lower + 1)).transpose();
    }
    const double robust = std::abs(r) <= kHuber ? 1.0 : kHuber / std::abs(r);
    s->hessian.noalias() += robust / (lids.sigma_m * lids.sigma_m) * row * row.transpose();
    s->gradient += robust * r / lids.sigma_m * row;
  }
}

constexpr std::array<std::array<int, 2>, 3> kLipPairs{{{61, 67}, {62, 66}, {63, 65}}};  // upper over lower

// The lips' distance against the evidence for it.
void add_lips(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
              const FaceState& state, bool derivatives, bool with_identity, FrameSystem* s) {
  const LipEvidence& lips = observation.lips;
  if (!lips.known) return;
  const double r = (lip_gap(head, person, state) - lips.gap_m) / lips.sigma_m;
  s->cost += huber(std::abs(r));
  if (!derivatives) return;
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(s->hessian.rows());
  for (const auto& pair : kLipPairs)
    for (int k = 0; k < 2; ++k) {
      const double share = (k == 0 ? 1.0 : -1.0) / kLipPairs.size();
      PointDerivatives by;
      reduced_point(head, person, pair[k], state.expression, state.jaw, &by);
      row[6] += share * by.by_jaw.y();
      row.segment(7, head.expression_count()) +=
          share * by.by_shape.row(1) * head.expression.middleRows(3 * pair[k], 3);
      if (with_identity)
        row.tail(head.identity_count()) +=
            share * (by.by_shape.row(1) * head.identity.middleRows(3 * pair[k], 3) +
                     by.by_joint.row(1) * head.jaw_joint_identity);
    }
  const double robust = std::abs(r) <= kHuber ? 1.0 : kHuber / std::abs(r);
  s->hessian.noalias() += robust / (lips.sigma_m * lips.sigma_m) * row.transpose() * row;
  s->gradient += robust * r / lips.sigma_m * row.transpose();
}

}  // namespace

ExpressionPrior expression_prior(const HeadModel& model) {
  const int count = model.expression_count();
  ExpressionPrior p;
  p.weight = Eigen::VectorXd::Constant(count, 2.5);
  p.rest = Eigen::VectorXd::Zero(count);
  p.low = Eigen::VectorXd::Constant(count, 0.0);
  p.high = Eigen::VectorXd::Constant(count, 1.0);
  p.change = Eigen::VectorXd::Constant(count, 1.0);
  for (int e = 0; e < count; ++e) {
    if (model.expression_min.size() == count) p.low[e] = model.expression_min[e];
    if (model.expression_max.size() == count) p.high[e] = model.expression_max[e];
    if (static_cast<int>(model.expression_names.size()) != count) {
      // Statistical directions (FLAME): the range says how large a coefficient usually gets.
      p.weight[e] = 2.5 / std::max(1.0, 0.5 * (p.high[e] - p.low[e]));
      continue;
    }
    const std::string_view name = model.expression_names[e];
    // Shapes that move no landmark would explain noise for free, so they are penalised; blinks are clearly
    // seen.
    if (starts_with_any(
            name, {"eyeLook", "eyeSquint", "cheek", "noseSneer", "mouthRoll", "mouthPress", "mouthDimple",
                   "mouthShrug", "mouthClose", "jawLeft", "jawRight", "jawForward", "tongue"}))
      p.weight[e] = 20;
    else if (name.starts_with("eyeBlink"))
      p.weight[e] = 1.0, p.change[e] = kBlinkChange;
    else if (name == "jawOpen")
      p.weight[e] = 1e4;  // the jaw joint opens the mouth; both together are not observable
    // A pucker is far more common than a funnel, and both look alike from the side; an error of the head's
    // rotation looks like a stretched or frowning mouth, and so does a lopsided face like a mouth shifted
    // aside, which then takes over part of the pucker.
    else if (name == "mouthPucker")
      p.weight[e] = 1.5;
    else if (name == "mouthFunnel")
      p.weight[e] = 12;
    else if (starts_with_any(name, {"mouthLeft", "mouthRight"}))
      p.weight[e] = 30;
    else if (starts_with_any(name, {"mouthStretch", "mouthFrown"}))
      p.weight[e] = 6;
    if (!name.ends_with("_L") || name.starts_with("eye")) continue;
    const std::string other = std::string(name.substr(0, name.size() - 1)) + "R";
    for (int r = 0; r < count; ++r)
      if (model.expression_names[r] == other) p.pairs.push_back({e, r});
  }
  return p;
}

JawLine pick_jaw_line(const ReducedHead& head, const ReducedPerson& person,
                      const FaceObservation& observation, const FaceState& state) {
  JawLine line;
  const Mat3d turn = state.cam_from_head.linear();
  const auto facing = [&](int point,
                          const Vec3d& in_cam) {  // cosine between the normal and the way to the camera
    return -(turn * head.normals[point]).dot(in_cam.normalized());
  };
  for (int i = 0; i < kJawLineCount; ++i) {
    int best = i;
    const Vec3d own = state.cam_from_head * reduced_point(head, person, i, state.expression, state.jaw);
    if (facing(i, own) < 0.3) {
      double least = 1e30;
      for (int candidate : head.contour[i]) {
        const Vec3d p =
            state.cam_from_head * reduced_point(head, person, candidate, state.expression, state.jaw);
        const double cosine = facing(candidate, p);
        if (std::abs(cosine) > 0.3 || p.z() < 1e-3) continue;
        const double d = (p.hnormalized() - observation.rays[i]).norm() * observation.focal_px;
        const double score = d * d * (1 + 4 * cosine * cosine);
        if (score < least) least = score, best = candidate;
      }
    }
    line.point[i] = best;
    Vec2d n = (turn * head.normals[best]).head<2>();
    line.normal[i] = n.norm() > 1e-6 ? Vec2d(n.normalized()) : Vec2d(1, 0);
  }
  return line;
}

void frame_system(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
                  const JawLine& jaw_line, const ExpressionPrior& prior, const FramePull& pull,
                  const FrameFitOptions& options, const FaceState& state, bool with_identity,
                  FrameSystem* system) {
  const int face = 7 + head.expression_count(), unknowns = face + (with_identity ? head.identity_count() : 0);
  const bool derivatives = system->hessian.rows() == unknowns;
  system->cost = 0;
  if (derivatives) {
    system->hessian.setZero();
    system->gradient.setZero(unknowns);
  }
  RowMatrix rows = RowMatrix::Zero(derivatives ? 2 * kLandmarkCount : 0, unknowns);
  Eigen::VectorXd residuals = Eigen::VectorXd::Zero(2 * kLandmarkCount);
  const Mat3d turn = state.cam_from_head.linear();
  for (int i = options.jaw_line ? 0 : kJawLineCount; i < kLandmarkCount; ++i) {
    const int point = i < kJawLineCount ? jaw_line.point[i] : i;
    PointDerivatives by;
    const Vec3d in_head =
        reduced_point(head, person, point, state.expression, state.jaw, derivatives ? &by : nullptr);
    const Vec3d p = state.cam_from_head * in_head;
    const double z = std::max(1e-3, p.z());
    const Vec2d error = (p.head<2>() / z - observation.rays[i]) * observation.focal_px;
    const Weighted w = weigh(observation, jaw_line, i, error);
    const double norm = w.residual.norm();
    system->cost += huber(norm);
    if (!derivatives) continue;
    const double robust = norm <= kHuber ? 1.0 : std::sqrt(kHuber / norm);
    residuals.segment<2>(2 * i) = robust * w.residual;
    Eigen::Matrix<double, 2, 3> project;
    project << 1 / z, 0, -p.x() / (z * z), 0, 1 / z, -p.y() / (z * z);
    const Eigen::Matrix<double, 2, 3> by_cam = robust * observation.focal_px * w.scale * project;
    const Eigen::Matrix<double, 2, 3> by_head = by_cam * turn, by_shape = by_head * by.by_shape;
    auto row = rows.middleRows(2 * i, 2);
    if (options.free_pose) {
      row.leftCols<3>() = -by_cam * cross_matrix(turn * in_head);
      row.middleCols<3>(3) = by_cam;
    }
    if (options.free_face) {
      row.col(6) = by_head * by.by_jaw;
      row.middleCols(7, head.expression_count()) = by_shape * head.expression.middleRows(3 * point, 3);
    }
    if (with_identity)
      row.rightCols(head.identity_count()) =
          by_shape * head.identity.middleRows(3 * point, 3) + by_head * by.by_joint * head.jaw_joint_identity;
  }
  if (derivatives) {
    system->hessian.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
    system->hessian.triangularView<Eigen::StrictlyUpper>() = system->hessian.transpose();
    system->gradient = rows.transpose() * residuals;
  }
  if (options.free_face) add_pairs(prior, state, system);
  if (options.free_face) add_lids(head, person, observation, state, derivatives, with_identity, system);
  if (options.free_face) add_lips(head, person, observation, state, derivatives, with_identity, system);
  add_priors(prior, pull, options, state, system);
  if (!derivatives) return;
  // Unknowns that are held get a unit diagonal, so that the system stays regular and their increment zero.
  for (int k = 0; k < face; ++k)
    if (system->hessian(k, k) == 0) system->hessian(k, k) = 1;
}

double frame_cost(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
                  const JawLine& jaw_line, const ExpressionPrior& prior, const FramePull& pull,
                  const FrameFitOptions& options, const FaceState& state) {
  FrameSystem system;
  frame_system(head, person, observation, jaw_line, prior, pull, options, state, false, &system);
  return system.cost;
}

FaceState moved(const FaceState& state, const Eigen::VectorXd& increment) {
  FaceState next = state;
  next.cam_from_head.linear() = turn_from_vector(increment.head<3>()) * state.cam_from_head.linear();
  next.cam_from_head.translation() += increment.segment<3>(3);
  next.jaw += increment[6];
  next.expression += increment.segment(7, state.expression.size());
  return next;
}

FaceState fit_frame(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
                    const ExpressionPrior& prior, const FramePull& pull, const FrameFitOptions& options,
                    const FaceState& guess) {
  LIKENESS_CHECK(guess.expression.size() == head.expression_count(), "%d expression numbers for %d shapes",
                 static_cast<int>(guess.expression.size()), head.expression_count());
  FaceState state = guess;
  const JawLine line = pick_jaw_line(head, person, observation, state);
  const int unknowns = 7 + head.expression_count();
  FrameSystem system;
  double damping = 1e-4;
  double cost = frame_cost(head, person, observation, line, prior, pull, options, state);
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    system.hessian.resize(unknowns, unknowns);
    frame_system(head, person, observation, line, prior, pull, options, state, false, &system);
    bool better = false, settled = false;
    for (int attempt = 0; attempt < 6 && !better; ++attempt) {
      Eigen::MatrixXd damped = system.hessian;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd step = -solve_symmetric(damped, system.gradient);
      if (!step.allFinite()) break;
      const FaceState trial = moved(state, step);
      const double trial_cost = frame_cost(head, person, observation, line, prior, pull, options, trial);
      if (trial_cost < cost && trial.cam_from_head.translation().z() > 0.05) {
        better = true;
        const double gain = cost - trial_cost;
        state = trial;
        cost = trial_cost;
        damping = std::max(1e-7, damping * 0.2);
        settled = gain < 1e-5 * cost + 1e-9;
      } else {
        damping *= 8;
      }
    }
    if (!better || settled) break;
  }
  // Products of increments drift off the rotation group by rounding only, yet over many calls.
  state.cam_from_head.linear() =
      Eigen::Quaterniond(state.cam_from_head.linear()).normalized().toRotationMatrix();
  return state;
}

FaceState start_frame(const ReducedHead& head, const ReducedPerson& person,
                      const FaceObservation& observation, const ExpressionPrior& prior) {
  FaceState state;
  state.expression = Eigen::VectorXd::Zero(head.expression_count());
  // Depth from the spread of the inner points; facing the camera: x right = subject's left, y down, z
  // forward.
  Vec2d mean = Vec2d::Zero();
  Vec3d centre = Vec3d::Zero();
  const int count = kLandmarkCount - kJawLineCount;
  for (int i = kJawLineCount; i < kLandmarkCount; ++i) {
    mean += observation.rays[i] / count;
    centre += person.base.segment<3>(3 * i) / count;
  }
  double seen = 0, size = 0;
  for (int i = kJawLineCount; i < kLandmarkCount; ++i) {
    seen += (observation.rays[i] - mean).squaredNorm();
    size += (person.base.segment<3>(3 * i) - centre).head<2>().squaredNorm();
  }
  const double depth = std::sqrt(size / std::max(1e-12, seen));
  FaceState best = state;
  double least = 1e300;
  FrameFitOptions rigid;
  rigid.free_face = false;
  rigid.jaw_line = false;
  rigid.max_iterations = 25;
  for (double yaw : {0.0, 0.7, -0.7}) {
    Mat3d facing = Vec3d(1, -1, -1).asDiagonal();
    state.cam_from_head.linear() = facing * rotation_about(Vec3d::UnitY(), yaw);
    state.cam_from_head.translation() = depth * mean.homogeneous() - state.cam_from_head.linear() * centre;
    const FaceState fitted = fit_frame(head, person, observation, prior, {}, rigid, state);
    const JawLine line = pick_jaw_line(head, person, observation, fitted);
    const double cost = frame_cost(head, person, observation, line, prior, {}, rigid, fitted);
    if (cost < least * 0.98) least = cost, best = fitted;
  }
  return best;
}

double lid_gap(const ReducedHead& head, const ReducedPerson& person, int side,
               const Eigen::VectorXd& expression) {
  double gap = 0;
  for (const auto& pair : kLidPairs[side])
    for (int k = 0; k < 2; ++k)
      gap += (k == 0 ? 0.5 : -0.5) *
             (person.base[3 * pair[k] + 1] + head.expression.row(3 * pair[k] + 1).dot(expression));
  return gap;
}

double lip_gap(const ReducedHead& head, const ReducedPerson& person, const FaceState& state) {
  double gap = 0;
  for (const auto& pair : kLipPairs)
    for (int k = 0; k < 2; ++k)
      gap += (k == 0 ? 1.0 : -1.0) / kLipPairs.size() *
             reduced_point(head, person, pair[k], state.expression, state.jaw).y();
  return gap;
}

double inner_error(const ReducedHead& head, const ReducedPerson& person, const FaceObservation& observation,
                   const FaceState& state) {
  double sum = 0;
  for (int i = kJawLineCount; i < kLandmarkCount; ++i) {
    const Vec3d p = state.cam_from_head * reduced_point(head, person, i, state.expression, state.jaw);
    sum += (p.hnormalized() - observation.rays[i]).norm() * observation.focal_px;
  }
  return sum / (kLandmarkCount - kJawLineCount);
}

}  // namespace likeness
