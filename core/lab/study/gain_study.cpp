// One project a variant and seed, side by side in a folder: see gain_study.h.
#include "core/lab/study/gain_study.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/head/detail_maps.h"
#include "core/lab/score/evaluate.h"
#include "core/lab/study/finished_rows.h"
#include "core/lab/truth/track_study.h"
#include "core/matte/matte.h"
#include "core/project/corrections.h"
#include "core/project/project_attributes.h"
#include "core/project/project_detail.h"
#include "core/project/project_head_model.h"
#include "core/project/training_set.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAttributeRow = "attribute";

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

struct Inputs {
  const Project& project;
  Capture capture;
  CameraSet cameras;
  HeadModel model;
  std::string content;  // hash of all that tracks depend on, besides the steps
};

Result<Inputs> load_inputs(const Project& project) {
  auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  auto cameras = read_cameras(cameras_path(project));
  if (!cameras) return cameras.error();
  auto model = project_head_model(project.options);
  if (!model) return model.error();
  if (std::error_code ignored; !fs::is_directory(regions_path(project), ignored)) {
    return Error{ErrorCode::not_found,
                 fmt::format("{} has no evaluation regions yet.", project.folder.string()),
                 fmt::format("Run: likeness fit {}", project.folder.string()), project.folder.string()};
  }
  const auto capture_hash = hash_file(capture_path(project)), cameras_hash = hash_file(cameras_path(project));
  if (!capture_hash) return capture_hash.error();
  if (!cameras_hash) return cameras_hash.error();
  std::string content =
      *capture_hash + *cameras_hash + model->hash + project.options.shared.landmark_model.string();
  return Inputs{project, std::move(*capture), std::move(*cameras), std::move(*model), std::move(content)};
}

// The track of one step, made once for all variants and seeds that start from it.
Result<fs::path> make_track(const Inputs& inputs, const std::string& step, const fs::path& folder,
                            const Progress& progress, std::stop_token stop) {
  const fs::path path =
      folder / fmt::format("{}-{}.track.json", step, hash_text(inputs.content).substr(0, 8));
  if (std::error_code ignored; fs::exists(path, ignored)) return path;
  TrackOptions base;
  base.predictor = inputs.project.options.shared.landmark_model;
  const auto steps = track_steps({step}, base);
  if (!steps) return steps.error();
  const SquareCrop& crop = inputs.capture.crop;
  auto track =
      track_clip(inputs.project.options.shared.video, {crop.x, crop.y, crop.side, crop.side}, inputs.cameras,
                 held_out_frames(inputs.capture), inputs.model, steps->front().options, progress, stop);
  if (!track) return track.error();
  if (const auto written = write_track(path, *track); !written) return written.error();
  return path;
}

// Shows what lies in a folder in another one, too. What is there already stays.
Result<void> share(const fs::path& from, const fs::path& to, std::initializer_list<const char*> names) {
  std::error_code failure;
  for (const char* name : names) {
    const fs::path source = fs::absolute(from / name);
    if (failure || !fs::exists(source, failure) || fs::exists(to / name, failure)) continue;
    fs::remove(to / name, failure);  // a link to where the project once was
    fs::is_directory(source) ? fs::create_directory_symlink(source, to / name, failure)
                             : fs::create_symlink(source, to / name, failure);
  }
  if (failure) return file_error(to, "write", failure.value());
  return {};
}

Result<void> matte(const Inputs& inputs, const fs::path& folder, const Track& track, const Progress& progress,
                   std::stop_token stop) {
  auto strokes = read_corrections(inputs.project);
  if (!strokes) return strokes.error();
  const auto matted =
      matte_clip(folder, inputs.capture, inputs.cameras, track, inputs.model,
                 {.size = inputs.capture.size, .strokes = std::move(*strokes)}, progress, stop);
  return matted ? Result<void>() : Result<void>(matted.error());
}

// The mattes by a track, made once for all variants and seeds that leave it as it is.
Result<fs::path> make_mattes(const Inputs& inputs, const Track& track, const std::string& content,
                             const fs::path& folder, const Progress& progress, std::stop_token stop) {
  const fs::path path = folder / fmt::format("mattes-{}", hash_text(content).substr(0, 8));
  std::error_code failure;
  if (fs::exists(path, failure)) return path;
  const fs::path part = folder / fmt::format(".{}.part", path.filename().string());
  if (const auto made = make_writable_folder(part); !made) return made.error();
  if (const auto shared = share(inputs.project.folder, part, {"frames", "regions"}); !shared)
    return shared.error();
  if (const auto matted = matte(inputs, part, track, progress, stop); !matted) return matted.error();
  fs::rename(part, path, failure);
  if (failure) return file_error(path, "write", failure.value());
  return path;
}

// A project folder that shares the pictures of the studied one and has a track of its own. mattes: a folder
// of make_mattes; empty: made of this track here.
Result<Project> make_workplace(const Inputs& inputs, const fs::path& folder, const Track& track,
                               const fs::path& mattes, bool maps, const Progress& progress,
                               std::stop_token stop) {
  Project work = inputs.project;
  work.folder = folder;
  work.further_clips.clear();  // the parts are compared on one clip
  if (const auto made = make_writable_folder(folder); !made) return made.error();
  if (const auto shared =
          share(inputs.project.folder, folder, {"frames", "regions", "capture.json", "cameras.json"});
      !shared)
    return shared.error();
  if (const auto written = write_track(track_path(work), track); !written) return written.error();
  if (const auto forgotten = forget_project_detail(work); !forgotten) return forgotten.error();
  if (maps && !work.options.fit.displacement.empty()) {
    DetailReport report;
    const auto detail =
        learn_project_detail(work.options.fit.displacement, inputs.capture, track, inputs.model, report);
    if (!detail) return detail.error();
    if (const auto written = write_project_detail(work, *detail); !written) return written.error();
  }
  const auto matted = mattes.empty()
                          ? matte(inputs, folder, track, progress, stop)
                          : share(mattes, folder, {"masks", "plate.png", "plate_known.png", "plate.json"});
  if (!matted) return matted.error();
  return work;
}

nlohmann::json to_json(const GainScore& s) {
  return {{"format", "likeness-gain"},
          {"version", 1},
          {"seed", s.seed},
          {"frames", s.frames},
          {"lost", s.lost},
          {"psnr_db", finite_or_null(s.psnr_db)},
          {"psnr_person_db", finite_or_null(s.psnr_person_db)},
          {"psnr_head_db", finite_or_null(s.psnr_head_db)},
          {"psnr_face_db", finite_or_null(s.psnr_face_db)},
          {"lmk_error_px", finite_or_null(s.landmarks_px.inner)},
          {"lmk_mouth_px", finite_or_null(s.landmarks_px.mouth)},
          {"lmk_eyes_px", finite_or_null(s.landmarks_px.eyes)},
          {"psnr_refit_db", finite_or_null(s.psnr_refit_db)},
          {"psnr_refit_head_db", finite_or_null(s.psnr_refit_head_db)},
          {"psnr_refit_face_db", finite_or_null(s.psnr_refit_face_db)},
          {"train_seconds", s.train_seconds},
          {"samples_per_ray", finite_or_null(s.samples_per_ray)}};
}

// Absent where there is none, or where it was made from other inputs.
std::optional<GainScore> read_gain_score(const fs::path& path, const std::string& content) {
  const auto json = read_finished(path, content);
  if (!json) return std::nullopt;
  try {
    GainScore s;
    s.seed = json->at("seed").get<std::uint64_t>();
    s.frames = json->at("frames").get<int>();
    s.lost = json->at("lost").get<int>();
    s.psnr_db = optional_number(json->at("psnr_db"));
    s.psnr_person_db = number_or_nan(json->at("psnr_person_db"));
    s.psnr_head_db = number_or_nan(json->at("psnr_head_db"));
    s.psnr_face_db = number_or_nan(json->at("psnr_face_db"));
    s.landmarks_px = {number_or_nan(json->at("lmk_error_px")), number_or_nan(json->at("lmk_mouth_px")),
                      number_or_nan(json->at("lmk_eyes_px"))};
    s.psnr_refit_db = optional_number(json->at("psnr_refit_db"));
    s.psnr_refit_head_db = optional_number(json->at("psnr_refit_head_db"));
    s.psnr_refit_face_db = optional_number(json->at("psnr_refit_face_db"));
    s.train_seconds = json->at("train_seconds").get<double>();
    if (json->contains("samples_per_ray")) s.samples_per_ray = optional_number(json->at("samples_per_ray"));
    return s;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

Result<GainScore> train_and_score(const Inputs& inputs, const GainVariant& variant,
                                  const GainOptions& options, std::uint64_t seed, const Project& work,
                                  const Progress& progress, std::stop_token stop) {
  auto set = load_training_set(work, inputs.model);
  if (!set) return set.error();
  if (variant.attributes) {
    const auto painted = read_project_attributes(inputs.project);
    if (!painted) return painted.error();
    const auto found = find_attributes(work, *painted, *set, progress.stage(0, 0, "attributes"), stop);
    if (!found) return found.error();
    take_attributes(*found, *set);
    std::vector<AttributeCourse> courses;
    for (const FoundAttribute& attribute : *found) courses.push_back(attribute.course);
    if (const auto kept = write_attribute_values(attribute_values_path(work), courses); !kept)
      return kept.error();
  }
  ChosenParts chosen =
      choose_parts(measure_capture(*set, shape_head(inputs.model, set->person)), AskedParts{});
  if (variant.parts != nullptr) variant.parts(chosen);
  const Image8 plate = set->plate;
  TrainOptions training;
  apply_parts(chosen, *set, training);
  training.schedule.steps = options.steps;
  training.rays.per_step = options.rays;
  training.seed = seed;
  if (variant.train != nullptr) variant.train(training);
  double samples_per_ray = 0;
  auto avatar = train_avatar(
      *set, training, checkpoint_path(work), progress.stage(0, 0.8, "train"),
      [&](const TrainStatus& status) { samples_per_ray = status.samples_per_ray; }, stop);
  if (!avatar) return avatar.error();
  avatar->plate = plate;  // pictures are made before it, whatever was learnt
  if (const auto written = write_avatar(avatar_path(work), *avatar); !written) return written.error();
  EvalOptions evaluation;
  evaluation.refit = options.refit;
  const auto e = evaluate(work, evaluation, progress.stage(0.8, 1, "evaluate"), stop);
  if (!e) return e.error();
  GainScore s{.seed = seed, .frames = e->frames_test, .lost = e->frames_lost, .psnr_db = e->psnr_db};
  s.psnr_person_db = e->psnr_person_db;
  s.psnr_head_db = e->psnr_head_db;
  s.psnr_face_db = e->psnr_face_db;
  s.landmarks_px = e->landmarks_px;
  s.train_seconds = avatar->train_seconds;
  if (samples_per_ray > 0) s.samples_per_ray = samples_per_ray;
  if (e->refit) {
    s.psnr_refit_db = e->refit->psnr_db;
    s.psnr_refit_head_db = e->refit->psnr_head_db;
    s.psnr_refit_face_db = e->refit->psnr_face_db;
  }
  return s;
}

Result<GainScore> run_variant(const Inputs& inputs, const GainVariant& variant, const GainOptions& options,
                              std::uint64_t seed, const fs::path& folder, const Progress& progress,
                              std::stop_token stop) {
  const auto tracked = make_track(inputs, variant.track_step, folder, progress.stage(0, 0.5, "track"), stop);
  if (!tracked) return tracked.error();
  auto track = read_track(*tracked);
  if (!track) return track.error();
  track->head_model_file = inputs.project.options.shared.head_model.string();
  if (variant.change != nullptr) variant.change(*track, inputs.model);
  const auto track_hash = hash_file(*tracked);
  if (!track_hash) return track_hash.error();
  std::string maps;
  if (variant.maps && !inputs.project.options.fit.displacement.empty()) {
    const auto hash = detail_maps_hash(inputs.project.options.fit.displacement);
    if (!hash) return hash.error();
    maps = " maps " + *hash;
  }
  const std::string content = hash_text(
      fmt::format("{} {} {} {} {} {} {}{}{} {}", inputs.content, *track_hash, variant.name, options.steps,
                  options.rays, seed, options.refit, corrections_hash(inputs.project), maps,
                  fmt::join(inputs.project.options.train.left_out, ",")) +
      (variant.attributes ? attributes_hash(inputs.project) : ""));
  const std::string name = fmt::format("{}-{}", variant.name, seed);
  if (auto done = read_gain_score(folder / (name + ".json"), content)) return *done;
  fs::path mattes;
  if (variant.change == nullptr) {
    const auto made = make_mattes(inputs, *track, *track_hash + corrections_hash(inputs.project), folder,
                                  progress.stage(0.5, 0.6, "matte"), stop);
    if (!made) return made.error();
    mattes = *made;
  }
  // Named by what it is made from, so that nothing of other inputs is left in it.
  const auto work = make_workplace(inputs, folder / fmt::format("{}-{}.likeness", name, content.substr(0, 8)),
                                   *track, mattes, variant.maps, progress.stage(0.5, 0.6, "matte"), stop);
  if (!work) return work.error();
  auto score = train_and_score(inputs, variant, options, seed, *work, progress.stage(0.6, 1, name), stop);
  if (!score) return score.error();
  if (const auto written = write_finished(folder / (name + ".json"), content, to_json(*score)); !written)
    return written.error();
  return *score;
}

// All of them, but of a project without attributes or maps the row with or without them.
Result<std::vector<GainVariant>> chosen_variants(const std::vector<std::string>& names, bool has_attributes,
                                                 bool has_maps) {
  if (names.empty()) {
    std::vector<GainVariant> all = gain_variants();
    std::erase_if(all, [&](const GainVariant& v) {
      return (v.attributes && !has_attributes) || (!v.maps && !has_maps);
    });
    return all;
  }
  std::vector<GainVariant> chosen;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(gain_variants(), name, &GainVariant::name);
    if (found == gain_variants().end()) {
      std::vector<std::string> known;
      for (const GainVariant& v : gain_variants()) known.push_back(v.name);
      return Error{ErrorCode::bad_input, fmt::format("There is no variant named \"{}\".", name),
                   fmt::format("Choose from: {}.", fmt::join(known, ", ")), ""};
    }
    if (found->attributes && !has_attributes)
      return Error{ErrorCode::not_found, "The project has no painted attributes.",
                   "Paint one: likeness attribute add PROJECT NAME ...", "attributes.json"};
    chosen.push_back(*found);
  }
  return chosen;
}

}  // namespace

const std::vector<GainVariant>& gain_variants() {
  static const std::vector<GainVariant> variants{
      {"default", "as built, from the clip and its strokes alone", "photometric"},
      {"landmarks", "landmark fit alone", "landmarks"},
      {"no-pictures", "dense poses, without the photometric step", "dense"},
      {"own-shape", "with the silhouettes and a shape of the person's own", "shape"},
      {"no-gaze", "eyes that look straight ahead", "photometric", look_ahead},
      {"no-torso", "without a torso", "photometric", drop_torso},
      {"no-warp", "without the head model's deformation", "photometric", nullptr,
       [](TrainOptions& o) { o.fields.mode = FieldMode::hyper; }},
      {"no-slice", "the deformation, and psi beside the features", "photometric", nullptr,
       [](TrainOptions& o) { o.fields.mode = FieldMode::warp; }},
      {"no-displacement", "without the detail maps that the project was given", "photometric", nullptr,
       nullptr, nullptr, false},
      {"no-expression", "a field that knows no expression: neither slice nor deformation", "photometric",
       nullptr, [](TrainOptions& o) { o.fields.mode = FieldMode::static_; }},
      {"no-gaze-slice", "a slice that is not told where the eyes look", "photometric", nullptr, nullptr,
       [](ChosenParts& p) { p.gaze = false; }},
      {"no-torso-field", "tracked as ever, without the torso's field", "photometric", nullptr, nullptr,
       [](ChosenParts& p) { p.torso = false; }},
      {"no-plate", "learnt without the plate: mattes alone separate the person", "photometric", nullptr,
       nullptr, [](ChosenParts& p) { p.plate = false; }},
      {"no-code", "without a code for each frame", "photometric", nullptr, nullptr,
       [](ChosenParts& p) { p.latent = false; }},
      {"code-2", "codes of 2 numbers instead of 4", "photometric", nullptr, nullptr,
       [](ChosenParts& p) { p.sizes.code_length = 2; }},
      {"code-8", "codes of 8 numbers", "photometric", nullptr, nullptr,
       [](ChosenParts& p) { p.sizes.code_length = 8; }},
      {"grid-half", "half the entries in both grids", "photometric", nullptr, nullptr,
       [](ChosenParts& p) { --p.sizes.head_log2_entries, --p.sizes.torso_log2_entries; }},
      {"grid-double", "twice the entries in both grids", "photometric", nullptr, nullptr,
       [](ChosenParts& p) { ++p.sizes.head_log2_entries, ++p.sizes.torso_log2_entries; }},
      {"grid-coarse", "grids whose finest cells are twice as wide", "photometric", nullptr, nullptr,
       [](ChosenParts& p) { p.sizes.head_finest /= 2, p.sizes.torso_finest /= 2; }},
      {"still", "hair and skull told no expression, however little the head turns", "photometric", nullptr,
       [](TrainOptions& o) { o.fields.use_still = true; }},
      {"no-still", "expressions everywhere, hair and skull included", "photometric", nullptr,
       [](TrainOptions& o) { o.fields.use_still = false; }},
      {"no-occupancy", "every carved cell occupied, samples spread evenly", "photometric", nullptr,
       [](TrainOptions& o) { o.rays.use_occupancy = false; }},
      {"canonical-occupancy", "empty cells known in the canonical face, looked up through the deformation",
       "photometric", nullptr, [](TrainOptions& o) { o.rays.canonical_occupancy = true; }},
      {"samples-even", "training's samples spread evenly over occupied cells", "photometric", nullptr,
       [](TrainOptions& o) { o.rays.even_samples = 1; }},
      {"samples-quarter", "a quarter of training's samples spread evenly", "photometric", nullptr,
       [](TrainOptions& o) { o.rays.even_samples = 0.25f; }},
      {"refine-track", "training frames corrected through the field", "photometric", nullptr,
       [](TrainOptions& o) { o.refine_track = true; }},
      {"landmark-loss", "with the landmark loss, weight 0.1", "photometric", nullptr,
       [](TrainOptions& o) { o.losses.landmark_weight = 0.1; }},
      {"landmark-10th", "with the landmark loss, weight 0.01", "photometric", nullptr,
       [](TrainOptions& o) { o.losses.landmark_weight = 0.01; }},
      {"landmark-100th", "with the landmark loss, weight 0.001", "photometric", nullptr,
       [](TrainOptions& o) { o.losses.landmark_weight = 0.001; }},
      {"landmark-rays", "the landmark loss's patches of rays, the loss itself next to nothing", "photometric",
       nullptr, [](TrainOptions& o) { o.losses.landmark_weight = 1e-9; }},
      {.name = kAttributeRow,
       .about = "with the attributes that were painted",
       .track_step = "photometric",
       .attributes = true},
  };
  return variants;
}

Result<std::vector<GainRow>> study_gains(const Project& project, const fs::path& folder,
                                         const GainOptions& options, const Progress& progress,
                                         std::stop_token stop) {
  const auto variants = chosen_variants(options.variants, !attributes_hash(project).empty(),
                                        !project.options.fit.displacement.empty());
  if (!variants) return variants.error();
  const auto inputs = load_inputs(project);
  if (!inputs) return inputs.error();
  if (const auto made = make_writable_folder(folder); !made) return made.error();
  std::vector<GainRow> rows;
  const double runs = double(variants->size()) * options.seeds;
  double done = 0;
  for (const GainVariant& variant : *variants) {
    GainRow& row = rows.emplace_back(variant.name, variant.about);
    for (int seed = 0; seed < options.seeds; ++seed, ++done) {
      const Progress part = progress.stage(done / runs, (done + 1) / runs, variant.name);
      const auto score = run_variant(*inputs, variant, options, options.first_seed + std::uint64_t(seed),
                                     folder, part, stop);
      if (!score) return score.error();
      row.scores.push_back(*score);
    }
  }
  progress.report(1);
  return rows;
}

}  // namespace likeness
