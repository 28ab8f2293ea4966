// The order of the stages and what makes each stale: see run_stages.h.
#include "core/project/run_stages.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/memory.h"
#include "core/camera/align.h"
#include "core/camera/motion.h"
#include "core/capture/capture.h"
#include "core/capture/split.h"
#include "core/head/builtin_head.h"
#include "core/head/detail_maps.h"
#include "core/head/load_head_model.h"
#include "core/head/read_person.h"
#include "core/matte/matte.h"
#include "core/matte/matting_network.h"
#include "core/project/care.h"
#include "core/project/corrections.h"
#include "core/project/further_clips.h"
#include "core/project/learn_room.h"
#include "core/project/project_attributes.h"
#include "core/project/project_detail.h"
#include "core/project/project_views.h"
#include "core/project/refits.h"
#include "core/project/training_curve.h"
#include "core/render/room_picture.h"
#include "core/track/clip/track_clip.h"
#include "core/train/memory_forecast.h"
#include "core/video/decode.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// Raised when a stage's method changes so that its old results should be made anew.
constexpr std::array<int, kStages.size()> kStageVersion{1, 3, 6, 4, 4};
constexpr int kDetailVersion = 1;  // of what is learnt from detail maps
constexpr int kRefitVersion = 1;   // the same for spans fitted again

std::string content_of(const fs::path& path) {
  if (path.empty()) return "none";
  const auto hash = hash_file(path);
  return hash ? *hash : "absent";
}

// A head model may be a folder, or a file that is read together with others beside it.
std::string head_model_content(const ProjectOptions& options) {
  if (options.head_model.empty()) return "none";
  const auto hash = head_model_files_hash(options.head_model);
  return hash ? *hash : "absent";
}

// The clip's content. A clip that was moved or deleted after its import is known by what the import wrote
// down, so that training goes on without it.
std::string clip_content(const Project& project) {
  std::error_code ignored;
  if (!fs::exists(project.options.video, ignored)) {
    if (const auto capture = read_capture(capture_path(project))) return capture->video_hash;
  }
  const auto hash = hash_video(project.options.video);
  return hash ? *hash : "absent";
}

bool is_further(const Project& project) { return !project.first_clip.empty(); }

bool results_exist(const Project& project, Stage stage) {
  switch (stage) {
    case Stage::import:
      return path_exists(capture_path(project)) && path_exists(project.folder / "frames");
    case Stage::align:
      return path_exists(cameras_path(project));
    case Stage::fit:
      return path_exists(track_path(project));
    case Stage::matte:
      return path_exists(project.folder / "masks");
    case Stage::train:
      return path_exists(avatar_path(project));
  }
  return false;
}

// What a stage writes beside its result if it was asked to: deleted, it is made anew.
bool lesser_results_exist(const Project& project, Stage stage) {
  if (stage == Stage::fit)
    return project.options.displacement.empty() || is_further(project) || path_exists(detail_path(project));
  if (stage == Stage::train)
    return !path_exists(attributes_path(project)) || path_exists(attribute_values_path(project));
  return true;
}

struct StageContext {
  Project& project;
  StageRecord& record;
  const StageRecord& before;  // of the run before this one
  const Progress& progress;
  const RunObserver& observer;
  std::stop_token stop;
};

// The evaluation regions are frozen once per clip: those of another clip say nothing about this one.
Result<void> drop_foreign_regions(const Project& project, const Capture& capture) {
  const auto before = read_capture(capture_path(project));
  if (before && before->video_hash == capture.video_hash) return {};
  std::error_code failure;
  fs::remove_all(regions_path(project), failure);
  if (failure) return file_error(regions_path(project), "remove", failure.value());
  return {};
}

// Strokes on another clip's masks and faces say nothing about this one's; somebody's work is not removed,
// though.
Result<void> part_from_foreign_clip(Project& project, const Capture& capture,
                                    std::vector<std::string>& warnings) {
  const auto before = read_capture(capture_path(project));
  if (!before || before->video_hash == capture.video_hash) return {};
  // Nor does what was answered of its person.
  project.consent = Consent::not_asked;
  if (!project.further_clips.empty()) {
    project.further_clips.clear();
    warnings.push_back("The further clips were of the person before; add those of this one anew.");
  }
  if (path_exists(attributes_path(project))) {
    const auto aside = set_aside_attributes(project);
    if (!aside) return aside.error();
    warnings.push_back(fmt::format(
        "The attributes that were painted were of another clip; they are kept in {}.", aside->string()));
  }
  if (corrected_frames(project).empty()) return {};
  const auto kept = set_aside_corrections(project);
  if (!kept) return kept.error();
  warnings.push_back(fmt::format(
      "The strokes painted on the masks were of another clip; they are kept in {}.", kept->string()));
  return {};
}

// The frames that a moving camera filmed; nullopt: it rests, or was said to.
Result<std::optional<FrameSpan>> moving_frames(const StageContext& context, const Progress& progress) {
  const ProjectOptions& o = context.project.options;
  if (o.resting_camera) return std::optional<FrameSpan>{};
  std::error_code ignored;
  if (fs::is_directory(o.video, ignored))  // photographs: each from a place of its own
    return std::optional<FrameSpan>(FrameSpan{0, std::numeric_limits<int>::max()});
  const auto person = coarse_person_mask(o.landmark_model);
  if (!person) return person.error();
  const AlignOptions align;
  const auto motion = measure_background_motion(o.video, *person, rest_limit(align), progress, context.stop);
  if (!motion) return motion.error();
  if (motion->motion <= align.static_motion_px_per_1000) return std::optional<FrameSpan>{};
  const auto stretch = moving_stretch(*motion);
  if (!stretch) return std::optional<FrameSpan>{};
  return std::optional<FrameSpan>(FrameSpan{stretch->first, stretch->last});
}

Result<void> run_import(const StageContext& context) {
  ImportOptions options;
  options.size = context.project.options.size;
  options.landmark_model = context.project.options.landmark_model;
  options.split = context.project.options.split;
  if (is_further(context.project)) options.held_out_share = 0;  // the first clip alone is measured
  Progress rest = context.progress;
  if (options.split == Split::views) {
    const auto moving = moving_frames(context, context.progress.stage(0, 0.4, "background"));
    if (!moving) return moving.error();
    options.moving = *moving;
    rest = context.progress.stage(0.4, 1, "import");
  }
  const auto capture =
      import_clip(context.project.options.video, context.project.folder, options, rest, context.stop);
  if (!capture) return capture.error();
  int used = 0, held_out = 0;
  for (const CaptureFrame& frame : capture->frames) used += frame.used, held_out += frame.held_out;
  context.record.message =
      fmt::format("{} frames: {} train, {} held out, {} refused.", capture->frames.size(), used, held_out,
                  int(capture->frames.size()) - used - held_out);
  context.record.warnings = capture->warnings;
  if (const auto dropped = drop_foreign_regions(context.project, *capture); !dropped) return dropped.error();
  if (const auto aside = part_from_foreign_clip(context.project, *capture, context.record.warnings); !aside)
    return aside.error();
  return write_capture(capture_path(context.project), *capture);
}

Result<void> run_align(const StageContext& context) {
  const fs::path& video = context.project.options.video;
  AlignOptions options;
  options.seed = int(context.project.options.seed);
  options.resting = context.project.options.resting_camera;
  options.lens_mm = context.project.options.lens_mm;
  std::error_code ignored;
  const bool photographs = fs::is_directory(video, ignored) && !options.resting;
  const auto person = coarse_person_mask(context.project.options.landmark_model,
                                         photographs ? Pictures::single : Pictures::in_sequence);
  if (!person) return person.error();
  const auto align = photographs ? align_photos : align_clip;
  const auto aligned =
      align(video, *person, context.project.folder / "colmap", options, context.progress, context.stop);
  if (!aligned) return aligned.error();
  context.record.message = aligned->evidence;
  context.record.warnings = aligned->warnings;
  if (options.lens_mm > 0 && !aligned->cameras.is_static)
    context.record.warnings.push_back(
        "The camera moves, so its lens was found together with its path; the one given by --lens is not "
        "used.");
  return write_cameras(cameras_path(context.project), aligned->cameras);
}

// As if no span had been fitted again, and without the maps, which are read beside the finished track.
std::string first_fit_inputs(const Project& project) {
  Project first = project;
  first.options.refits.clear();
  first.options.displacement.clear();
  return input_hash(first, Stage::fit);
}

// Whether track.json is the whole clip's fit from these inputs, without spans fitted again.
bool first_track_is_there(const StageContext& context, const HeadModel& model, const std::string& inputs) {
  if (!path_exists(track_path(context.project))) return false;
  if (context.before.track_inputs == inputs) return true;
  if (context.before.state == StageState::done && context.before.input_hash == inputs) return true;
  if (path_exists(refits_path(context.project))) return false;
  const auto detail = read_project_detail(context.project, model);
  return detail && *detail && (*detail)->track_inputs == inputs;
}

// The project's detail.npz as its options ask for it.
Result<void> keep_detail(const StageContext& context, const Capture& capture, const Track& track,
                         const HeadModel& model, const std::string& track_inputs) {
  const fs::path& maps = context.project.options.displacement;
  if (maps.empty() || is_further(context.project)) return forget_project_detail(context.project);
  DetailReport report;
  auto detail = learn_project_detail(maps, capture, track, model, report);
  if (!detail) return detail.error();
  detail->track_inputs = track_inputs;
  context.record.message += " " + report.message;
  context.record.warnings.insert(context.record.warnings.end(), report.warnings.begin(),
                                 report.warnings.end());
  return write_project_detail(context.project, *detail);
}

Result<void> run_fit(const StageContext& context) {
  const auto capture = read_capture(capture_path(context.project));
  if (!capture) return capture.error();
  const auto cameras = read_cameras(cameras_path(context.project));
  if (!cameras) return cameras.error();
  const auto model = project_head_model(context.project.options);
  if (!model) return model.error();
  RefitWork work{*capture, *cameras, *model, {}, first_fit_inputs(context.project)};
  work.options.predictor = context.project.options.landmark_model;
  work.fitted = first_track_is_there(context, *model, work.fit_inputs);
  context.record.track_inputs = work.fitted ? work.fit_inputs : "";
  if (is_further(context.project)) {
    auto track = read_track(track_path({.folder = context.project.first_clip}));
    if (!track) return track.error();
    work.options.person = std::move(track->person);
  } else if (const fs::path& identity = context.project.options.identity; !identity.empty()) {
    auto person = read_person(identity, *model);
    if (!person) return person.error();
    work.options.person = std::move(*person);
  }
  auto first = first_track(context.project, work);
  if (!first) return first.error();
  Progress rest = context.progress;
  if (!*first) {
    work.fitted = false;
    const TrackRegion region{capture->crop.x, capture->crop.y, capture->crop.side, capture->crop.side};
    const bool again = !context.project.options.refits.empty();
    auto whole = track_clip(context.project.options.video, region, *cameras, held_out_frames(*capture),
                            *model, work.options, rest.stage(0, again ? 0.9 : 1, "fit"), context.stop);
    if (!whole) return whole.error();
    whole->head_model_file = context.project.options.head_model.string();
    if (const auto forgotten = forget_refits(context.project); !forgotten) return forgotten.error();
    *first = std::move(*whole);
    rest = rest.stage(0.9, 1, "spans");
  }
  std::vector<RefitOutcome> outcomes;
  auto track =
      apply_refits(context.project, work, **first, outcomes, context.record.warnings, rest, context.stop);
  if (!track) return track.error();
  context.record.track_inputs = context.project.options.refits.empty() ? work.fit_inputs : "";
  if (!track->metre_known) {
    context.record.warnings.push_back(
        "The camera moved too little to tell its distances in metres; for a better avatar walk a wider arc "
        "round the head.");
  }
  std::array<int, 3> count{};
  double error_px = 0;
  for (const TrackedFrame& frame : track->frames) {
    ++count[std::size_t(frame.status)];
    if (frame.status != FrameStatus::lost) error_px += frame.inner_error_px;
  }
  const int followed = count[0] + count[1];
  context.record.message =
      fmt::format("{} head; {} frames good, {} weak, {} lost; landmarks within {:.2f} px.", model->name,
                  count[0], count[1], count[2], followed > 0 ? error_px / followed : 0.0);
  if (work.options.person && !is_further(context.project))
    context.record.message += fmt::format(" The person's shape is that of {}.",
                                          context.project.options.identity.filename().string());
  if (!outcomes.empty()) context.record.message += " " + refits_words(outcomes);
  return keep_detail(context, *capture, *track, *model, work.fit_inputs);
}

Result<void> run_matte(const StageContext& context) {
  auto strokes = read_corrections(context.project);
  if (!strokes) return strokes.error();
  const auto read = read_tracked_capture(context.project);
  if (!read) return read.error();
  const auto& [capture, cameras, track] = *read;
  const auto model = project_head_model(context.project.options);
  if (!model) return model.error();
  if (const auto fits = check_track_fits(track, *model); !fits) return fits.error();
  MatteOptions options;
  options.size = capture.size;
  options.network = context.project.options.matting_network;
  options.strokes = std::move(*strokes);
  std::error_code failure;
  fs::remove(room_path(context.project), failure);  // of other frames
  if (!is_further(context.project)) options.learn_room = room_learner(context.project, *read);
  const auto matte = matte_clip(context.project.folder, capture, cameras, track, *model, options,
                                context.progress, context.stop);
  if (!matte) return matte.error();
  context.record.message =
      matte->has_plate ? fmt::format("Background plate, {:.0f} % of it seen.", 100 * matte->plate_coverage)
                       : "No background plate: the camera moves throughout.";
  if (path_exists(room_path(context.project)))
    context.record.message += " The room behind the moving camera was learnt.";
  if (const std::size_t painted = options.strokes.size(); painted > 0)
    context.record.message +=
        fmt::format(" Corrected by hand in {} frame{}.", painted, painted == 1 ? "" : "s");
  context.record.warnings = matte->warnings;
  return {};
}

// The training's curve on disk: now and then while it grows, and at the end. Never worth a failed training.
class CurveKeeper {
 public:
  explicit CurveKeeper(fs::path path) : path_(std::move(path)) {
    if (auto earlier = read_training_curve(path_)) curve_ = std::move(*earlier);
  }
  void add(const TrainStatus& status) {
    // A training that goes on reports later steps first; one that begins, or had hardly begun, owns its
    // curve.
    constexpr std::uint64_t kBeginning = 100;
    if (!reported_ && status.step < kBeginning) curve_ = {};
    reported_ = true;
    add_point(curve_, status);
    constexpr double kEvery_s = 15;
    if (status.seconds - written_at_s_ >= 0 && status.seconds - written_at_s_ < kEvery_s) return;
    written_at_s_ = status.seconds;
    write();
  }
  void write() const {
    if (!curve_.training.empty()) (void)write_training_curve(path_, curve_);
  }

 private:
  fs::path path_;
  TrainingCurve curve_;
  bool reported_ = false;
  double written_at_s_ = -1e9;
};

// What is told of painted attributes, and kept for pictures of the clip's own frames by the avatar that
// learns them now: beside what the last one knows, which stays until there is a new one.
Result<void> keep_courses(const StageContext& context, const std::vector<FoundAttribute>& found) {
  if (found.empty()) return {};
  std::vector<AttributeCourse> courses;
  context.record.warnings.clear();
  for (const FoundAttribute& attribute : found) {
    const AttributeCourse& course = courses.emplace_back(attribute.course);
    context.progress.report(0, "attribute " + course_words(course));
    if (4 * course.unlike_any > int(course.frames.size()))
      context.record.warnings.push_back(fmt::format(
          "Of attribute '{}', {} of {} frames look like none that was painted; paint it on some of those.",
          course.name, course.unlike_any, course.frames.size()));
  }
  return write_attribute_values(next_attribute_values_path(context.project), courses);
}

Result<void> run_train(const StageContext& context) {
  const ProjectOptions& o = context.project.options;
  const auto model = project_head_model(o);
  if (!model) return model.error();
  auto set = load_training_views(context.project, *model);
  if (!set) return set.error();
  TrainOptions options = training_options(o);
  options.backend = context.observer.backend, options.fall_back = context.observer.fall_back;
  options.precision = context.observer.precision;
  const MemoryForecast forecast = forecast_memory(*set, options);
  context.progress.report(0, fmt::format("training takes about {:.1f} GiB of memory",
                                         double(forecast.total()) / double(1ull << 30)));
  if (const auto available = available_memory())
    if (const auto enough = check_memory(forecast, *available); !enough) return enough.error();
  if (const auto loaded = load_training_pictures(context.project, *set); !loaded) return loaded.error();
  const auto attributes =
      add_attributes(context.project, *set, context.progress.stage(0, 0, "attributes"), context.stop);
  if (!attributes) return attributes.error();
  if (const auto kept = keep_courses(context, *attributes); !kept) return kept.error();
  const ChosenParts chosen = take_parts(context.project, *set, options);
  context.observer.parts(chosen.parts);
  CurveKeeper curve(training_curve_path(context.project));
  const auto observe = [&](const TrainStatus& status) {
    curve.add(status);
    context.observer.training(status);
  };
  auto avatar = train_avatar(*set, options, checkpoint_path(context.project), context.progress, observe,
                             context.stop, context.observer.tap);
  curve.write();
  if (!avatar) return avatar.error();
  if (path_exists(room_path(context.project))) {
    auto room = read_room(room_path(context.project));
    if (!room) return room.error();
    avatar->room = std::move(*room);
  }
  avatar->head_model_file = o.head_model.string();
  avatar->parts = chosen.parts;
  context.record.message = fmt::format("{} steps in {:.0f} s.", avatar->steps, avatar->train_seconds);
  for (const FoundAttribute& attribute : *attributes)
    context.record.message += " Attribute " + course_words(attribute.course);
  if (const auto written = write_avatar(avatar_path(context.project), *avatar); !written) return written;
  std::error_code failure;
  if (attributes->empty())
    fs::remove(next_attribute_values_path(context.project), failure),
        fs::remove(attribute_values_path(context.project), failure);
  else
    fs::rename(next_attribute_values_path(context.project), attribute_values_path(context.project), failure);
  return failure ? Result<void>(file_error(attribute_values_path(context.project), "write", failure.value()))
                 : Result<void>();
}

Result<void> run_stage(Stage stage, const StageContext& context) {
  // The stages that read the clip itself. Of one that was never imported, its reader says more.
  const bool reads_clip = stage == Stage::import || stage == Stage::align || stage == Stage::fit;
  if (reads_clip && path_exists(capture_path(context.project)))
    if (auto missing = missing_clip(context.project)) return *missing;
  switch (stage) {
    case Stage::import:
      return run_import(context);
    case Stage::align:
      return run_align(context);
    case Stage::fit:
      return run_fit(context);
    case Stage::matte:
      return run_matte(context);
    case Stage::train:
      return run_train(context);
  }
  return {};
}

// Seconds a stage is expected to take beside the others; only shares the progress bar out.
double expected_seconds(const ProjectOptions& options, Stage stage) {
  switch (stage) {
    case Stage::import:
      return 15;
    case Stage::align:
      return 30;
    case Stage::fit:
      return 120;
    case Stage::matte:
      return 40;
    case Stage::train:
      return options.steps > 0 ? 200 : options.budget_s;
  }
  return 1;
}

// Half-written files of a process that was killed; call with the project's lock held.
void remove_abandoned_parts(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> abandoned;
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored)) {
    const std::string name = it->path().filename().string();
    if (name.starts_with(".") && name.find(".part") != std::string::npos) abandoned.push_back(it->path());
  }
  for (const fs::path& path : abandoned) fs::remove_all(path, ignored);
}

}  // namespace

Result<HeadModel> project_head_model(const ProjectOptions& options) {
  if (options.head_model.empty()) return make_builtin_head();
  return load_head_model(options.head_model);
}

TrainOptions training_options(const ProjectOptions& options) {
  TrainOptions training;
  training.budget_s = options.budget_s;
  training.steps = options.steps;
  training.seed = options.seed;
  training.checkpoint_every_s = options.checkpoint_every_s;
  training.mode = options.mode.value_or(kDefaultMode);
  training.refine_track = options.refine_track;
  training.landmark_weight = options.landmark_loss;
  training.use_latent = options.use_latent;
  training.use_occupancy = options.use_occupancy;
  return training;
}

ChosenParts take_parts(const Project& project, TrainingSet& set, TrainOptions& options) {
  const ProjectOptions& o = project.options;
  const AskedParts asked{.mode = o.mode,
                         .no_latent = !o.use_latent,
                         .no_occupancy = !o.use_occupancy,
                         .refine_track = o.refine_track,
                         .landmark_weight = o.landmark_loss};
  CaptureMeasures measures = measure_capture(set, shape_head(set.model, set.person));
  measures.has_room = path_exists(room_path(project));
  ChosenParts chosen = choose_parts(measures, asked);
  apply_parts(chosen, set, options);
  return chosen;
}

namespace {

// What the person's shape in a project's track was made from. Spans that were fitted again leave it as it is.
std::string person_inputs(const fs::path& folder) {
  const auto project = open_project(folder);
  return project ? first_fit_inputs(*project) : "absent";
}

// What a training sees of a further clip.
std::string further_content(const Project& project, int number) {
  const auto further = open_further_clip(project, number);
  if (!further) return fmt::format(" clip {} absent", number);
  return fmt::format(" clip {} {} {}", number, further->record(Stage::matte).input_hash,
                     content_of(track_path(*further)));
}

}  // namespace

std::string input_hash(const Project& project, Stage stage) {
  const ProjectOptions& o = project.options;
  std::string inputs = fmt::format("{} {}\n", stage_name(stage), kStageVersion[std::size_t(stage)]);
  switch (stage) {
    case Stage::import:
      inputs += fmt::format("{} {}", clip_content(project), o.size);
      if (is_further(project)) inputs += " further";
      if (o.split != Split::tail) inputs.append(" ").append(split_name(o.split));
      if (o.split == Split::views && o.resting_camera) inputs += " rests";  // what such a split refuses
      break;
    case Stage::align:
      inputs += fmt::format("{} {}{}", clip_content(project), o.seed, o.resting_camera ? " rests" : "");
      if (o.lens_mm > 0) inputs += fmt::format(" {} mm", o.lens_mm);
      break;
    case Stage::fit:
      inputs +=
          fmt::format("{} {} {} {}", content_of(capture_path(project)), content_of(cameras_path(project)),
                      head_model_content(o), content_of(o.landmark_model));
      if (is_further(project))
        inputs += " of " + person_inputs(project.first_clip);
      else if (!o.identity.empty())
        inputs += " person " + content_of(o.identity);
      // Only where they are given: other projects stay as they are.
      if (!o.displacement.empty() && !is_further(project)) {
        const auto maps = detail_maps_hash(o.displacement);
        inputs += fmt::format(" displacement {} {}", kDetailVersion, maps ? *maps : "absent");
      }
      // Only where there are any: other projects stay as they are.
      if (!o.refits.empty()) {
        inputs += fmt::format(" again {}:", kRefitVersion);
        for (const RefitSpan& span : merged_spans(o.refits))
          inputs += fmt::format(" {}-{}", span.first, span.last);
      }
      break;
    case Stage::matte:
      inputs +=
          fmt::format("{} {} {} {}", content_of(capture_path(project)), content_of(cameras_path(project)),
                      content_of(track_path(project)), head_model_content(o));
      if (!o.matting_network.empty()) inputs.append(" ").append(matting_network_hash(o.matting_network));
      // Only where somebody painted: projects without strokes stay as they are.
      if (const auto strokes = corrections_hash(project); !strokes.empty())
        inputs.append(" strokes ").append(strokes);
      break;
    case Stage::train: {
      const ModeParts mode = mode_parts(o.mode.value_or(kDefaultMode));
      inputs += fmt::format("{} {} {} {} {} {} {} {} {} {} {} {}", project.record(Stage::matte).input_hash,
                            content_of(track_path(project)), content_of(plate_path(project)),
                            content_of(plate_known_path(project)), o.budget_s, o.steps, o.seed, mode.ambient,
                            o.use_latent, o.use_occupancy, mode.warp, o.refine_track);
      // Only where they are chosen: projects from before these choices stay as they are.
      if (!mode.expression) inputs += " static";
      // Where nothing was asked for, the choice follows from the inputs above.
      if (o.mode == kDefaultMode) inputs += " asked";
      if (o.landmark_loss != 0) inputs += fmt::format(" landmarks {}", o.landmark_loss);
      if (const auto attributes = attributes_hash(project); !attributes.empty())
        inputs.append(" attributes ").append(attributes);
      if (path_exists(detail_path(project))) inputs += " detail " + content_of(detail_path(project));
      if (!o.left_out.empty()) inputs += fmt::format(" left out {}", fmt::join(o.left_out, ","));
      for (const int number : project.further_clips) inputs += further_content(project, number);
      break;
    }
  }
  return hash_text(inputs);
}

std::pair<double, double> stage_span(const ProjectOptions& options, Stage last, Stage stage) {
  double total = 0, before = 0;
  for (const Stage other : kStages) {
    if (other <= last) total += expected_seconds(options, other);
    if (other < stage) before += expected_seconds(options, other);
  }
  return {before / total, (before + expected_seconds(options, stage)) / total};
}

bool is_current_alone(const Project& project, Stage stage) {
  const StageRecord& record = project.record(stage);
  return record.state == StageState::done && results_exist(project, stage) &&
         lesser_results_exist(project, stage) && record.input_hash == input_hash(project, stage);
}

bool is_current(const Project& project, Stage stage) {
  if (!is_current_alone(project, stage)) return false;
  if (stage == Stage::train) return true;  // its inputs name the further clips
  return std::ranges::all_of(project.further_clips, [&](int number) {
    const auto further = open_further_clip(project, number);
    return further && is_current_alone(*further, stage);
  });
}

Freshness read_freshness(const Project& project) {
  Freshness fresh;
  std::array<bool, kStages.size()> there{};
  for (const Stage stage : kStages) {
    const auto i = std::size_t(stage);
    there[i] = project.record(stage).state == StageState::done && results_exist(project, stage);
    fresh.current[i] = there[i] && is_current(project, stage);
  }
  for (const Stage stage : kStages)
    for (const Stage earlier : kStages) {
      if (earlier > stage) break;
      if (stage == Stage::align && earlier == Stage::import) continue;  // reads the clip, not the import
      const auto e = std::size_t(earlier);
      fresh.stale[std::size_t(stage)] |= there[std::size_t(stage)] && there[e] && !fresh.current[e];
    }
  return fresh;
}

namespace {

// One stage of one clip that is not current; its record on disk follows. The record names what the result was
// made from.
Result<void> run_one(Project& project, Stage stage, const Progress& progress, const RunObserver& observer,
                     std::stop_token stop, const std::function<void(const StageRecord&)>& changed) {
  StageRecord& record = project.record(stage);
  const std::string inputs = input_hash(project, stage);
  const StageRecord before = record;
  if (record.input_hash != inputs) record = StageRecord{.input_hash = inputs};
  record.state = StageState::running;
  if (const auto saved = save_project(project); !saved) return saved.error();
  changed(record);

  const auto start = std::chrono::steady_clock::now();
  const auto outcome = run_stage(stage, {project, record, before, progress, observer, stop});
  record.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (outcome) {
    record.state = StageState::done;
  } else {
    record.state = outcome.error().code == ErrorCode::cancelled ? StageState::stopped : StageState::failed;
    record.message = outcome.error().what;
  }
  const auto saved = save_project(project);  // before anybody who is told may look
  if (!outcome) return outcome.error();
  return saved;
}

// The stage of every further clip that needs it.
Result<void> run_further(const Project& project, Stage stage, const Progress& progress,
                         const RunObserver& observer, std::stop_token stop) {
  const std::size_t count = project.further_clips.size();
  for (std::size_t i = 0; i < count; ++i) {
    const int number = project.further_clips[i];
    auto further = open_further_clip(project, number);
    if (!further) return further.error();
    if (is_current_alone(*further, stage)) continue;
    const Progress part = progress.stage(double(i) / double(count), double(i + 1) / double(count),
                                         fmt::format("clip {}", number));
    const auto changed = [&](const StageRecord&) { observer.further_changed(stage, number, *further); };
    const auto done = run_one(*further, stage, part, observer, stop, changed);
    observer.further_changed(stage, number, *further);
    if (done) continue;
    Error error = done.error();
    if (error.code != ErrorCode::cancelled) {
      error.what = fmt::format("{}: {}", further_clip_name(*further, number), error.what);
      error.fix +=
          fmt::format(" Or take it out: likeness clips {} --remove {}", project.folder.string(), number);
    }
    return error;
  }
  return {};
}

}  // namespace

Result<void> run_stages(Project& project, Stage last, const Progress& progress, const RunObserver& observer,
                        std::stop_token stop) {
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  remove_abandoned_parts(project.folder);
  for (const Stage stage : kStages) {
    if (stage > last) break;
    const auto [from, to] = stage_span(project.options, last, stage);
    if (is_current(project, stage)) {
      progress.report(to);
      continue;
    }
    const std::size_t others = stage == Stage::train ? 0 : project.further_clips.size();
    const double own = from + (to - from) / double(1 + others);
    const std::string name(stage_name(stage));
    if (!is_current_alone(project, stage)) {
      const auto changed = [&](const StageRecord& record) { observer.stage_changed(stage, record); };
      const auto done = run_one(project, stage, progress.stage(from, own, name), observer, stop, changed);
      observer.stage_changed(stage, project.record(stage));
      if (!done) return done.error();
    }
    if (others > 0)
      if (const auto done = run_further(project, stage, progress.stage(own, to, name), observer, stop); !done)
        return done.error();
    progress.report(to);
  }
  return {};
}

}  // namespace likeness
