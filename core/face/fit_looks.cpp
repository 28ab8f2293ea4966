// See fit_looks.h.
#include "core/face/fit_looks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/rigid.h"
#include "core/face/fit_clip.h"
#include "core/face/reduced_head.h"

namespace likeness {
namespace {

constexpr int kIdentityDirections = 30, kIdentityLooks = 40;
constexpr std::size_t kFewestLooks = 3;

// Residuals are wanted in pixels of a face as it fills a working picture.
FaceFrame face_of(const LandmarkLook& look, const Intrinsics& lens, const ReducedHead& head) {
  FaceFrame face;
  face.frame = look.frame;
  face.seen = true;
  const Landmarks& landmarks = look.landmarks;
  const double eyes_px = std::max(1.0, (landmarks.points[36] - landmarks.points[45]).norm());
  const double scale = 150 / eyes_px;
  face.observation.focal_px = lens.fx * scale;
  for (int k = 0; k < kLandmarkCount; ++k) {
    face.observation.rays[k] = ray_direction(lens, landmarks.points[k]).head<2>();
    face.observation.sigma_px[k] = std::hypot(1.0, landmarks.spread[k] * scale);
  }
  face.state.expression = Eigen::VectorXd::Zero(head.expression_count());
  return face;
}

}  // namespace

Result<std::vector<FaceState>> fit_looks(const HeadModel& model, const Intrinsics& lens,
                                         std::span<const LandmarkLook> looks, const Progress& progress,
                                         std::stop_token stop) {
  std::vector<FaceState> states;
  if (looks.size() < kFewestLooks) return states;
  const ReducedHead head = reduce_head(model, kIdentityDirections);
  const ExpressionPrior prior = expression_prior(model);
  std::vector<FaceFrame> faces;
  for (const LandmarkLook& look : looks) faces.push_back(face_of(look, lens, head));
  ClipFitOptions options;
  options.identity_frames = kIdentityLooks;
  options.sweeps = 1;  // they do not support each other
  const Eigen::VectorXd identity = Eigen::VectorXd::Zero(head.identity_count());
  if (auto started = start_clip(head, identity, prior, faces, {}, stop); !started) return started.error();
  const auto fitted =
      fit_identity(head, prior, options, identity, faces, progress.stage(0, 0.5, "face"), stop);
  if (!fitted) return fitted.error();
  if (auto done =
          fit_states(head, fitted->identity, prior, options, faces, progress.stage(0.5, 1, "face"), stop);
      !done)
    return done.error();
  for (FaceFrame& face : faces) states.push_back(std::move(face.state));
  return states;
}

Vec3d direction_to_camera(const FaceState& state) {
  return inverse(state.cam_from_head).translation().normalized();
}

}  // namespace likeness
