#include "core/track/fit/personal_shape.h"

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <new>
#include <optional>
#include <string>

#include "core/base/dense_solves.h"
#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/head/pose_head.h"
#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"
#include "core/track/fit/face_contour.h"

namespace likeness {
namespace {

constexpr std::size_t kMinTerms = 50;  // with fewer, a person's shape cannot be estimated
constexpr int kReweights = 2;
constexpr double kDoubt = 2.5;         // residual in sigmas at which a term has lost most of its weight
constexpr double kTrackPx = 0.5;       // usual residual of a followed point
constexpr double kUnknown = 0.02;      // m: uncertainty of a point without any view
constexpr double kPointReach = 0.008;  // m; points further from the skin do not belong to it
constexpr int kSettles = 6;            // passes of aligning the points to the skin, each with a prior
constexpr double kShiftSlack = 0.003, kTurnSlack = 0.05, kSizeSlack = 0.03;  // m, rad, share, per pass
constexpr double kPrecision = 1e-3;  // of the first residual, at which a solve ends
constexpr int kMaxSteps = 150;

// sum_k by[k] . offset(vertex[k]) = wanted, in units of its sigma.
struct Term {
  std::array<int, 3> vertex{};
  std::array<Vec3d, 3> by;
  double wanted = 0;
};

using Field = Eigen::MatrixX3d;  // (nodes, 3) m
using Terms = std::vector<Term>;
using Offsets = std::vector<Vec3f>;

double value_of(const Term& term, const Offsets& offsets) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += term.by[k].dot(offsets[term.vertex[k]].cast<double>());
  return sum;
}

Articulation articulation_of(const HeadModel& model, const FaceState& state) {
  Articulation a = neutral_articulation(model);
  a.expression = state.expression.cast<float>();
  a.jaw.x() = static_cast<float>(state.jaw);
  return a;
}

std::vector<int> training_of(std::span<const ShapeFrame> frames) {
  std::vector<int> training;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].grey && !frames[i].held_out) training.push_back(static_cast<int>(i));
  return training;
}

// Each coefficient's median: the face's usual state.
FaceState usual_state(const HeadModel& model, std::span<const ShapeFrame> frames,
                      const std::vector<int>& training) {
  FaceState usual;
  usual.expression = Eigen::VectorXd::Zero(model.expression_count());
  std::vector<double> values(training.size());
  const auto usually = [&](auto&& of) {
    for (std::size_t k = 0; k < training.size(); ++k) values[k] = of(frames[training[k]].state);
    return median(values);
  };
  if (training.empty()) return usual;
  for (int e = 0; e < model.expression_count(); ++e)
    usual.expression[e] = usually([&](const FaceState& s) { return s.expression[e]; });
  usual.jaw = usually([](const FaceState& s) { return s.jaw; });
  return usual;
}

// Unchanged up to half of `most`, then compressed, never longer: longer offsets are errors of the evidence.
Vec3d bounded(const Vec3d& offset, double most) {
  const double length = offset.norm(), half = 0.5 * most;
  return length <= half ? offset : offset / length * (half + half * std::tanh((length - half) / half));
}

class ShapeSolver {
 public:
  ShapeSolver(const HeadModel& model, const Eigen::VectorXf& identity, std::span<const ShapePoint> points,
              std::span<const ShapeFrame> frames, const PersonalShapeOptions& options)
      : model_(model),
        identity_(identity),
        points_(points),
        frames_(frames),
        options_(options),
        training_(training_of(frames)),
        usual_(usual_state(model, frames, training_)),
        offsets_(model.vertices.size(), Vec3f::Zero()) {
    const std::vector<Vec3f> rest = shape_head(model, identity).vertices;
    field_ = shape_field(model, rest, options.field);
    prior_.compute(field_.precision);
    outline_ = contour_triangles(model, rest);
    const HeadRegions regions = head_regions(model);
    std::vector<std::uint8_t> skin(model.triangles.size());
    for (std::size_t t = 0; t < skin.size(); ++t) skin[t] = regions.face[t] && regions.skin[t];
    skin_ = region_triangles(model, skin);
  }

  const Offsets& offsets() const { return offsets_; }

  // The terms of this round; contours are sought within reach_m.
  Terms find_terms(double reach_m, const std::stop_token& stop) const {
    const HeadShape shape = shape_head(model_, PersonShape{identity_, offsets_});
    Terms terms;
    if (options_.points) add_points(shape, terms);
    const std::size_t count = std::min<std::size_t>(options_.frames, training_.size());
    std::vector<Terms> found(count);
    parallel_for(count, [&](std::size_t k) {
      if (stop.stop_requested()) return;
      const ShapeFrame& frame = frames_[training_[k * training_.size() / count]];
      const std::vector<Vec3f> posed = pose_head(model_, shape, articulation_of(model_, frame.state));
      if (options_.contours) add_contours(frame, posed, reach_m, found[k]);
      if (options_.landmarks && frame.observation) add_landmarks(frame, posed, count, found[k]);
    });
    for (const Terms& f : found) terms.insert(terms.end(), f.begin(), f.end());  // in order: repeatable sums
    return terms;
  }

  void solve(const Terms& terms) {
    for (int pass = 0; pass < kReweights; ++pass) solve_once(terms);
  }
  bool ready() const { return prior_.info() == Eigen::Success; }

 private:
  // Maps a displacement of the rest head to the posed one: the jaw's rotation, by its weight.
  Mat3d turned_by(int vertex, double jaw) const {
    const double w = model_.skinning_weights(vertex, kJaw);
    return (1 - w) * Mat3d::Identity() + w * rotation_about(Vec3d::UnitX(), jaw);
  }

  // direction . displacement of a surface point = missing, on top of the current offsets.
  Term term_of(const Triangle& triangle, const Vec3d& weight, const Vec3d& direction, double missing,
               double jaw, double sigma) const {
    Term term;
    for (int k = 0; k < 3; ++k) {
      term.vertex[k] = triangle[k];
      term.by[k] = weight[k] / sigma * (turned_by(triangle[k], jaw).transpose() * direction);
    }
    term.wanted = missing / sigma + value_of(term, offsets_);
    return term;
  }

  struct Foot {  // a point's place on the skin
    Triangle triangle;
    Vec3d weight, normal, away;
  };
  std::optional<Foot> foot_of(const Vec3d& point, const MeshScene& skin) const {
    const auto nearest = skin.closest(point.cast<float>(), static_cast<float>(kPointReach));
    if (!nearest) return std::nullopt;
    const Triangle& t = skin_[nearest->triangle];
    const std::vector<Vec3f>& v = skin.vertices();
    const Vec3d normal = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized().cast<double>();
    const Vec3d away = point - nearest->position.cast<double>();
    if (std::abs(away.dot(normal)) < 0.7 * away.norm()) return std::nullopt;  // beyond the rim of the face
    return Foot{t, nearest->barycentric.cast<double>(), normal, away};
  }

  double point_sigma(std::size_t i, const Vec3d& normal) const {
    return std::sqrt(normal.dot(points_[i].covariance * normal) + options_.point_m * options_.point_m);
  }

  // The points aligned to the skin by the similarity that their reconstruction leaves undetermined.
  std::vector<Vec3d> settled_points(const MeshScene& skin) const {
    std::vector<Vec3d> places;
    Vec3d centre = Vec3d::Zero();
    for (const ShapePoint& p : points_) {
      places.push_back(p.point);
      centre += p.point / static_cast<double>(points_.size());
    }
    using Vector7 = Eigen::Matrix<double, 7, 1>;
    for (int pass = 0; pass < kSettles; ++pass) {
      Eigen::Matrix<double, 7, 7> hessian = Eigen::Matrix<double, 7, 7>::Zero();
      Vector7 gradient = Vector7::Zero();
      hessian.diagonal() << Vec3d::Constant(1 / (kShiftSlack * kShiftSlack)),
          Vec3d::Constant(1 / (kTurnSlack * kTurnSlack)), 1 / (kSizeSlack * kSizeSlack);
      for (std::size_t i = 0; i < places.size(); ++i) {
        const auto foot = foot_of(places[i], skin);
        if (!foot) continue;
        const double sigma = point_sigma(i, foot->normal), off = foot->away.dot(foot->normal) / sigma;
        const double doubt = 1 + off * off / (kDoubt * kDoubt), weight = 1 / (doubt * doubt);
        const Vec3d arm = places[i] - centre;
        Vector7 row;
        row << foot->normal, arm.cross(foot->normal), foot->normal.dot(arm);
        row /= sigma;
        hessian += weight * row * row.transpose();
        gradient += weight * off * row;
      }
      const Vector7 step = -solve_symmetric(hessian, gradient);
      const Mat3d turn = turn_from_vector(step.segment<3>(3));
      for (Vec3d& p : places) p = centre + step.head<3>() + (1 + step[6]) * (turn * (p - centre));
    }
    return places;
  }

  void add_points(const HeadShape& shape, Terms& terms) const {
    if (points_.empty()) return;
    const MeshScene skin(pose_head(model_, shape, articulation_of(model_, usual_)), skin_);
    const std::vector<Vec3d> places = settled_points(skin);
    for (std::size_t i = 0; i < places.size(); ++i)
      if (const auto foot = foot_of(places[i], skin))
        terms.push_back(term_of(foot->triangle, foot->weight, foot->normal, foot->away.dot(foot->normal),
                                usual_.jaw, point_sigma(i, foot->normal)));
  }

  void add_contours(const ShapeFrame& frame, const std::vector<Vec3f>& posed, double reach_m,
                    Terms& terms) const {
    for (const ContourPoint& c :
         face_contour(model_, outline_, posed, frame.intrinsics, frame.state.cam_from_head)) {
      const double reach_px = std::max(3.0, reach_m * c.px_per_m);
      const auto shift = find_edge(*frame.grey, c.pixel, c.outward, reach_px, 0.5 * reach_px);
      if (shift)
        terms.push_back(term_of(model_.triangles[c.triangle], c.barycentric, c.normal, *shift / c.px_per_m,
                                frame.state.jaw, options_.contour_m));
    }
  }

  // Two terms per landmark, except those of the jaw line, which slide along the outline.
  void add_landmarks(const ShapeFrame& frame, const std::vector<Vec3f>& posed, std::size_t frames,
                     Terms& terms) const {
    const auto places = landmark_positions(model_, posed);
    const Pose& pose = frame.state.cam_from_head;
    for (int i = kJawLineCount; i < kLandmarkCount; ++i) {
      const Vec3d at = pose * places[i].cast<double>();
      if (at.z() < 0.05) continue;
      const double sigma = options_.landmark_px / frame.observation->focal_px *
                           std::sqrt(static_cast<double>(frames)) * at.z();
      for (int axis = 0; axis < 2; ++axis) {
        // d (x/z) = (dx - ray dz) / z
        const double ray = frame.observation->rays[i][axis];
        const Vec3d in_cam = Vec3d::Unit(axis) - ray * Vec3d::UnitZ();
        terms.push_back(term_of(
            model_.triangles[model_.landmark_triangle[i]], model_.landmark_barycentric[i].cast<double>(),
            pose.linear().transpose() * in_cam, ray * at.z() - at[axis], frame.state.jaw, sigma));
      }
    }
  }

  double robust_weight(const Term& term) const {
    const double off = (term.wanted - value_of(term, offsets_)) / kDoubt;
    return 1 / ((1 + off * off) * (1 + off * off));
  }

  // Conjugate gradients from the current offsets, preconditioned by the factored prior: its pieces differ in
  // stiffness by many orders, the terms by few.
  void solve_once(Terms terms) {
    for (Term& term : terms) {
      const double root = std::sqrt(robust_weight(term));
      for (Vec3d& by : term.by) by *= root;
      term.wanted *= root;
    }
    Field x = Field::Zero(field_.nodes, 3), residual = Field::Zero(field_.nodes, 3);
    for (std::size_t v = 0; v < offsets_.size(); ++v)
      if (const int node = field_.node_of[v]; node >= 0) x.row(node) = offsets_[v].cast<double>().transpose();
    for (const Term& term : terms) add_along(term, term.wanted, residual);
    residual -= applied(terms, x);
    Field pull = prior_.solve(residual), direction = pull;
    double size = residual.cwiseProduct(pull).sum();
    const double enough = kPrecision * kPrecision * size;
    for (int i = 0; i < kMaxSteps && size > enough; ++i) {
      const Field along = applied(terms, direction);
      const double step = size / direction.cwiseProduct(along).sum();
      x += step * direction;
      residual -= step * along;
      pull = prior_.solve(residual);
      const double next = residual.cwiseProduct(pull).sum();
      direction = pull + next / size * direction;
      size = next;
    }
    for (std::size_t v = 0; v < offsets_.size(); ++v)
      if (const int node = field_.node_of[v]; node >= 0)
        offsets_[v] = bounded(x.row(node).transpose(), options_.max_m).cast<float>();
  }

  void add_along(const Term& term, double amount, Field& sum) const {
    for (int k = 0; k < 3; ++k)
      if (const int node = field_.node_of[term.vertex[k]]; node >= 0)
        sum.row(node) += amount * term.by[k].transpose();
  }

  // The system's matrix times x.
  Field applied(const Terms& terms, const Field& x) const {
    Field sum = field_.precision * x;
    for (const Term& term : terms) {
      double value = 0;
      for (int k = 0; k < 3; ++k)
        if (const int node = field_.node_of[term.vertex[k]]; node >= 0) value += x.row(node).dot(term.by[k]);
      add_along(term, value, sum);
    }
    return sum;
  }

  const HeadModel& model_;
  const Eigen::VectorXf& identity_;
  const std::span<const ShapePoint> points_;
  const std::span<const ShapeFrame> frames_;
  const PersonalShapeOptions& options_;
  const std::vector<int> training_;
  const FaceState usual_;
  ShapeField field_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> prior_;
  std::vector<std::uint8_t> outline_;
  std::vector<Triangle> skin_;
  Offsets offsets_;
};

}  // namespace

std::vector<ShapePoint> skin_points(std::span<const HeadPoint> points, std::span<const DenseFrame> frames) {
  std::vector<ShapePoint> skin;
  for (const HeadPoint& p : points) {
    if (!p.on_skin) continue;
    Mat3d information = Mat3d::Identity() / (kUnknown * kUnknown);
    double residual = 0;
    for (const BundleObservation& o : p.track.seen) {
      const DenseFrame& f = frames[o.frame];
      const Vec3d at = f.cam_from_head * p.track.point;
      Eigen::Matrix<double, 2, 3> by_cam;
      by_cam << 1, 0, -o.ray.x(), 0, 1, -o.ray.y();
      const Eigen::Matrix<double, 2, 3> rows = f.intrinsics.fx / at.z() * by_cam * f.cam_from_head.linear();
      information += rows.transpose() * rows / (kTrackPx * kTrackPx);
      residual += (at.hnormalized() - o.ray).squaredNorm() * f.intrinsics.fx * f.intrinsics.fx;
    }
    residual /= static_cast<double>(std::max<std::size_t>(1, p.track.seen.size()));
    const double worse = std::max(1.0, residual / (kTrackPx * kTrackPx));
    skin.push_back({p.track.point, worse * information.inverse()});
  }
  return skin;
}

Result<std::vector<Vec3f>> fit_personal_shape(const HeadModel& model, const Eigen::VectorXf& identity,
                                              std::span<const ShapePoint> points,
                                              std::span<const ShapeFrame> frames,
                                              const PersonalShapeOptions& options, const Progress& progress,
                                              std::stop_token stop) {
  if (stop.stop_requested()) return cancelled_error();
  try {
    ShapeSolver solver(model, identity, points, frames, options);
    if (!solver.ready())
      return Error{ErrorCode::failed, "The mesh of this head model is too irregular for a personal shape.",
                   "Use another head model.", "personal shape"};
    for (int round = 0; round < options.rounds; ++round) {
      progress.report(static_cast<double>(round) / options.rounds, "fitting the person's own shape");
      const double along = options.rounds > 1 ? static_cast<double>(round) / (options.rounds - 1) : 0;
      const Terms terms = solver.find_terms(options.contour_reach_m * std::exp2(-along), stop);
      if (stop.stop_requested()) return cancelled_error();
      if (terms.size() < kMinTerms) {
        progress.report(1);
        return std::vector<Vec3f>{};
      }
      solver.solve(terms);
      if (stop.stop_requested()) return cancelled_error();
    }
    progress.report(1);
    return solver.offsets();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return Error{ErrorCode::failed, "Fitting the person's own shape failed: " + std::string(e.what()),
                 "Run the fit again; if it fails again, report this message.", "personal shape"};
  }
}

}  // namespace likeness
