// One frame's face against its picture: the appearance of the posed skin points, the residuals with their
// derivatives, and the refined state.
//
// Residual of point i: (picture(project(p_i(state))) - appearance_i) / spread_i in encoded levels. The
// appearance (albedo times light at the point's normal) and the set of visible points are frozen while the
// state is solved for, and renewed between picture sizes; the residual then depends on the state only through
// the position in the picture, so that its derivative is gradient * projection * motion of the point.
#pragma once

#include <array>
#include <vector>

#include "core/camera/camera.h"
#include "core/face/fit_frame.h"
#include "core/image/image.h"
#include "core/track/photo/lighting.h"
#include "core/track/photo/photometric_surface.h"

namespace likeness {

inline constexpr int kPictureLevels = 3;  // whole, half, quarter size of the working picture

// A grey picture in its sizes; encoded levels 0..255.
struct FacePicture {
  std::array<Image, kPictureLevels> picture;
  std::array<Intrinsics, kPictureLevels> intrinsics;
};
FacePicture face_picture(const Image8& grey, const Intrinsics& intrinsics);

// Shared between frames, from training frames only.
struct Appearance {
  ShVector light = ShVector::Zero();            // world frame
  std::array<LitPoints, kPictureLevels> level;  // of the surface's points
  static constexpr int kTones = 32;
  std::array<double, kTones> cavity{};  // -log probability of each tone inside the open mouth, per level
  bool cavity_known = false;
};

// The expected levels of the chosen points.
struct FaceTarget {
  int level = 0;
  std::vector<int> point;     // visible ones
  std::vector<double> value;  // encoded levels
  std::vector<double> scale;  // residual per encoded level: 1 / spread, times the point's weight
};
// chosen: points to use. world_from_cam: of the frame; only its rotation matters.
FaceTarget face_target(const FaceSurface& surface, const Appearance& appearance, const FacePicture& picture,
                       int level, const std::vector<int>& chosen, const Mat3d& world_from_cam,
                       const FaceState& state);

// Samples for light_points: every visible point of a training frame.
std::vector<LightSample> light_samples(const FaceSurface& surface, const FacePicture& picture, int level,
                                       const Mat3d& world_from_cam, const FaceState& state);

// Adds weight^2 times the picture's robust terms to a system of 7 + E unknowns (fit_frame.h); without space
// for derivatives, only its cost.
void add_photometric(const FaceSurface& surface, const FacePicture& picture, const FaceTarget& target,
                     double weight, const FaceState& state, FrameSystem* system);

// All terms of a frame's fit.
struct FrameEvidenceTerms {
  const ReducedHead& head;  // landmarks
  const ReducedPerson& person;
  const FaceObservation& observation;
  const ExpressionPrior& prior;
  const FramePull& pull;
  const FaceSurface& surface;
  const Appearance& appearance;
  const FacePicture& picture;
  Mat3d world_from_cam = Mat3d::Identity();
  double weight = 0.3;  // of a photometric residual relative to a landmark's: errors of neighbouring points
                        // are correlated
};

// Levenberg-Marquardt at one picture size; the appearance is renewed once.
FaceState refine_state(const FrameEvidenceTerms& terms, int level, int iterations, const FaceState& guess);

}  // namespace likeness
