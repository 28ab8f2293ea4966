// The track: where the head and torso are, and what the face does, in every frame of a clip.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/frame_span.h"
#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/scene/avatar_pose.h"
#include "core/scene/torso_warp.h"

namespace likeness {

enum class FrameStatus { good, weak, lost };

struct TrackedFrame {
  int frame = 0;  // number in the source video
  double time_s = 0;
  FrameStatus status = FrameStatus::good;
  std::string reason;  // why it is weak or lost; empty for good
  // The neck stays zero: the torso has a frame of its own, and its shape is in the track's torso modes. A
  // track has no attributes and no detail: core/project/project_attributes.h and project_detail.h add a
  // project's.
  AvatarPose pose;
  std::array<Vec2d, kLandmarkCount> landmarks{};         // px, uncropped source picture
  std::array<double, kLandmarkCount> landmark_spread{};  // px, rms of the runs that agree: the uncertainty
  double look = 1;            // correlation of the face's picture with the person's other frames
  double inner_error_px = 0;  // mean distance of the fitted to the detected landmarks 17..67
};

// From which frames a person's resting face was read, and why (core/track/fit/choose_rest.h).
struct RestChoice {
  std::vector<int> frames;  // ascending, training frames; empty: not chosen frame by frame
  bool asked = false;       // the user named them
  double trust = 1;         // 0..1: how far they can be taken for a face at rest
  std::string why;          // in words
  std::string warning;      // what is wrong with them; empty: nothing
};

struct Track {
  std::string head_model_name, head_model_hash;
  std::string head_model_file;  // text_of_path (core/base/path_text.h); empty for the built-in head
  PersonShape person;
  Articulation neutral;            // the person's resting face, from training frames
  RestChoice rest;                 // which ones
  bool has_torso = true;           // enough torso in the picture to model
  TorsoModes torso_modes;          // how this torso deforms, from training frames; empty: rigid
  double metres_per_unit = 1;      // of the cameras' world; camera translations times this are metres
  bool metre_known = true;         // false: the camera moved too little to determine it, metres_per_unit is 1
  std::vector<FrameSpan> shots{};  // of a clip that was cut, those followed; empty: it is one
  std::vector<TrackedFrame> frames;  // ascending frame
};

const TrackedFrame* find_tracked(const Track& track, int frame);

// track.json: human-readable, versioned, with units.
Result<void> write_track(const std::filesystem::path& path, const Track& track);
Result<Track> read_track(const std::filesystem::path& path);

}  // namespace likeness
