// How far the mouth is open, measured from the pixels, since landmarks may be fooled.
//
// The pixels around the mouth are explained by states of every opening: skin and lips by their appearance,
// what lies between the lips by the tones seen in this person's open mouth. The likelihood over the openings
// gives the frame's opening and its uncertainty, which is large if two of them explain the pixels equally
// well.
#pragma once

#include <optional>

#include "core/head/head_model.h"
#include "core/track/photo/photometric_frame.h"

namespace likeness {

// The same face with its jaw at an angle: other lip motion is kept above the face's own angle and fades with
// the jaw below it, so that 0 is a closed mouth.
FaceState with_jaw(const HeadModel& model, const FaceState& state, double jaw);

// Tones between the lips, added to the counts.
void count_cavity(const FaceSurface& surface, const FacePicture& picture, const FaceState& state,
                  std::array<double, Appearance::kTones>* counts);
// Minus log probabilities from counts; false if too few were counted.
bool cavity_from_counts(const std::array<double, Appearance::kTones>& counts,
                        std::array<double, Appearance::kTones>* cost);

struct MouthReading {
  LipEvidence lips;
  FaceState likeliest;  // of the states evaluated
};
// nullopt if the tones between the lips are not known or the mouth is not in the picture.
std::optional<MouthReading> read_mouth(const HeadModel& model, const ReducedHead& head,
                                       const ReducedPerson& person, const FaceSurface& surface,
                                       const Appearance& appearance, const FacePicture& picture,
                                       const Mat3d& world_from_cam, const FaceState& state);

// The opening as evidence for a frame's fit; landmarks of mouth and chin get a larger sigma the further the
// opening `fitted` to them is from it, m.
void observe_mouth(const LipEvidence& lips, double fitted_gap_m, FaceObservation* out);

// How much better `b` explains the pixels around the mouth than `a`: a log likelihood, neighbouring pixels
// counted as one.
double mouth_gain(const FaceSurface& surface, const Appearance& appearance, const FacePicture& picture,
                  const Mat3d& world_from_cam, const FaceState& a, const FaceState& b);

}  // namespace likeness
