// The models that a study trains and the tables that they stand in: the default study, row by row.
#pragma once

#include <string>
#include <vector>

#include "core/lab/study/variant_project.h"
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

}  // namespace likeness
