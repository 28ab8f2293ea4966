// See model_rows.h.
#include "core/lab/study/model_rows.h"

namespace likeness {
namespace {

void look_ahead(Track& track, const HeadModel& model) {
  const Articulation rest = neutral_articulation(model);
  for (TrackedFrame& frame : track.frames) {
    frame.pose.articulation.left_eye = rest.left_eye;
    frame.pose.articulation.right_eye = rest.right_eye;
  }
  track.neutral.left_eye = rest.left_eye;
  track.neutral.right_eye = rest.right_eye;
}

void drop_torso(Track& track, const HeadModel&) { track.has_torso = false; }

}  // namespace

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
       .about = "without latent codes for the frames",
       .parts = [](ChosenParts& p) { p.latent = false; }},
      {.name = "no-proxies",
       .about = "nothing taught of what was not filmed",
       .parts = [](ChosenParts& p) { p.proxies = false; }},
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
      {.name = "landmarks", .about = "tracked by landmarks alone", .track = {.step = "landmarks"}},
      {.name = "no-pictures",
       .about = "tracked with dense poses, without the photometric step",
       .track = {.step = "dense"}},
      {.name = "own-shape",
       .about = "tracked with the silhouettes and the person's own shape",
       .track = {.step = "shape"}},
      {.name = "no-gaze",
       .about = "eyes that look straight ahead",
       .track = {.change = look_ahead, .same_mattes = true}},
      {.name = "no-torso-track",
       .about = "no torso tracked, nor used by the mattes",
       .track = {.change = drop_torso}},
      {.name = "no-person-network",
       .about = "mattes without the person network",
       .track = {.person_network = false}},
      {.name = "no-displacement", .about = "without the project's detail maps", .track = {.maps = false}},
      {.name = "no-gaze-slice",
       .about = "a slice that does not depend on where the eyes look",
       .parts = [](ChosenParts& p) { p.gaze = false; }},
      {.name = "no-plate",
       .about = "learnt without the plate: mattes alone separate the person",
       .parts = [](ChosenParts& p) { p.plate = false; }},
      {.name = "as-filmed",
       .about = "exposure and white balance as they wander in the frames",
       .parts = [](ChosenParts& p) { p.exposures.clear(); }},
      {.name = "code-2",
       .about = "codes of 2 numbers instead of 4",
       .parts = [](ChosenParts& p) { p.sizes.code_length = 2; }},
      {.name = "code-8",
       .about = "codes of 8 numbers",
       .parts = [](ChosenParts& p) { p.sizes.code_length = 8; }},
      {.name = "still",
       .about = "hair and skull without the expression, however little the head turns",
       .change = [](TrainOptions& o) { o.fields.use_still = true; }},
      {.name = "no-still",
       .about = "the expression everywhere, hair and skull included",
       .change = [](TrainOptions& o) { o.fields.use_still = false; }},
      {.name = "no-occupancy",
       .about = "every carved cell occupied, samples spread evenly",
       .change = [](TrainOptions& o) { o.rays.use_occupancy = false; }},
      {.name = "canonical-occupancy",
       .about = "empty cells known in the canonical face, looked up through the deformation",
       .change = [](TrainOptions& o) { o.rays.canonical_occupancy = true; }},
      {.name = "samples-even",
       .about = "training's samples spread evenly over occupied cells",
       .change = [](TrainOptions& o) { o.rays.even_samples = 1; }},
      {.name = "samples-quarter",
       .about = "a quarter of training's samples spread evenly",
       .change = [](TrainOptions& o) { o.rays.even_samples = 0.25f; }},
      {.name = "refine-track",
       .about = "training frames corrected through the field",
       .change = [](TrainOptions& o) { o.refine_track = true; }},
      {.name = "landmark-10th",
       .about = "with the landmark loss, weight 0.01",
       .change = [](TrainOptions& o) { o.losses.landmark_weight = 0.01; }},
      {.name = "landmark-100th",
       .about = "with the landmark loss, weight 0.001",
       .change = [](TrainOptions& o) { o.losses.landmark_weight = 0.001; }},
      {.name = "landmark-rays",
       .about = "the landmark loss's patches of rays, the loss itself next to nothing",
       .change = [](TrainOptions& o) { o.losses.landmark_weight = 1e-9; }},
      {.name = "attribute", .about = "with the attributes that were painted", .attributes = true},
  };
  return models;
}

const std::vector<StudyTable>& study_tables() {
  static const std::vector<StudyTable> tables{
      {"models",
       "The papers' models",
       "All trained for the same time, if not by steps. grid: hash grids; mlp: positional encoding and "
       "perceptrons of 8 x 256 with a coarse and a fine pass of 32 samples.",
       {"moved-picture", "concat-mlp", "hyper-mlp", "warp-mlp", "painted-grid", "static-grid", "concat-grid",
        "hyper-grid", "warp-grid", kDefaultModel}},
      {"time",
       "Time to quality",
       "The baseline that the papers compare with is given forty times the time; ours from a quarter of that "
       "time to five times as much.",
       {kLongBaseline, "ours-quarter", "ours-half", kDefaultModel, "ours-long"}},
      {"parts",
       "With a part more or less",
       "Equal time, if not by steps. warp-grid is without the slice, hyper-grid without the deformation, "
       "concat-grid without either.",
       {kDefaultModel, "warp-grid", "hyper-grid", "concat-grid", "static-grid", "no-code", "no-proxies",
        "no-torso", "tenth", "landmark-loss", "k-preset", "grid-half", "grid-double", "grid-coarse"},
       {"landmarks",      "no-pictures",       "own-shape",       "no-gaze",
        "no-torso-track", "no-person-network", "no-displacement", "no-gaze-slice",
        "no-plate",       "as-filmed",         "code-2",          "code-8",
        "still",          "no-still",          "no-occupancy",    "canonical-occupancy",
        "samples-even",   "samples-quarter",   "refine-track",    "landmark-10th",
        "landmark-100th", "landmark-rays",     "attribute"}},
  };
  return tables;
}

}  // namespace likeness
