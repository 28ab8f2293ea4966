// One picture of the person, moved about in two dimensions: what a first-order motion model does (Siarohin et
// al. 2019, FOMM), with the tracked head's landmarks in place of learnt keypoints and no network. The paper's
// tables call such methods FOMM-like: they know no depth, no second view and nothing of what the one picture
// hides.
//
// A pixel v of the new picture is looked up at f(v), the similarity that takes its nearby control points to
// where they were (moving least squares, Schaefer et al. 2006). In complex numbers, with w_i = m_i /
// |q_i - v|^4, q* and p* the weighted means of the control points now and then:
//
//   f(v) = a (v - q*) + p*,   a = sum_i w_i conj(q_i - q*) (p_i - p*) / sum_i w_i |q_i - q*|^2
#pragma once

#include <span>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/pose_head.h"
#include "core/render/pose_avatar.h"
#include "core/train/train.h"

namespace likeness {

// What of the person is followed.
struct ControlRig {
  HeadShape shape;
  std::vector<int> outline;  // vertices that lie the farthest out in their directions: crown, temples, ears
  double neck_base = 0;      // m, head frame y: what is below goes with the torso
  std::vector<double> importance;  // m of each control point: landmarks, outline and torso weigh alike
};
ControlRig make_control_rig(const HeadModel& model, const PersonShape& person);

// px of the camera's picture: the 68 landmarks of the posed head, its outline, then points of the torso.
std::vector<Vec2d> control_points(const HeadModel& model, const ControlRig& rig, const Camera& camera,
                                  const AvatarPose& pose);

struct LandmarkWarp {
  ControlRig rig;
  int view = 0;               // of the training set, whose picture is moved
  Image picture;              // its person alone, premultiplied (h, w, 4)
  std::vector<Vec2d> points;  // its control points
};

// Takes the training view whose landmarks are nearest to where all views' landmarks are on average. Views
// without a matte are taken for the person whole.
LandmarkWarp make_landmark_warp(const TrainingSet& set);

// f of one point. importance: m.
Vec2d moved_back(const Vec2d& v, std::span<const Vec2d> now, std::span<const Vec2d> then,
                 std::span<const double> importance);

// Premultiplied, (h, w, 4); a picture of the source's size.
Image render_landmark_warp(const LandmarkWarp& source, const HeadModel& model, const Camera& camera,
                           const AvatarPose& pose);

}  // namespace likeness
