// See observe_face.h.
#include "core/face/observe_face.h"

#include <algorithm>
#include <cmath>

#include "core/face/network_landmarks.h"

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
  for (int p = 0; p < kLandmarkCount; ++p) {
    const Vec3d in_cam = cam_from_head * reduced_point(head, person, p, neutral, 0);
    expected.hint.points[p] = project<double>(intrinsics, in_cam);
  }
  expected.box = box_round(expected.hint.points);
  expected.hint.sigma = 0.02 * expected.box.width;
  return expected;
}

}  // namespace likeness
