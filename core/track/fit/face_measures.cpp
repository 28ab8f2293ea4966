// Landmarks in the person's own plane: see face_measures.h.
#include "core/track/fit/face_measures.h"

#include <algorithm>
#include <cmath>

#include "core/base/rigid.h"

namespace likeness {
namespace {

using Points = std::array<Vec3d, kLandmarkCount>;  // head frame, m

constexpr int kInnerEye[2] = {39, 42};
constexpr int kMouthCorner[2] = {48, 54};
constexpr int kInnerLips[3][2] = {{61, 67}, {62, 66}, {63, 65}};  // upper, lower
constexpr int kEyeCorners[4] = {36, 39, 42, 45};
constexpr int kFirstBrow = 17, kBrowPoints = 10;
// Beside what a model's identities vary: a predictor's own error of a mouth's corner, in eye gaps.
constexpr double kPredictor = 0.03;

FaceMeasures measures_of(const Points& p, double gap) {
  FaceMeasures m;
  m.mouth_width = (p[kMouthCorner[1]] - p[kMouthCorner[0]]).norm() / gap;
  double middle = 0;
  for (const auto& [upper, lower] : kInnerLips) {
    m.mouth_open += (p[upper].y() - p[lower].y()) / (3 * gap);
    middle += (p[upper].y() + p[lower].y()) / 6;
  }
  m.corner_lift = (0.5 * (p[kMouthCorner[0]].y() + p[kMouthCorner[1]].y()) - middle) / gap;
  m.mouth_aside =
      0.5 * (p[kMouthCorner[0]].x() + p[kMouthCorner[1]].x() - p[kInnerEye[0]].x() - p[kInnerEye[1]].x()) /
      gap;
  m.mouth_tilt = (p[kMouthCorner[1]].y() - p[kMouthCorner[0]].y()) / gap;
  double brows = 0, eyes = 0;
  for (int k = 0; k < kBrowPoints; ++k) brows += p[kFirstBrow + k].y() / kBrowPoints;
  for (const int k : kEyeCorners) eyes += p[k].y() / 4;
  m.brow_height = (brows - eyes) / gap;
  return m;
}

Points state_points(const ReducedHead& head, const ReducedPerson& person, const Eigen::VectorXd& expression,
                    double jaw) {
  Points points;
  for (int k = 0; k < kLandmarkCount; ++k) points[k] = reduced_point(head, person, k, expression, jaw);
  return points;
}

}  // namespace

double eye_gap(const ReducedHead& head, const ReducedPerson& person) {
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(head.expression_count());
  return std::max(0.005, (reduced_point(head, person, kInnerEye[1], rest, 0) -
                          reduced_point(head, person, kInnerEye[0], rest, 0))
                             .norm());
}

FaceMeasures measure_state(const ReducedHead& head, const ReducedPerson& person,
                           const Eigen::VectorXd& expression, double jaw) {
  return measures_of(state_points(head, person, expression, jaw), eye_gap(head, person));
}

FaceMeasures measure_face(const ReducedHead& head, const ReducedPerson& person,
                          const std::array<Vec2d, kLandmarkCount>& rays,
                          const std::array<double, kLandmarkCount>& sigma, const Pose& cam_from_head) {
  const double gap = eye_gap(head, person);
  Points points = state_points(head, person, Eigen::VectorXd::Zero(head.expression_count()), 0);
  const Pose head_from_cam = inverse(cam_from_head);
  const Vec3d camera = head_from_cam.translation();
  for (int k = 17; k < kLandmarkCount; ++k) {
    const Vec3d ray = head_from_cam.linear() * Vec3d(rays[k].homogeneous());
    // Seen from the very side, the plane says nothing: the point stays where it is at rest.
    if (std::abs(ray.z()) < 0.1 * ray.norm()) continue;
    points[k] = camera + (points[k].z() - camera.z()) / ray.z() * ray;
  }
  FaceMeasures m = measures_of(points, gap);
  const double distance = camera.norm();
  m.turn = std::acos(std::clamp(camera.z() / std::max(1e-9, distance), -1.0, 1.0));
  m.sigma = std::hypot(sigma[kMouthCorner[0]], sigma[kMouthCorner[1]]) * distance / gap;
  return m;
}

FaceMeasures measure_face(const ReducedHead& head, const ReducedPerson& person,
                          const FaceObservation& observation, const Pose& cam_from_head) {
  std::array<double, kLandmarkCount> sigma = observation.sigma_px;
  for (double& s : sigma) s /= observation.focal_px;
  return measure_face(head, person, observation.rays, sigma, cam_from_head);
}

UsualMouth usual_mouth(const ReducedHead& head) {
  const Eigen::VectorXd nobody = Eigen::VectorXd::Zero(head.identity_count()),
                        rest = Eigen::VectorXd::Zero(head.expression_count());
  const auto of = [&](const Eigen::VectorXd& identity) {
    return measure_state(head, reduced_person(head, identity), rest, 0);
  };
  const FaceMeasures mean = of(nobody);
  double width = kPredictor * kPredictor, lift = kPredictor * kPredictor;
  for (int i = 0; i < head.identity_count(); ++i) {
    Eigen::VectorXd one = nobody;
    one[i] = 1;
    const FaceMeasures m = of(one);
    width += (m.mouth_width - mean.mouth_width) * (m.mouth_width - mean.mouth_width);
    lift += (m.corner_lift - mean.corner_lift) * (m.corner_lift - mean.corner_lift);
  }
  return {mean.mouth_width, std::sqrt(width), mean.corner_lift, std::sqrt(lift), mean.mouth_open};
}

}  // namespace likeness
