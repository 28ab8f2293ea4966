// The papers' models side by side on one capture: every mode (core/train/mode.h) with the hash grid and with
// the perceptrons of core/baseline, trained for an equal time or equal steps on rays drawn alike from
// the same pictures and track, and measured on the same held-out frames as they learn and at the end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/project/project.h"
#include "core/train/mode.h"

namespace likeness {

enum class Encoder { grid, mlp };
inline constexpr const char* kEncoders[] = {"grid", "mlp"};

struct ModelKind {
  FieldMode mode = kDefaultMode;
  Encoder encoder = Encoder::grid;
  bool operator==(const ModelKind&) const = default;
};
std::string model_name(const ModelKind& kind);  // "concat, mlp"
// The table's rows in its order: all five with the grid, all but warp+hyper with perceptrons.
std::vector<ModelKind> model_kinds();

struct ModesOptions {
  std::vector<FieldMode> modes;      // empty = all
  std::vector<Encoder> encoders;     // empty = both
  double seconds = 120;              // of training, each
  std::uint64_t steps = 0;           // of each row with the grid, instead of seconds
  std::uint64_t baseline_steps = 0;  // of each row with perceptrons, instead of seconds
  int size = 0;                      // px; 0 = the project's
  int frames = 10;                   // held out that are measured, evenly chosen; 0 = all
  int rays = 8192;                   // of each step of the grid
  int seeds = 1;
  std::uint64_t first_seed = 0;
};

struct ModelMark {  // on at most four of the held-out frames, the training's clock stopped
  double seconds = 0;
  std::uint64_t step = 0;
  std::optional<double> psnr_db;
  double psnr_head_db = 0;
};

struct ModelScore {
  std::uint64_t seed = 0, steps = 0, parameters = 0;
  int frames = 0;
  std::optional<double> psnr_db, ssim, gmsd;  // absent where the background is not modelled
  double psnr_person_db = 0, psnr_head_db = 0, psnr_face_db = 0;
  double landmark_error_px = 0;
  double frame_ms = 0, train_seconds = 0;
  std::vector<ModelMark> marks;  // the last is that of the finished model
};

struct ModelRow {
  ModelKind kind;
  std::vector<ModelScore> scores;     // one a seed
  std::vector<std::string> pictures;  // of the first seed: file names in the study's folder, by shown frame
};

struct ModesStudy {
  std::string clip;
  int size = 0, training_frames = 0, threads = 0;
  std::vector<int> frames;          // held out, measured
  std::vector<int> shown;           // of these, those with pictures
  std::vector<std::string> truths;  // their files
  std::vector<ModelRow> rows;
};

// The project must be tracked and matted, regions included; it is not changed. Works in `folder`: a finished
// training is kept there with its scores and pictures, and a second call with the same options goes on where
// the first stopped. Writes results.csv, results.json, the plots and report.html when all rows are there. The
// program is none of the inputs: after an update take a new folder.
Result<ModesStudy> study_modes(const Project& project, const std::filesystem::path& folder,
                               const ModesOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness
