// The curve of a training, kept in the project: how near the avatar came to its training frames and, where
// somebody looked, to held-out ones.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/project/project.h"
#include "core/train/train.h"

namespace likeness {

struct HeldOutScore {
  double training_s = 0, psnr_db = 0;
};

struct TrainingCurve {
  std::vector<TrainStatus> training;  // in order
  std::vector<HeldOutScore> held_out;
};

// A point more. Training that starts anew, or goes on from a checkpoint, replaces what lies beyond it; long
// curves are thinned: see thin_if_long.
void add_point(TrainingCurve& curve, const TrainStatus& point);
void add_score(TrainingCurve& curve, const HeldOutScore& score);
// Where there are more than a thousand points: drops every second one, but never the newest.
void thin_if_long(std::vector<TrainStatus>& points);

std::filesystem::path training_curve_path(const Project& project);
Result<void> write_training_curve(const std::filesystem::path& path, const TrainingCurve& curve);
Result<TrainingCurve> read_training_curve(const std::filesystem::path& path);

}  // namespace likeness
