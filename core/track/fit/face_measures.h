// A face in numbers that say whether it rests: how wide and how open the mouth is, how high its corners and
// the brows are. From landmarks and the head's pose, so that a turn of the head changes none of them.
//
// Lengths are in distances between the inner corners of the person's eyes (their eye gap), which no
// expression changes. A landmark's ray is cut with the plane of the head frame, z constant, in which the
// person's own landmark lies at rest.
#pragma once

#include <array>

#include "core/face/fit_frame.h"

namespace likeness {

struct FaceMeasures {
  double mouth_width = 0;  // between the corners of the mouth
  double mouth_open = 0;   // between the inner edges of the lips, mean of three places
  double corner_lift = 0;  // height of the mouth's corners over the middle of where the lips meet
  double mouth_aside = 0;  // of the mouth's middle from that of the eyes, to the subject's left
  double mouth_tilt = 0;   // height of its left corner over its right one
  double brow_height = 0;  // of the brows over the corners of the eyes
  double turn = 0;         // rad, of the head away from the camera
  double sigma = 0;        // of the mouth's width, by the landmarks' uncertainty
};

// rays: of the 68 landmarks, (x/z, y/z) in the camera; sigma: of each, in the same unit. person: at rest.
FaceMeasures measure_face(const ReducedHead& head, const ReducedPerson& person,
                          const std::array<Vec2d, kLandmarkCount>& rays,
                          const std::array<double, kLandmarkCount>& sigma, const Pose& cam_from_head);
FaceMeasures measure_face(const ReducedHead& head, const ReducedPerson& person,
                          const FaceObservation& observation, const Pose& cam_from_head);

// The same of a state of the head model, without a picture; turn and sigma are zero.
FaceMeasures measure_state(const ReducedHead& head, const ReducedPerson& person,
                           const Eigen::VectorXd& expression, double jaw);

// The distance between the inner corners of a person's eyes, m.
double eye_gap(const ReducedHead& head, const ReducedPerson& person);

// A closed mouth at rest among people: mean and standard deviation.
struct UsualMouth {
  double width = 1.5, width_sigma = 0.15;
  double lift = 0, lift_sigma = 0.05;
  double open = 0;  // the lips' distance in a closed mouth, as the landmarks have it
};
// As the head model's identities have it.
UsualMouth usual_mouth(const ReducedHead& head);

}  // namespace likeness
