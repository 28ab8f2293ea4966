// Driving measured: one person's avatar driven by another person's performance whose truth is known.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/drive/drive.h"
#include "core/head/head_model.h"
#include "core/lab/truth/track_truth.h"
#include "core/render/avatar.h"

namespace likeness {

struct DrivenAction {
  std::string name;
  std::optional<double> correlation;  // of the driven with the performed action; absent where it hardly moves
  double gain = 1;                    // applied
  double jitter_ratio = 1;            // RMS second difference, driven over driver's track, gain included
};

struct DriveScore {
  int frames = 0, bridged = 0;
  std::vector<DrivenAction> actions;  // the compared ones
  double mean_correlation = 0;        // over those that have one
  double neutral_psnr_db = 0;         // avatar at rest against driven by a resting driver; 99 = no difference
  int neutral_difference = 0;         // the largest of any pixel, 8-bit levels
};

// track: the driver's, as tracked; driver_model its head model; truth: of the driver's clip.
Result<DriveScore> score_drive(const Avatar& avatar, const HeadModel& avatar_model, const Track& track,
                               const HeadModel& driver_model, const TrackTruth& truth,
                               const DriveOptions& options);

}  // namespace likeness
