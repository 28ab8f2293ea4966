// What the default study trains, table by table.
#include "core/lab/study/model_study.h"

namespace likeness {

const std::vector<ModelSpec>& study_models() {
  using enum FieldMode;
  using enum ModelKind;
  static const std::vector<ModelSpec> models{
      {"static-grid", "no expression at all", grid, static_},
      {"concat-grid", "expression beside the features", grid, concat},
      {"hyper-grid", "a slice chosen by the expression (Kwak & Ko)", grid, hyper},
      {"warp-grid", "the head model's deformation, expression beside the features", grid, warp},
      {.name = kDefaultModel, .about = "deformation and slice: what a build makes", .costs = true},
      {"concat-mlp", "NeRFace-like", mlp, concat},
      {.name = "hyper-mlp",
       .about = "HyperNeRF-like, given the expression",
       .kind = mlp,
       .mode = hyper,
       .once = true},
      {.name = "warp-mlp", .about = "RigNeRF-like", .kind = mlp, .mode = warp, .once = true},
      {.name = "painted-grid",
       .about = "CoNeRF-like: a slice chosen by painted attributes alone",
       .mode = hyper,
       .once = true,
       .painted = true,
       .change = [](TrainOptions& o) { o.fields.use_expression = false; }},
      {.name = "moved-picture",
       .about = "FOMM-like: one picture moved by landmarks",
       .kind = moved,
       .once = true},
      {.name = kLongBaseline,
       .about = "NeRFace-like, forty times as long",
       .kind = mlp,
       .mode = concat,
       .share = kBaselineShare,
       .once = true,
       .costs = true},
      {.name = "ours-quarter", .about = "a build's, a quarter as long", .share = 0.25},
      {.name = "ours-half", .about = "a build's, half as long", .share = 0.5},
      {.name = "ours-long", .about = "a build's, five times as long", .share = 5, .once = true},
      {.name = "tenth", .about = "a tenth of the training frames", .keep_every = 10},
      {.name = "landmark-loss",
       .about = "with the landmark loss, weight 0.1",
       .change = [](TrainOptions& o) { o.losses.landmark_weight = 0.1; }},
      {.name = "k-preset",
       .about = "256 x 256 rays a step and the landmark loss: Kwak & Ko's settings",
       .change = [](TrainOptions& o) { o.rays.per_step = 256 * 256, o.losses.landmark_weight = 0.1; }},
      {.name = "no-code",
       .about = "without a code of its own for each frame",
       .parts = [](ChosenParts& p) { p.latent = false; }},
      {.name = "no-torso",
       .about = "without a field of the torso",
       .parts = [](ChosenParts& p) { p.torso = false; }},
      {.name = "grid-half",
       .about = "half the entries in both grids",
       .parts = [](ChosenParts& p) { --p.sizes.head_log2_entries, --p.sizes.torso_log2_entries; }},
      {.name = "grid-double",
       .about = "twice the entries in both grids",
       .parts = [](ChosenParts& p) { ++p.sizes.head_log2_entries, ++p.sizes.torso_log2_entries; }},
      {.name = "grid-coarse",
       .about = "grids whose finest cells are twice as wide",
       .parts = [](ChosenParts& p) { p.sizes.head_finest /= 2, p.sizes.torso_finest /= 2; }},
  };
  return models;
}

const std::vector<StudyTable>& study_tables() {
  static const std::vector<StudyTable> tables{
      {"models",
       "The papers' models",
       "All trained for the same time, if not by steps. grid: hash grids; mlp: positional encoding and "
       "perceptrons of 8 x 256 "
       "with "
       "a coarse and a fine pass of 32 samples.",
       {"moved-picture", "concat-mlp", "hyper-mlp", "warp-mlp", "painted-grid", "static-grid", "concat-grid",
        "hyper-grid", "warp-grid", kDefaultModel}},
      {"time",
       "Time to quality",
       "The baseline that the papers compare with is given forty times the time; ours a quarter of it to "
       "five "
       "times as much.",
       {kLongBaseline, "ours-quarter", "ours-half", kDefaultModel, "ours-long"}},
      {"parts",
       "With a part more or less",
       "Equal time, if not by steps. Without the slice is warp-grid, without the deformation hyper-grid, "
       "without either "
       "concat-grid.",
       {kDefaultModel, "warp-grid", "hyper-grid", "concat-grid", "static-grid", "no-code", "no-torso",
        "tenth", "landmark-loss", "k-preset", "grid-half", "grid-double", "grid-coarse"}},
  };
  return tables;
}

}  // namespace likeness
