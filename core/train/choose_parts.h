// Which parts of the method an avatar gets, and how large they are, decided in one place from measures of its
// capture, each with the reason in words. A part that a capture does not need costs time at best, and at
// worst memorises the track's noise.
//
// There are no rules of unmeasured worth: such a part is the same for every capture, and its reason says so.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/head/pose_head.h"
#include "core/render/avatar.h"
#include "core/train/train.h"

namespace likeness {

// The measures that decide. Angles in rad, lengths in m.
struct CaptureMeasures {
  int size = 256;                      // px, side of the training pictures
  int frames = 0, further_frames = 0;  // training frames: of the clip itself, of further clips
  bool torso_followed = true;          // the track has a torso
  double torso_share = 0;          // of the picture: the person below and beside the neck; mean of the frames
  bool has_plate = false;          // there is a picture of the background before a resting camera
  bool has_mosaic = false;         // a hand-held one's, wider than a frame
  double plate_share = 0;          // share of the frames before it
  bool has_room = false;           // a room behind the moving camera was learnt
  std::string background_fault{};  // why what was learnt does not show the background; empty: it does
  double yaw = 0, pitch = 0;       // of the camera as seen from the head: span, 2nd to 98th percentile
  double turn = 0;         // of the head before the camera: rms about its mean rotation, over all clips
  double face_motion = 0;  // rms over frames and the face's vertices, by expression and jaw
  double gaze_pitch = 0, gaze_yaw = 0;  // rms about the mean
  std::vector<Vec3f> exposures{};       // of the clip's own views (core/train/exposure.h)
  std::optional<double> light_drift;    // their rms, of 1; nullopt: there is no plate to tell it by
};

// For a set with its pictures. has_room and background_fault are set by the caller.
CaptureMeasures measure_capture(const TrainingSet& set, const HeadShape& shape);

// The user's choices; the measures decide the rest.
struct AskedParts {
  std::optional<FieldMode> mode;
  bool no_latent = false, no_occupancy = false, no_proxies = false, refine_track = false;
  double landmark_weight = 0;
};

struct ChosenParts {
  FieldMode mode = kDefaultMode;
  bool torso = true, plate = true, gaze = true, still = true, latent = true, proxies = true;
  FieldSizes sizes;
  std::vector<Vec3f> exposures{};  // what the frames are freed of; empty: they are learnt as filmed
  std::vector<AvatarPart> parts;   // all of them in words, in the order in which they are shown
};

inline constexpr double kTorsoShare = 0.02;  // of the picture; less is not worth a field
// m rms. The demo's person at rest, the head turning, is tracked as 0.9 mm; static learnt that face no worse,
// but an avatar of that mode cannot be directed, so only less than a track's own noise counts as still.
inline constexpr double kStillFace = 0.0005;
// rad rms. Below, new combinations of pose and expression hardly occur, and a field conditioned on the
// expression everywhere renders unseen pictures no worse, or up to a decibel better; at twice that, a decibel
// worse (docs/measurements/parts.md).
inline constexpr double kHardlyTurns = 0.17;

// rms of the light on the background. Below, what differs is less than two of 255 levels.
inline constexpr double kEvenLight = 0.015;
// Of the frames must lie before the plate: of others nothing is known.
inline constexpr double kMostlyPlate = 0.95;

ChosenParts choose_parts(const CaptureMeasures& measures, const AskedParts& asked);

// The set and the options of a training with these parts. losses.landmark_weight, refine_track and
// rays.use_occupancy stay: only the user sets them.
void apply_parts(const ChosenParts& parts, TrainingSet& set, TrainOptions& options);

// Whether the avatar was learnt in one exposure, that of its plate.
bool is_evenly_lit(const Avatar& avatar);

// A part's name in words, e.g. "Code for each frame"; an unknown name is returned as it is.
std::string_view part_title(std::string_view name);

}  // namespace likeness
