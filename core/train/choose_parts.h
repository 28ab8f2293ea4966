// Which parts of the method an avatar gets, and how large they are, decided in one place from what its
// capture measures, each with the reason in words. A part that a capture has no need of costs time at best,
// and at worst learns the track's noise by heart.
//
// Rules whose worth was not measured are not here: such a part is what it is for every capture, and its
// reason says so.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/head/pose_head.h"
#include "core/render/avatar.h"
#include "core/train/train.h"

namespace likeness {

// What decides. Angles in rad, lengths in m.
struct CaptureMeasures {
  int size = 256;                      // px, side of the training pictures
  int frames = 0, further_frames = 0;  // that train: of the clip itself, of further clips
  bool torso_followed = true;          // the track has a torso
  double torso_share = 0;     // of the picture: the person below the base of the neck; mean of the frames
  bool has_plate = false;     // there is a picture of the wall behind a resting camera
  double plate_share = 0;     // of the frames, those before it
  bool has_room = false;      // a room behind the moving camera was learnt
  double yaw = 0, pitch = 0;  // of the camera as seen from the head: span, 2nd to 98th percentile
  double turn = 0;            // of the head before the camera: rms about its mean rotation, clips and all
  double face_motion = 0;     // rms over frames and the face's vertices, by expression and jaw
  double gaze_pitch = 0, gaze_yaw = 0;  // rms about the mean
  std::optional<double> light_drift;    // rms between frames of the light on the background, of 1
};

// Of a set with its pictures. has_room is the caller's to say.
CaptureMeasures measure_capture(const TrainingSet& set, const HeadShape& shape);

// What the user fixed; the rest is for the measures to decide.
struct AskedParts {
  std::optional<FieldMode> mode;
  bool no_latent = false, no_occupancy = false, refine_track = false;
  double landmark_weight = 0;
};

struct ChosenParts {
  FieldMode mode = kDefaultMode;
  bool torso = true, plate = true, gaze = true, still = true, latent = true;
  FieldSizes sizes;
  std::vector<AvatarPart> parts;  // all of them in words, in the order in which they are told
};

inline constexpr double kTorsoShare = 0.02;  // of the picture; less is not worth a field
// m rms. The demo's person at rest, the head turning, is tracked as 0.9 mm; static learnt that face no worse,
// but an avatar of that mode cannot be directed, so only less than what tracks make of a face counts as
// still.
inline constexpr double kStillFace = 0.0005;
// rad rms. Below, another pose hardly ever meets another expression, and a field that knows the expression
// everywhere shows pictures never seen no worse, or better by up to a decibel; at twice that, by a decibel
// worse (docs/measurements/parts.md).
inline constexpr double kHardlyTurns = 0.17;

ChosenParts choose_parts(const CaptureMeasures& measures, const AskedParts& asked);

// The set and the options of a training with these parts. losses.landmark_weight, refine_track and
// rays.use_occupancy stay: they are the user's alone.
void apply_parts(const ChosenParts& parts, TrainingSet& set, TrainOptions& options);

// A part's name in words, e.g. "Code for each frame"; a name that is not known is its own.
std::string_view part_title(std::string_view name);

}  // namespace likeness
