// What a study of models found: the scores of each training, and the rows and figures made of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/lab/study/model_rows.h"
#include "core/train/choose_parts.h"

namespace likeness {

struct ModelMark {  // on at most four of the held-out frames, the training's clock stopped
  double seconds = 0;
  std::uint64_t step = 0;
  std::optional<double> psnr_db;
  double psnr_head_db = 0;
};

// Pictures of one model under one setting of the renderer.
struct PictureCost {
  std::string name;
  std::optional<double> psnr_db;
  double psnr_head_db = 0;
  double frame_seconds = 0;  // processor, with the pose
  double psnr_face_db = 0;
  std::uint64_t bytes = 0;  // of fields or what is stored of them, in single precision
};
struct SizeCost {
  int size = 0;              // px
  double frame_seconds = 0;  // processor
};

struct ModelScore {
  std::uint64_t seed = 0, steps = 0, parameters = 0;
  int frames = 0;
  std::optional<double> psnr_db, mse, ssim, gmsd, lpips;  // absent where the background is not modelled
  double psnr_person_db = 0, psnr_head_db = 0, psnr_face_db = 0, face_mse = 0;
  double landmark_error_px = 0, mouth_error_px = 0;
  std::optional<double> eyes_error_px;
  // The oracle of core/train/field_fit.h, under its own name: never a result of the model as tracked.
  std::optional<double> psnr_refit_db, psnr_refit_head_db, psnr_refit_face_db;
  std::optional<double> samples_per_ray;        // of the last steps of a grid's training
  int lost = 0;                                 // held-out frames without a track
  double frame_seconds = 0, train_seconds = 0;  // processor
  std::optional<double> frame_joules;           // where the machine reports its energy (core/base/energy.h)
  std::vector<ModelMark> marks;                 // of the first seed; the last is that of the finished model
  std::vector<PictureCost> qualities;           // of a model with `costs`, first seed
  std::vector<SizeCost> sizes;
};

struct ModelRow {
  ModelSpec spec;
  std::vector<ModelScore> scores;     // one a seed
  std::vector<std::string> pictures;  // of the first seed: file names in the study's folder, by shown frame
  std::string failed;  // why there are no scores: this capture cannot teach the model; empty: it could
};

struct ModelStudy {
  std::string clip;
  int size = 0, full_size = 0;  // px: of the study, of the project
  int training_frames = 0, threads = 0;
  double seconds = 0;               // processor, of a training of share 1; 0: all by steps
  bool some_by_steps = false;       // those of one kind, or of an earlier study
  std::vector<int> frames;          // held out, measured
  std::vector<int> shown;           // of these, those with pictures
  std::vector<std::string> truths;  // their files
  std::vector<AvatarPart> parts;    // of the default model, and why it has them
  std::vector<StudyTable> tables;   // with the models that were trained
  std::vector<ModelRow> rows;       // of all tables, each model once
};

const ModelRow* find_row(const ModelStudy& study, std::string_view name);

// What the papers claim of one machine, here measured in one run: the default model against the long
// baseline.
struct StudyRatios {
  double baseline_db = 0, ours_db = 0;  // of the head, held out, all measured frames
  double times_longer = 0;              // the baseline was trained, of processor seconds
  double equal_time_db = 0;             // ours before the same baseline, trained `equal_seconds`
  double equal_seconds = 0;
  std::string sooner;       // the least trained of ours that reaches baseline_db; empty: none does
  double times_sooner = 0;  // of its training's seconds
  double times_faster = 0;  // a picture of the study's size
  std::optional<double> times_faster_full;  // a picture of the project's size
};
std::optional<StudyRatios> study_ratios(const ModelStudy& study);  // absent where a row of it is

}  // namespace likeness
