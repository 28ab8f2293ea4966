// What each part of the method brings to pictures the avatar never saw: a project's clip trained with a part
// more or less, everything else equal (the same training steps, held-out frames and regions), so that the
// difference of two rows is that part's doing. The time a machine happens to have does not count.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/lab/score/frame_score.h"
#include "core/project/project.h"
#include "core/scene/track.h"
#include "core/train/choose_parts.h"
#include "core/train/train.h"

namespace likeness {

// One row of the table: a step of the tracker (track_steps), what is taken out of its track, and what is
// changed of the parts that the trainer chooses for the capture and of the switches of the training.
struct GainVariant {
  std::string name, about;
  std::string track_step;
  void (*change)(Track& track, const HeadModel& model) = nullptr;
  void (*train)(TrainOptions& options) = nullptr;
  void (*parts)(ChosenParts& parts) = nullptr;  // of those chosen for the capture
  bool attributes = false;                      // with those that were painted
  bool maps = true;                             // with the project's detail maps, where it has any
};
const std::vector<GainVariant>& gain_variants();  // the first is the default of a build

struct GainOptions {
  std::vector<std::string> variants;  // empty = all
  std::uint64_t steps = 300;          // of training, for each
  int rays = TrainOptions().rays.per_step;
  int seeds = 1;  // trainings of each
  std::uint64_t first_seed = 0;
  bool refit = false;  // beside the as-tracked scores, the oracle's (core/train/field_fit.h)
};

// Held-out scores of one training.
struct GainScore {
  std::uint64_t seed = 0;
  int frames = 0, lost = 0;       // held out: measured, without a track
  std::optional<double> psnr_db;  // absent where the background is not modelled
  double psnr_person_db = 0, psnr_head_db = 0, psnr_face_db = 0;
  LandmarkErrors landmarks_px;
  std::optional<double> psnr_refit_db, psnr_refit_head_db, psnr_refit_face_db;
  double train_seconds = 0;
  std::optional<double>
      samples_per_ray;  // of the training's last steps; absent of studies before it was kept
};

struct GainRow {
  std::string variant, about;
  std::vector<GainScore> scores;  // one a seed
};

// The project must be imported, aligned and matted (regions/ frozen); its options give clip, head model and
// size, and it is not changed. Works in `folder`: each track and training is kept there with its scores, and
// a second call with the same options goes on where the first stopped; a training that is done is not
// repeated unless its inputs have changed. The program is none of them: after an update take a new folder.
Result<std::vector<GainRow>> study_gains(const Project& project, const std::filesystem::path& folder,
                                         const GainOptions& options, const Progress& progress,
                                         std::stop_token stop);

}  // namespace likeness
