// How an avatar looks beyond what its clip shows, beside the truth: a person of the demo is filmed facing the
// camera, with faint expressions, and made into an avatar as anybody's clip is; then both are seen from the
// sides and asked for all that the film leaves out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/holds/check_holds.h"
#include "core/project/project.h"
#include "core/synth/demo_options.h"
#include "core/train/train.h"

namespace likeness {

// The film of a person who is asked for more than it shows.
DemoOptions faint_film(int person, int seed);

// Means over the pictures they are of; dB against the truth, in the truth's own regions.
struct BeyondScore {
  std::optional<double> psnr_head_db, psnr_face_db, psnr_person_db;
  std::optional<double> ssim, gmsd;  // of whole pictures before the true room
};

struct BeyondView {
  double yaw = 0, pitch = 0;  // degrees, as AskedView
  BeyondScore score;
  double drift =
      0;           // of the skin's mean colour off the truth, less that at the front: largest channel, levels
  double iou = 0;  // of the silhouettes
  double depth_mm = 0;  // median distance of where rays on the skin end from the true surface, along the ray
  double landmarks_px = 0;  // NaN where no face is found
  double specks = 0;        // share of the head's pixels, see speck_share
};

struct BeyondAction {
  std::string name;
  float amount = 0;
  BeyondScore score;
  // Mean change of the forehead from rest, less the true one, levels; absent of actions that move it.
  std::optional<double> forehead_change;
  double specks = 0;
};

struct BeyondStudy {
  BeyondScore inside;  // of held-out frames of the film
  double inside_specks = 0;
  std::vector<BeyondView> views;
  std::vector<BeyondAction> actions;
  HoldCheck holds;  // what the avatar's own check makes of it, without the truth
  std::uint64_t steps = 0;
  double train_seconds = 0;
};

struct BeyondOptions {
  DemoOptions film;
  ProjectOptions project;  // video is set
  TrainingPlace place;
};

// folder: keeps film, project and true pictures, and gets the contact sheets views.png and actions.png (truth
// above the avatar). A second call with the same film and options makes nothing again.
Result<BeyondStudy> study_beyond_truth(const std::filesystem::path& folder, const BeyondOptions& options,
                                       const Progress& progress, std::stop_token stop);

}  // namespace likeness
