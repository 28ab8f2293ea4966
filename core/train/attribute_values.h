// How much of an attribute every frame shows, from the few frames whose amount the user set: the look of its
// region in each frame, and a Gaussian process from looks to amounts.
//
// A look is the logarithm of the colours of points of the region, as the frame's track poses it, less that of
// the skin around it, so that neither exposure nor the colour of the light matters. What the head's turn and
// the face's expression linearly explain over the training frames may be removed; principal components of the
// training frames' looks remain. The kernel, and whether that is removed, are chosen to predict each
// annotated frame best from the others (leave-one-out, Rasmussen and Williams 2006, section 5.4.2). A frame's
// amount is then smoothed in time according to its certainty.
//
// CoNeRF learns the amounts of all frames together with its field, from the pictures' loss; here they are
// found beforehand, and the field is conditioned on them.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/camera/camera.h"
#include "core/head/pose_head.h"
#include "core/image/image.h"

namespace likeness {

// Where looks are sampled: points on triangles of the head mesh.
struct LookPoints {
  struct Point {
    int triangle = 0;
    Vec3f barycentric = Vec3f::Zero();
  };
  std::vector<Point> region;  // that are painted
  std::vector<Point> around;  // skin beside it, for the light
};
// distance: of the vertices to the paint (attribute_region.h).
LookPoints look_points(const HeadModel& model, std::span<const float> distance);

struct FrameLook {
  Eigen::VectorXf colours;         // (3 P) ln of the region's points less ln of their surroundings' mean
  std::vector<std::uint8_t> seen;  // (P) 0: turned away, hidden or outside, its colours are 0
  float share = 0;                 // of the points that are seen
};
FrameLook region_look(const HeadModel& model, std::span<const Vec3f> posed, const Camera& camera,
                      const Pose& world_from_head, const Image8& rgb, const LookPoints& points);

// A frame as the regression takes it.
struct LookedFrame {
  FrameLook look;
  Eigen::VectorXf aside;  // other causes of a changed look: turn of the head, expression; all of one length
  double time_s = 0;      // ascending within a run
  int run = 0;            // frames of one run are smoothed together
  bool training = true;   // otherwise nothing is learnt from it
  bool annotated = false;
  double value = 0;  // of an annotated frame
};

struct FrameAmount {
  float value = 0;  // within the annotated ones
  float uncertainty =
      1;  // 0: as certain as an annotated frame; 1: its look says nothing, it resembles none of them
};
// From here on a frame resembles no annotated one.
inline constexpr float kUnlikeAny = 0.6f;

struct AmountFit {
  std::vector<FrameAmount> frames;
  double left_out_error = 0;  // rms of the annotated values, each predicted by the others
  bool without_aside = false;
  int unlike_any = 0;  // frames with an uncertainty above kUnlikeAny
};
// Whether two annotated frames of different value, or more, show the region and the skin beside it well
// enough to be learnt from.
bool can_regress(std::span<const LookedFrame> frames);
// For frames that can be regressed. An annotated one that shows too little keeps its value, but nothing is
// learnt from it.
AmountFit regress_amounts(std::span<const LookedFrame> frames);

}  // namespace likeness
