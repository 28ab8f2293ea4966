// Is the mouth open? Asked of the pixels, where landmarks may be fooled.
//
// The pixels around the mouth are explained twice, by a state with parted lips and by one without: skin and
// lips by their appearance, what lies between the lips by the tones seen in this person's open mouth.
#pragma once

#include <optional>

#include "core/head/head_model.h"
#include "core/track/photometric_frame.h"

namespace likeness {

// Gap between the inner lips, m.
double lip_gap(const ReducedHead& head, const ReducedPerson& person, const FaceState& state);

// The same face with its lips put together, or parted a little. nullopt where it already is so.
std::optional<FaceState> other_mouth(const HeadModel& model, const ReducedHead& head,
                                     const ReducedPerson& person, const FaceState& state);

// Tones between the lips: counts are added to.
void count_cavity(const HeadModel& model, const HeadShape& shape, const FaceSurface& surface,
                  const FacePicture& picture, const FaceState& state,
                  std::array<double, Appearance::kTones>* counts);
// Minus log probabilities from counts; false where too few were counted.
bool cavity_from_counts(const std::array<double, Appearance::kTones>& counts,
                        std::array<double, Appearance::kTones>* cost);

// How much better `b` explains the pixels around the mouth than `a`: a log likelihood, neighbouring pixels
// counted as one.
double mouth_gain(const HeadModel& model, const HeadShape& shape, const FaceSurface& surface,
                  const Appearance& appearance, const FacePicture& picture, const Mat3d& world_from_cam,
                  const FaceState& a, const FaceState& b);

}  // namespace likeness
