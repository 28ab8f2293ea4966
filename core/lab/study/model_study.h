// Models of a head side by side on one capture, in tables: the papers' models against each other, ours
// against a long training of the baseline that the papers compare with, ours with a part more or less, and
// what its pictures cost at each quality. Every training draws its rays from the same pictures and, unless
// its row is about the track, the same track, and is measured on the same held-out frames, some as it learns
// and all at the end. Trained by steps instead of seconds, rows differ by their parts alone, however fast
// each is.
//
// Seconds are processor seconds, of all threads together, so that other users of the machine change as
// little as possible: `likeness study PROJECT`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/lab/study/variant_project.h"
#include "core/project/project.h"
#include "core/train/choose_parts.h"
#include "core/train/mode.h"
#include "core/train/train.h"

namespace likeness {

enum class ModelKind {
  grid,  // hash grids (core/train)
  mlp,   // positional encoding and perceptrons (core/papers/train_nerf.h)
  moved  // one picture, moved by landmarks (core/lab/study/landmark_warp.h): nothing is trained
};
inline constexpr const char* kModelKinds[] = {"grid", "mlp", "moved"};

// What is trained, and for how long.
struct ModelSpec {
  std::string name;   // of its files, too: warp+hyper-grid
  std::string about;  // in words
  ModelKind kind = ModelKind::grid;
  FieldMode mode = kDefaultMode;
  double share = 1;    // of the study's seconds
  bool once = false;   // the first seed alone
  int keep_every = 1;  // of the training frames: 10 leaves a tenth
  // Of a grid: conditioned on painted attributes instead of the track's expression; of those that the track
  // would have been painted with (track_annotations.h) where none were painted.
  bool painted = false;
  // Of a grid: what was painted in the project, beside the track's expression.
  bool attributes = false;
  bool costs = false;  // its pictures are also timed at other sizes and, of a grid, other qualities
  // Of a grid, what is changed of the parts that the trainer chooses for the capture and of its options.
  void (*parts)(ChosenParts& parts) = nullptr;
  void (*change)(TrainOptions& options) = nullptr;
  TrackVariant track = {};  // another track than the project's
};

struct StudyTable {
  std::string name, title, about;
  std::vector<std::string> models;  // by name; a model may stand in several tables
  std::vector<std::string> more;    // that are trained only when asked for by name
};

// The default study. The first table's default model is what a build makes, named kDefaultModel; the baseline
// of the papers, trained kBaselineShare times as long, is kLongBaseline.
inline constexpr const char* kDefaultModel = "warp+hyper-grid";
inline constexpr const char* kLongBaseline = "concat-mlp-long";
inline constexpr double kBaselineShare = 40;
const std::vector<ModelSpec>& study_models();
const std::vector<StudyTable>& study_tables();

// Steps that an earlier study took, by model and seed: repeats it bit for bit on one machine.
using StudySteps = std::map<std::pair<std::string, std::uint64_t>, std::uint64_t>;

struct ModelStudyOptions {
  std::vector<std::string> tables, models;  // empty = all, but those that a table names as more
  double seconds = 90;                      // of processor, of each training of share 1
  std::uint64_t steps = 0;                  // of each grid of share 1, instead of seconds
  std::uint64_t mlp_steps = 0;              // of each perceptron of share 1, instead of seconds
  StudySteps replay;                        // of those that are in it, instead of either
  int size = 128;                           // px; 0 = the project's
  int frames = 8;                           // held out that are measured, evenly chosen; 0 = all
  int rays = 8192;                          // of each step of the grid
  std::filesystem::path lpips;              // a network of perceptual_network.h; empty = none
  int seeds = 3;
  std::uint64_t first_seed = 0;
  // Cells along an axis at which the default model is also stored (core/papers/baked_avatar.h), multiples
  // of 8; empty: not at all.
  std::vector<int> baked_cells{128, 256};
  bool refit = false;       // also fit pose and expression of every measured frame to the frozen field
  bool track_anew = false;  // by the project's options, whose head model may be another than its track's
};

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

// The project must be tracked and matted, regions included; it is not changed. Works in `folder`: a finished
// training is kept there with its scores and pictures, and a second call with the same options goes on where
// the first stopped. Writes results.csv, results.json, the plots and report.html when all rows are there. The
// program is none of the inputs: after an update take a new folder.
Result<ModelStudy> study_models_of(const Project& project, const std::filesystem::path& folder,
                                   const ModelStudyOptions& options, const Progress& progress,
                                   std::stop_token stop);

}  // namespace likeness
