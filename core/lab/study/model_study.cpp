// The study's tables, model after model: see model_study.h.
#include "core/lab/study/model_study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/json_text.h"
#include "core/base/parallel.h"
#include "core/capture/capture.h"
#include "core/image/files.h"
#include "core/lab/study/finished_rows.h"
#include "core/lab/study/model_report.h"
#include "core/lab/study/model_run.h"
#include "core/lab/study/study_forecast.h"
#include "core/lab/study/track_annotations.h"
#include "core/papers/sparse_voxels.h"
#include "core/project/training_set.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMarkFrames = 4, kShownFrames = 3;

// -- Finished trainings

nlohmann::json to_json(const ModelScore& s) {
  nlohmann::json marks = nlohmann::json::array(), qualities = marks, sizes = marks;
  for (const ModelMark& m : s.marks)
    marks.push_back({{"seconds", m.seconds},
                     {"step", m.step},
                     {"psnr_db", finite_or_null(m.psnr_db)},
                     {"psnr_head_db", finite_or_null(m.psnr_head_db)}});
  for (const PictureCost& q : s.qualities)
    qualities.push_back({{"name", q.name},
                         {"psnr_db", finite_or_null(q.psnr_db)},
                         {"psnr_head_db", finite_or_null(q.psnr_head_db)},
                         {"frame_seconds", q.frame_seconds},
                         {"psnr_face_db", finite_or_null(q.psnr_face_db)},
                         {"bytes", q.bytes}});
  for (const SizeCost& z : s.sizes) sizes.push_back({{"size", z.size}, {"frame_seconds", z.frame_seconds}});
  return {{"format", "likeness-model"},
          {"version", 1},
          {"seed", s.seed},
          {"steps", s.steps},
          {"parameters", s.parameters},
          {"frames", s.frames},
          {"psnr_db", finite_or_null(s.psnr_db)},
          {"mse", finite_or_null(s.mse)},
          {"ssim", finite_or_null(s.ssim)},
          {"gmsd", finite_or_null(s.gmsd)},
          {"lpips", finite_or_null(s.lpips)},
          {"psnr_person_db", finite_or_null(s.psnr_person_db)},
          {"psnr_head_db", finite_or_null(s.psnr_head_db)},
          {"psnr_face_db", finite_or_null(s.psnr_face_db)},
          {"face_mse", finite_or_null(s.face_mse)},
          {"lmk_error_px", finite_or_null(s.landmark_error_px)},
          {"lmk_mouth_px", finite_or_null(s.mouth_error_px)},
          {"lmk_eyes_px", finite_or_null(s.eyes_error_px)},
          {"psnr_refit_db", finite_or_null(s.psnr_refit_db)},
          {"psnr_refit_head_db", finite_or_null(s.psnr_refit_head_db)},
          {"psnr_refit_face_db", finite_or_null(s.psnr_refit_face_db)},
          {"samples_per_ray", finite_or_null(s.samples_per_ray)},
          {"lost", s.lost},
          {"frame_seconds", s.frame_seconds},
          {"frame_joules", finite_or_null(s.frame_joules)},
          {"train_seconds", s.train_seconds},
          {"marks", std::move(marks)},
          {"qualities", std::move(qualities)},
          {"sizes", std::move(sizes)}};
}

std::optional<ModelScore> read_model_score(const fs::path& path, const std::string& content) {
  const auto j = read_finished(path, content);
  if (!j) return std::nullopt;
  try {
    ModelScore s;
    j->at("seed").get_to(s.seed), j->at("steps").get_to(s.steps);
    j->at("parameters").get_to(s.parameters), j->at("frames").get_to(s.frames);
    s.psnr_db = optional_number(j->at("psnr_db"));
    s.mse = optional_number(j->at("mse"));
    s.ssim = optional_number(j->at("ssim"));
    s.gmsd = optional_number(j->at("gmsd"));
    s.lpips = optional_number(j->at("lpips"));
    s.psnr_person_db = number_or_nan(j->at("psnr_person_db"));
    s.psnr_head_db = number_or_nan(j->at("psnr_head_db"));
    s.psnr_face_db = number_or_nan(j->at("psnr_face_db"));
    s.face_mse = number_or_nan(j->at("face_mse"));
    s.landmark_error_px = number_or_nan(j->at("lmk_error_px"));
    s.mouth_error_px = number_or_nan(j->at("lmk_mouth_px"));
    // Rows kept by earlier versions lack these.
    const auto later = [&](const char* key) {
      return j->contains(key) ? optional_number(j->at(key)) : std::nullopt;
    };
    s.eyes_error_px = later("lmk_eyes_px");
    s.psnr_refit_db = later("psnr_refit_db");
    s.psnr_refit_head_db = later("psnr_refit_head_db");
    s.psnr_refit_face_db = later("psnr_refit_face_db");
    s.samples_per_ray = later("samples_per_ray");
    s.lost = j->value("lost", 0);
    j->at("frame_seconds").get_to(s.frame_seconds), j->at("train_seconds").get_to(s.train_seconds);
    s.frame_joules = optional_number(j->at("frame_joules"));
    for (const nlohmann::json& m : j->at("marks"))
      s.marks.push_back({.seconds = m.at("seconds").get<double>(),
                         .step = m.at("step").get<std::uint64_t>(),
                         .psnr_db = optional_number(m.at("psnr_db")),
                         .psnr_head_db = number_or_nan(m.at("psnr_head_db"))});
    for (const nlohmann::json& q : j->at("qualities"))
      s.qualities.push_back({.name = q.at("name").get<std::string>(),
                             .psnr_db = optional_number(q.at("psnr_db")),
                             .psnr_head_db = number_or_nan(q.at("psnr_head_db")),
                             .frame_seconds = q.at("frame_seconds").get<double>(),
                             .psnr_face_db = number_or_nan(q.at("psnr_face_db")),
                             .bytes = q.at("bytes").get<std::uint64_t>()});
    for (const nlohmann::json& z : j->at("sizes"))
      s.sizes.push_back({whole_number_in(z.at("size")), z.at("frame_seconds").get<double>()});
    return s;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

Result<ModelScore> finished_model(const StudyBench& bench, const ModelSpec& spec, std::uint64_t seed,
                                  const Progress& progress, std::stop_token stop) {
  const ModelStudyOptions& o = bench.options;
  const std::string asked = asked_training(o, spec, seed);
  std::string content = hash_text(fmt::format("{} {} {}", bench.clip.content, bench.measured.size(), asked));
  if (spec.painted || spec.attributes) content = hash_text(content + bench.painted);
  const fs::path path = training_path(bench.folder, spec, seed);
  if (auto done = read_model_score(path, content)) return *done;
  // Its pictures are written before its scores: old scores are removed first, so that both are always of one
  // training.
  std::error_code ignored;
  fs::remove(path, ignored);
  auto score = run_model(bench, spec, seed, asked_steps(o, spec, seed), progress, stop);
  if (!score) return score.error();
  nlohmann::json row = to_json(*score);
  row["asked"] = asked;
  if (const auto written = write_finished(path, content, std::move(row)); !written) return written.error();
  return score;
}

// -- What is asked for

template <class Named>
Result<void> check_names(const std::vector<std::string>& asked, const std::vector<Named>& known,
                         std::string_view what) {
  for (const std::string& name : asked)
    if (std::ranges::find(known, name, &Named::name) == known.end()) {
      std::vector<std::string> names;
      for (const Named& one : known) names.push_back(one.name);
      return Error{ErrorCode::bad_input, fmt::format("There is no {} named \"{}\".", what, name),
                   fmt::format("Choose from: {}.", fmt::join(names, ", ")), ""};
    }
  return {};
}

// A model without the head model's deformation maps no sample to canonical space: its regions must reach as
// far as what they hold moves, for instance a lip with the jaw.
constexpr RegionOptions kWideRegion{.rim = 0.03f, .reach = 0.04f, .far = 0.06f, .cell = 0.005f};

// Finds the attributes of the clip at its full size, and gives the held-out frames their amounts. They are
// those painted in the project `owner`; if there are none and `invent` is set, annotations made from the
// track stand in, of which those that cannot be learnt are left out.
Result<void> find_painted(const Project& project, const Project& owner, const RegionOptions& region,
                          bool invent, StudyBench& bench, const Progress& progress, std::stop_token stop) {
  Project one = project;
  one.further_clips.clear();  // as the sized clip
  auto set = load_training_set(one, bench.clip.set.model);
  if (!set) return set.error();
  const auto painted = read_project_attributes(owner);
  if (!painted) return painted.error();
  bench.painted = attributes_hash(owner);
  if (!painted->empty()) {
    auto found = find_attributes(one, *painted, *set, progress, stop, region);
    if (!found) return found.error();
    bench.attributes = std::move(*found);
  } else if (!invent) {
    return Error{ErrorCode::bad_input, "The project has no painted attributes.",
                 "Paint one: likeness attribute add PROJECT NAME ...", "attributes.json"};
  } else {
    const auto capture = read_capture(capture_path(project));
    if (!capture) return capture.error();
    for (const PaintedAttribute& attribute : annotate_from_track(*set, *capture)) {
      auto found = find_attributes(one, {attribute}, *set, progress, stop, region);
      if (found)
        bench.attributes.push_back(std::move(found->front()));
      else if (found.error().code != ErrorCode::bad_input)
        return found.error();
    }
    if (bench.attributes.empty())
      return Error{ErrorCode::bad_input,
                   "The track shows neither a mouth nor eyes that move enough to be annotated.",
                   "Paint an attribute: likeness attribute add PROJECT NAME ...", ""};
  }
  for (const FoundAttribute& attribute : bench.attributes)
    if (attribute.view_values.size() != bench.clip.set.views.size())
      return Error{ErrorCode::io, "The project was changed while it was read.", "Start the study again.",
                   project.folder.string()};
  for (HeldOutFrame& frame : bench.clip.held_out)
    for (const FoundAttribute& attribute : bench.attributes)
      frame.amounts.push_back(amount_at(attribute.course, frame.frame));
  return {};
}

// Whether an error concerns one model only, so that the others can still be trained.
bool concerns_one_model(const Error& error) {
  return error.code == ErrorCode::bad_input || error.code == ErrorCode::failed ||
         error.code == ErrorCode::not_found;
}

Result<StudyBench> prepare(const Project& project, const fs::path& folder, const ModelStudyOptions& options) {
  const auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  if (options.size > capture->size)
    return Error{
        ErrorCode::bad_input,
        fmt::format("The project's pictures have {} px, fewer than {}.", capture->size, options.size),
        fmt::format("Give --size {} or less, or import the clip larger.", capture->size), ""};
  auto clip = read_sized_clip(project, options.size);
  if (!clip) return clip.error();
  auto detector = FaceDetector::load(project.options.shared.landmark_model);
  if (!detector) return detector.error();
  std::optional<PerceptualNetwork> perceptual;
  if (!options.lpips.empty()) {
    auto network = PerceptualNetwork::load(options.lpips);
    if (!network) return network.error();
    perceptual.emplace(std::move(*network));
  }
  if (const auto made = make_writable_folder(folder); !made) return made.error();
  StudyBench bench{
      options, folder, std::move(*clip), capture->size, std::move(*detector), std::move(perceptual)};
  if (chosen_parts(bench, kDefaultMode).exposures.empty())  // too even to be heeded
    for (HeldOutFrame& frame : bench.clip.held_out) frame.exposure = Vec3f::Ones();
  bench.measured = evenly_chosen(bench.clip.held_out.size(), std::size_t(options.frames));
  bench.marked = evenly_chosen(bench.measured.size(), std::min(kMarkFrames, bench.measured.size()));
  bench.shown = evenly_chosen(bench.measured.size(), std::min(kShownFrames, bench.measured.size()));
  return bench;
}

// The bench of a row that varies the track or the painted attributes: its own clip, and the same frames.
Result<StudyBench> own_bench(const Project& project, const Project& studied, const StudyBench& shared,
                             const ModelSpec& spec, const Progress& progress, std::stop_token stop) {
  Result<Project> varied = studied;
  if (!spec.track.is_the_project_s())
    varied = make_variant_project(project, spec.name, spec.track, shared.folder, progress, stop);
  if (!varied) return varied.error();
  auto bench = prepare(*varied, shared.folder, shared.options);
  if (!bench) return bench.error();
  bench->full_size = shared.full_size;
  if (spec.attributes)
    if (const auto found = find_painted(*varied, project, {}, false, *bench, progress, stop); !found)
      return found.error();
  // Its pictures are of the same frames as the others'.
  bench->shown.clear();
  for (std::size_t k = 0; k < bench->measured.size(); ++k) {
    const int frame = bench->clip.held_out[bench->measured[k]].frame;
    if (std::ranges::any_of(shared.shown, [&](std::size_t i) {
          return shared.clip.held_out[shared.measured[i]].frame == frame;
        }))
      bench->shown.push_back(k);
  }
  return bench;
}

}  // namespace

Result<ModelStudy> study_models_of(const Project& project, const fs::path& folder,
                                   const ModelStudyOptions& options, const Progress& progress,
                                   std::stop_token stop) {
  if (const auto known = check_names(options.tables, study_tables(), "table"); !known) return known.error();
  if (const auto known = check_names(options.models, study_models(), "model"); !known) return known.error();
  for (const int cells : options.baked_cells)
    if (cells <= 0 || cells % kVoxelBlock != 0)
      return Error{ErrorCode::bad_input,
                   fmt::format("An avatar cannot be stored in {} cells along an axis.", cells),
                   fmt::format("Take a multiple of {}, e.g. --baked-cells 128 256.", kVoxelBlock), ""};
  ModelStudy study;
  const std::vector<ModelSpec> models = chosen_models(options, study.tables);
  for (const std::string& name : options.models)
    if (std::ranges::find(models, name, &ModelSpec::name) == models.end())
      return Error{ErrorCode::bad_input, fmt::format("The model {} is in none of these tables.", name),
                   "Leave out --tables, or that model.", ""};
  const double tracking = options.track_anew ? 0.2 : 0;
  Result<Project> studied = project;
  if (options.track_anew)
    studied = make_variant_project(project, "project", {.step = "photometric"}, folder,
                                   progress.stage(0, tracking, "track"), stop);
  if (!studied) return studied.error();
  const Progress rest = progress.stage(tracking, 1, "study");
  auto bench = prepare(*studied, folder, options);
  if (!bench) return bench.error();
  study.clip = project.options.shared.video.filename().string();
  study.size = bench->clip.set.size, study.full_size = bench->full_size;
  study.training_frames = int(bench->clip.set.views.size());
  study.parts = chosen_parts(*bench, kDefaultMode).parts;
  study.threads = current_thread_limit();
  const bool grids = options.steps > 0, perceptrons = options.mlp_steps > 0,
             replayed = !options.replay.empty();
  study.seconds = replayed || (grids && perceptrons) ? 0 : options.seconds;
  study.some_by_steps = grids || perceptrons;
  for (const std::size_t i : bench->measured) study.frames.push_back(bench->clip.held_out[i].frame);
  for (const std::size_t i : bench->shown) {
    const HeldOutFrame& frame = bench->clip.held_out[bench->measured[i]];
    study.shown.push_back(frame.frame);
    study.truths.push_back(fmt::format("truth-{:06}.png", frame.frame));
    if (const auto written = write_image(folder / study.truths.back(), frame.truth); !written)
      return written.error();
  }
  const auto trainings = [&](const ModelSpec& spec) { return spec.once ? 1 : options.seeds; };
  double all = 0, done = 0;
  for (const ModelSpec& spec : models)
    for (int k = 0; k < trainings(spec); ++k) all += training_work(spec, options, k == 0);
  // First, before hours are spent: what the user painted may not be enough.
  std::optional<Error> unpainted;
  if (std::ranges::any_of(models, &ModelSpec::painted))
    if (const auto found =
            find_painted(*studied, project, kWideRegion, true, *bench, rest.stage(0, 0, "attributes"), stop);
        !found) {
      if (!concerns_one_model(found.error())) return found.error();
      unpainted = found.error();
    }
  for (const ModelSpec& spec : models) {
    ModelRow& row = study.rows.emplace_back(ModelRow{spec, {}, {}});
    if (spec.painted && unpainted) {
      row.failed = unpainted->what;
      continue;
    }
    std::optional<StudyBench> own;
    if (spec.attributes || !spec.track.is_the_project_s()) {
      auto made =
          own_bench(project, *studied, *bench, spec, rest.stage(done / all, done / all, spec.name), stop);
      if (!made && !concerns_one_model(made.error())) return made.error();
      if (!made) {
        row.failed = made.error().what;
        continue;
      }
      own.emplace(std::move(*made));
    }
    for (int k = 0; k < trainings(spec); ++k) {
      const double after = done + training_work(spec, options, k == 0);
      const auto score = finished_model(own ? *own : *bench, spec, options.first_seed + std::uint64_t(k),
                                        rest.stage(done / all, std::min(1.0, after / all), spec.name), stop);
      if (!score && !concerns_one_model(score.error())) return score.error();
      done = after;
      if (!score) {
        row.failed = score.error().what;
        break;
      }
      row.scores.push_back(*score);
    }
    if (!row.failed.empty()) {
      row.scores.clear();
      continue;
    }
    for (const int frame : study.shown) {
      const std::string name = picture_name(spec, frame);
      std::error_code ignored;
      row.pictures.push_back(fs::exists(folder / name, ignored) ? name : std::string());
    }
  }
  if (const auto written = write_model_report(study, folder); !written) return written.error();
  progress.report(1);
  return study;
}

}  // namespace likeness
