// See observe_face.h.
#include "core/face/observe_face.h"

#include <algorithm>
#include <cmath>

namespace likeness {

FaceObservation observe_face(const Landmarks& landmarks, const Intrinsics& source, double scale,
                             double focal_px, FaceObservation before) {
  FaceObservation out = std::move(before);
  // The predictor's own noise grows with the face: 1 px for eyes 150 px apart, and never below its rounding.
  const double eyes_px = (landmarks.points[36] - landmarks.points[45]).norm() * scale;
  const double floor = std::clamp(eyes_px / 150.0, 0.4, 2.0);
  out.focal_px = focal_px;
  for (int k = 0; k < kLandmarkCount; ++k) {
    out.rays[k] = ray_direction(source, landmarks.points[k]).head<2>();
    out.sigma_px[k] = std::hypot(floor, landmarks.spread[k] * scale);
  }
  return out;
}

ExpectedFace expect_face(const ReducedHead& head, const ReducedPerson& person, const Intrinsics& intrinsics,
                         const Pose& cam_from_head) {
  const Eigen::VectorXd neutral = Eigen::VectorXd::Zero(head.expression_count());
  ExpectedFace expected;
  Vec2d low = Vec2d::Constant(1e9), high = Vec2d::Constant(-1e9);
  for (int p = 0; p < kLandmarkCount; ++p) {
    const Vec3d in_cam = cam_from_head * reduced_point(head, person, p, neutral, 0);
    expected.hint.points[p] = project<double>(intrinsics, in_cam);
    if (p < kJawLineCount) continue;
    low = low.cwiseMin(expected.hint.points[p]);
    high = high.cwiseMax(expected.hint.points[p]);
  }
  // dlib's boxes reach from above the brows to the chin, about 1.5 times as wide as brows and mouth.
  const double side = 1.45 * std::max(high.x() - low.x(), 0.95 * (high.y() - low.y()));
  const Vec2d centre = 0.5 * (low + high) + Vec2d(0, 0.02 * side);
  expected.hint.sigma = 0.02 * side;
  expected.box = {centre.x() - 0.5 * side, centre.y() - 0.5 * side, side, side, 0};
  return expected;
}

}  // namespace likeness
