// See project_contents.h.
#include "ui/studio/project_contents.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/hash.h"
#include "core/base/parallel.h"
#include "core/direct/camera_keys.h"
#include "core/matte/matte_report.h"
#include "core/matte/person_network.h"
#include "core/project/care.h"
#include "core/project/corrections.h"
#include "core/project/further_clips.h"
#include "core/project/further_views.h"
#include "core/project/project_attributes.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/refits.h"
#include "core/project/solved_points.h"
#include "core/project/staleness.h"

namespace likeness::ui {

namespace {

template <class T>
std::shared_ptr<const T> shared_or_none(Result<T> result) {
  return result ? std::make_shared<const T>(std::move(*result)) : nullptr;
}

std::shared_ptr<const ProjectAvatar> read_project_avatar(const ProjectContents& contents) {
  const std::filesystem::path file = avatar_path(contents.project);
  auto avatar = read_avatar(file);
  if (!avatar || !contents.model || !check_avatar_fits(*avatar, *contents.model, file.string()))
    return nullptr;
  SeenViews views;
  if (contents.capture && contents.cameras && contents.track)
    views = joined(seen_views(*contents.capture, *contents.cameras, *contents.track),
                   learnt_further_views(contents.project));
  auto made = ProjectAvatar::make(std::move(*avatar), contents.model, std::move(views));
  if (!made) return nullptr;
  if (auto hash = hash_file(file)) made->hash = std::move(*hash);
  return made;
}

std::shared_ptr<const Card> read_card(const ProjectContents& contents) {
  if (!contents.avatar || !contents.capture || !contents.cameras || !contents.track ||
      !check_track_fits(*contents.track, *contents.avatar->model))
    return nullptr;
  const Capture trained = without_left_out(*contents.capture, contents.project.options.train.left_out);
  const HeadModel& model = *contents.avatar->model;
  return std::make_shared<const Card>(
      make_card(trained, *contents.cameras, *contents.track, learnt_further_views(contents.project),
                contents.avatar->avatar, model,
                seen_mouth(contents.project.folder, trained, *contents.cameras, *contents.track, model)));
}

void read_strokes_of(const Project& project, ProjectContents& contents) {
  for (const int frame : corrected_frames(project)) {
    auto strokes = read_strokes(strokes_path(project, frame));
    if (!strokes) {
      contents.unreadable_strokes[frame] = strokes.error();
    } else if (!strokes->empty()) {
      contents.strokes[frame] = std::move(*strokes);
    }
  }
}

void read_attributes_of(const Project& project, ProjectContents& contents) {
  auto attributes = read_project_attributes(project);
  if (attributes)
    contents.attributes = std::move(*attributes);
  else
    contents.unreadable_attributes = attributes.error();
  const auto courses = [](const std::filesystem::path& path) {
    auto read = read_attribute_values(path);
    return read ? std::move(*read) : std::vector<AttributeCourse>{};
  };
  contents.courses = courses(attribute_values_path(project));
  contents.next_courses = courses(next_attribute_values_path(project));
}

// Of results that are up to date; a stale one was found of other choices.
void read_facts(ProjectContents& contents) {
  const Project& project = contents.project;
  ClipResults results;
  results.stated = project.options.align.camera;
  results.camera_evidence = project.record(Stage::align).message;
  results.person_network = !person_network_hash(project.options.shared.person_network).empty();
  if (contents.is_current(Stage::import)) results.capture = contents.capture.get();
  if (contents.is_current(Stage::align)) results.cameras = contents.cameras.get();
  const auto mattes = read_matte_report(matte_report_path(project));
  if (mattes && *mattes && contents.is_current(Stage::matte)) {
    results.mattes = &**mattes;
    if (contents.cameras) contents.look_back = look_back_warning(**mattes, contents.cameras->kind);
    contents.background_fault = background_fault(**mattes);
  } else if (contents.avatar) {
    contents.background_fault = contents.avatar->avatar.background_fault;
  }
  contents.facts = clip_facts(results);
}

// Counts as long as the clip is the one that was looked at, or cannot be read.
std::shared_ptr<const CheckedClip> read_checked(const ProjectContents& contents,
                                                const ProjectContents* earlier) {
  const std::filesystem::path& clip = contents.project.options.shared.video;
  if (earlier && earlier->checked && earlier->project.options.shared.video == clip) return earlier->checked;
  auto checked = shared_or_none(read_checked_clip(checked_clip_path(contents.project.folder)));
  if (!checked || !contents.clip) return checked;
  const auto hash = hash_video(clip);
  return !hash || *hash == checked->clip_hash ? checked : nullptr;
}

FurtherClip read_further(const Project& project, int number) {
  FurtherClip further{.number = number};
  const auto clip = open_further_clip(project, number);
  if (!clip) {
    further.state = StageState::failed, further.words = clip.error().what;
    return further;
  }
  further.name = clip->options.shared.video.filename().string();
  if (auto info = probe_video(clip->options.shared.video)) further.clip = std::move(*info);
  further.state = StageState::done;
  for (const Stage stage : kStages) {
    if (stage == Stage::train || is_current_alone(*clip, stage)) continue;
    const StageRecord& record = clip->record(stage);
    further.state = record.state == StageState::failed ? StageState::failed : StageState::to_do;
    if (further.state == StageState::failed) further.words = record.message;
    break;
  }
  if (further.state == StageState::to_do && !further.clip)
    if (const auto missing = missing_clip(*clip))
      further.state = StageState::failed, further.words = missing->what + " " + missing->fix;
  if (further.state == StageState::done) further.words = clip->record(Stage::fit).message;
  return further;
}

// What the stages of the further clips add to a plan.
void plan_further(const ProjectContents& contents, int threads, Plan& plan) {
  const Project& project = contents.project;
  for (const FurtherClip& further : contents.further) {
    if (!further.clip) continue;
    add_further_clip(*further.clip, project.options, *contents.model, threads, *plan.forecast);
    const auto clip = open_further_clip(project, further.number);
    if (!clip) continue;
    const BuildForecast own = forecast_build(*further.clip, project.options, *contents.model, threads);
    for (const Stage stage : kStages)
      if (stage != Stage::train && !is_current_alone(*clip, stage))
        plan.seconds += own.seconds[std::size_t(stage)];
  }
}

// Of a training that was interrupted and will go on from its checkpoint: without what it has behind it.
double training_seconds(const ProjectContents& contents, double whole) {
  const Project& project = contents.project;
  const StageRecord& record = project.record(Stage::train);
  std::error_code ignored;
  if ((record.state != StageState::stopped && record.state != StageState::running) || !contents.curve ||
      contents.curve->training.empty() || !std::filesystem::exists(checkpoint_path(project), ignored) ||
      record.input_hash != input_hash(project, Stage::train))
    return whole;
  const TrainStatus& last = contents.curve->training.back();
  const TrainChoices& choices = project.options.train;
  const double done =
      choices.steps > 0 ? double(last.step) / double(choices.steps) : last.seconds / choices.budget_s;
  return whole * (1 - std::clamp(done, 0.0, 1.0));
}

Plan make_plan(const ProjectContents& contents) {
  Plan plan;
  if (!contents.clip || !contents.model) return plan;
  const Project& project = contents.project;
  const int threads = current_thread_limit();
  plan.forecast = forecast_build(*contents.clip, project.options, *contents.model, threads);
  for (const Stage stage : kStages)
    if (stage == Stage::train || contents.further.empty()
            ? !contents.is_current(stage) || contents.is_stale(stage)
            : !is_current_alone(project, stage))
      plan.seconds += stage == Stage::train
                          ? training_seconds(contents, plan.forecast->seconds[std::size_t(stage)])
                          : plan.forecast->seconds[std::size_t(stage)];
  plan_further(contents, threads, plan);
  if (plan.seconds == 0) return plan;
  const Resources free = free_resources(project.folder);
  if (const auto fits = check_forecast(*plan.forecast, free, folder_bytes(project.folder)); !fits)
    plan.too_much = fits.error();
  if (plan.too_much)
    plan.smaller_size = smaller_size(*contents.clip, project.options, *contents.model, threads, free);
  return plan;
}

}  // namespace

std::shared_ptr<ProjectAvatar> ProjectAvatar::make(Avatar avatar, std::shared_ptr<const HeadModel> model,
                                                   SeenViews views) {
  std::shared_ptr<ProjectAvatar> made(new ProjectAvatar);
  made->model = std::move(model);
  made->avatar = std::move(avatar);
  auto rig = make_rig(made->avatar, *made->model);
  if (!rig) return nullptr;
  made->rig = std::move(*rig);
  made->directed = direct_avatar(made->avatar, *made->model);
  made->views = std::move(views);
  made->limits = seen_limits(made->avatar, *made->model, made->views);
  if (made->views.views.empty())  // the project has lost its track: of the views only what holds is known
    std::erase_if(made->limits, [&](const auto& limit) {
      return !limit.first.starts_with(kActionChannel) && !limits_hold(made->avatar, limit.first);
    });
  made->presets = likeness::presets(*made->model, seen_from_rest(made->avatar, *made->model));
  return made;
}

ValueRange orbit_of(const ProjectAvatar& avatar) {
  return orbit_range(avatar.limits, limits_hold(avatar.avatar, "camera yaw"));
}

Result<std::shared_ptr<const ProjectContents>> read_contents(const std::filesystem::path& folder,
                                                             const ProjectContents* earlier) {
  auto project = open_project(folder);
  if (!project) return project.error();
  auto contents = std::make_shared<ProjectContents>();
  contents->project = std::move(*project);
  const Project& p = contents->project;
  const Freshness fresh = read_freshness(p);
  contents->current = fresh.current;
  contents->stale = fresh.stale;
  for (const int number : p.further_clips) contents->further.push_back(read_further(p, number));
  if (auto info = probe_video(p.options.shared.video)) contents->clip = std::move(*info);
  const auto same_stage = [&](Stage stage) {
    return earlier && contents->is_current(stage) && earlier->is_current(stage) &&
           earlier->project.record(stage).input_hash == p.record(stage).input_hash;
  };
  if (earlier && earlier->model &&
      earlier->project.options.shared.head_model == p.options.shared.head_model) {
    contents->model = earlier->model;
  } else {
    contents->model = shared_or_none(project_head_model(p.options));
  }
  contents->capture = shared_or_none(read_capture(capture_path(p)));
  contents->cameras = shared_or_none(read_cameras(cameras_path(p)));
  contents->track = same_stage(Stage::fit) ? earlier->track : shared_or_none(read_track(track_path(p)));
  if (auto refits = read_refits(p); refits && contents->track) contents->refits = std::move(refits->outcomes);
  contents->avatar =
      same_stage(Stage::train) && earlier->avatar ? earlier->avatar : read_project_avatar(*contents);
  if (contents->track && contents->cameras && contents->cameras->kind == CameraKind::walking) {
    contents->points = same_stage(Stage::fit) && earlier->points
                           ? earlier->points
                           : shared_or_none(solved_points(p, *contents->track));
  }
  contents->card = read_card(*contents);
  contents->curve = shared_or_none(read_training_curve(training_curve_path(p)));
  read_strokes_of(p, *contents);
  read_attributes_of(p, *contents);
  read_facts(*contents);
  contents->checked = read_checked(*contents, earlier);
  contents->plan = make_plan(*contents);
  return std::shared_ptr<const ProjectContents>(std::move(contents));
}

std::optional<FrameView> frame_view(const ProjectContents& contents, int frame) {
  if (!contents.capture || !contents.cameras || !contents.track) return std::nullopt;
  const TrackedFrame* tracked = find_tracked(*contents.track, frame);
  const auto camera = picture_camera(*contents.capture, *contents.cameras, *contents.track, frame);
  if (!tracked || tracked->status == FrameStatus::lost || !camera) return std::nullopt;
  return FrameView{.tracked = tracked, .camera = *camera};
}

std::vector<int> shown_frames(const ProjectContents& contents, bool held_out) {
  std::vector<int> frames;
  if (!contents.capture || !contents.cameras || !contents.track) return frames;
  for (const CaptureFrame& frame : contents.capture->frames) {
    if (!frame.held_out && (held_out || !frame.used)) continue;
    const TrackedFrame* tracked = find_tracked(*contents.track, frame.frame);
    if (tracked && tracked->status != FrameStatus::lost && find_camera(*contents.cameras, frame.frame))
      frames.push_back(frame.frame);
  }
  return frames;
}

std::vector<int> matted_frames(const ProjectContents& contents) {
  std::vector<int> frames;
  if (!contents.capture || !contents.cameras || !contents.track) return frames;
  for (const CaptureFrame& frame : contents.capture->frames)
    if ((frame.used || frame.held_out) && find_camera(*contents.cameras, frame.frame))
      frames.push_back(frame.frame);
  return frames;
}

}  // namespace likeness::ui
