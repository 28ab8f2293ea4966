// The sessions put together: see studio.h. What a command does is in commands.cpp.
#include "ui/studio/studio.h"

#include <algorithm>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/memory.h"
#include "core/base/parallel.h"
#include "ui/studio/commands.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

// Seconds until the window looks again.
constexpr double kPlaying_s = 0.03, kDriving_s = 0.25, kSettling_s = 0.25, kWorking_s = 1.0, kIdle_s = 2.0;

// What the capture check says of the clip, where another could be filmed instead: of no demo.
const CaptureVerdict* verdict_that_counts(const Snapshot& s) {
  if (!s.project.contents || s.project.contents->project.consent == Consent::no_real_person) return nullptr;
  return s.project.verdict.get();
}

// Which commands make sense with what is shown.
Situation situation_of(const Snapshot& s) {
  const ProjectContents* contents = s.project.contents.get();
  const PipelineStatus& pipeline = s.project.pipeline;
  const JobStatus& demo = s.project.demo;
  const DirectingView& directing = s.direct.directing;
  Situation now;
  now.project = contents != nullptr;
  now.clip_there = contents && (contents->clip || contents->capture);
  now.clip_missing = contents && !contents->clip;
  now.look_only = s.project.look_only;
  now.damaged = !contents && s.project.damaged;
  now.repairable = now.damaged && !s.project.damaged->newer;
  now.running = is_working(pipeline.job) || is_working(demo);
  now.paused = (is_working(pipeline.job) && pipeline.job.paused) || (is_working(demo) && demo.paused);
  now.training = is_working(pipeline.job) && pipeline.stage == Stage::train && !pipeline.training.empty();
  now.finished = contents && std::ranges::all_of(contents->current, std::identity{}) &&
                 std::ranges::none_of(contents->stale, std::identity{});
  now.interrupted = contents && !now.running && std::ranges::any_of(kStages, [&](Stage stage) {
                      return was_interrupted(*contents, stage);
                    });
  now.avatar = contents && contents->avatar;
  now.exporting = std::ranges::any_of(s.exports.items, [](const ExportItem& item) {
    return item.status.state == JobState::none || is_working(item.status);
  });
  now.checking = is_working(s.project.checking);
  now.can_check = contents && contents->clip;
  now.directing = s.shown == Step::direct;
  now.masking = s.shown == Step::cameras && s.masks.shown && !s.masks.frames->empty() && contents;
  now.choosing = s.shown == Step::check && contents;
  const bool may_choose = now.choosing && !now.running && !now.look_only;
  now.can_undo = now.masking    ? s.masks.can_undo
                 : now.choosing ? may_choose && s.project.can_undo_camera
                                : !directing.undo_name.empty();
  now.can_redo = now.masking    ? s.masks.can_redo
                 : now.choosing ? may_choose && s.project.can_redo_camera
                                : !directing.redo_name.empty();
  now.keys = !directing.performance->channels.empty();
  now.keys_chosen = !directing.selected->empty();
  now.keys_copied = directing.keys_copied;
  now.pose_copied = directing.pose_copied;
  now.driven = s.direct.live.on;
  now.consent = contents && contents->project.consent != Consent::not_asked;
  const CaptureVerdict* verdict = verdict_that_counts(s);
  // Whoever made it anyway has decided.
  now.film_again = verdict && verdict->verdict == Verdict::refilm && !contents->capture;
  now.faceless = verdict && verdict->faceless && !contents->capture;
  now.studying = is_working(s.study.job);
  now.can_study = contents && s.study.missing.empty() && !s.study.choice.tables.empty();
  now.studied = s.study.finished != nullptr;
  if (!s.recorder) return now;
  // While the camera's page is open, what it covers can be neither seen nor changed.
  return {.exporting = now.exporting,
          .studying = now.studying,
          .recorder = true,
          .camera_ready = s.recorder->state == RecorderState::watching,
          .recording = is_recording(*s.recorder),
          .can_stop_recording = s.recorder->state == RecorderState::recording};
}

}  // namespace

Studio::Studio(StudioOptions options, std::function<void()> wake)
    : options_(std::move(options)),
      wake_(std::move(wake)),
      settings_(read_settings(options_.settings)),
      projects_(options_.projects),
      background_(
          [this](const std::string& what) {
            project_.reading_broke_off();
            notices_.fail({ErrorCode::failed, "Reading was interrupted: " + what + ".",
                           "Close other programs and try again.", ""});
          },
          wake_) {
  recorder_.finish_abandoned();
}

Studio::~Studio() {
  recorder_.end_recovery();
  masks_.save();
  direct_.save_all();
  save_settings(context_);
}

ProjectNeighbours Studio::neighbours() {
  ProjectNeighbours all;
  all.reading_begins = [this] { masks_.reading_begins(); };
  all.was_read = [this](const ProjectReading& reading) {
    if (reading.first) direct_.open();
    masks_.was_read(reading.first);
    if (reading.new_avatar) direct_.request_picture();
  };
  all.closing = [this] {
    masks_.close();
    direct_.close();
    exports_.close();
    study_.forget();
  };
  // Writes the strokes just painted, and those that could not be written when they were painted.
  all.run_begins = [this] { masks_.save(); };
  all.run_began = [this] { study_.close_page(); };
  all.are_working = [this] {
    return exports_.is_working() || study_.is_working() || recorder_.is_recording();
  };
  all.is_comparing = [this] { return study_.is_working(); };
  return all;
}

void Studio::tick() {
  background_.deliver();
  direct_.tick();
  masks_.tick();
  exports_.tick();
  study_.tick();
  if (const auto clip = recorder_.tick()) project_.open_clip(*clip, Consent::not_asked);
  project_.tick();
  const Directing& now = direct_.directing();
  if (shown_.step == Step::export_out) exports_.show_first({now.performance(), now.playhead_s(), {}});
}

Snapshot Studio::snapshot() const {
  Snapshot s;
  s.project = project_.view();
  s.direct = direct_.view();
  s.masks = masks_.view();
  s.study = study_.view();
  s.recorder = recorder_.view();
  s.exports = exports_.view();
  s.steps = view_steps(s.project.contents.get(), s.project.loading, s.project.pipeline, s.exports.status,
                       s.exports.written);
  if (s.project.contents) add_verdict(s.project.checking, verdict_that_counts(s), s.steps);
  s.shown = shown_.step;
  s.situation = situation_of(s);
  s.settings = settings_;
  s.system.threads = current_thread_limit();
  s.system.memory = memory_in_use();
  s.system.available = available_memory().value_or(0);
  if (s.direct.on_device) s.system.backend = "GPU";
  s.projects = projects_;
  s.projects_refuse = projects_refuse();
  s.error = notices_.error;
  s.message = notices_.message;
  return s;
}

WindowRequest Studio::apply(const Requests& requests) {
  if (requests.dismiss_error) {
    notices_.error.reset();
    project_.dismiss_damage();
  }
  if (requests.dismiss_message) notices_.message.clear();
  if (requests.projects) choose_projects(*requests.projects);
  if (requests.open) open(*requests.open);
  recorder_.apply(requests.recorder);
  if (requests.forget_recent) std::erase(settings_.recent, *requests.forget_recent);
  if (requests.show) show(*requests.show);
  project_.apply(requests.project);
  masks_.apply(requests.masks);
  direct_.apply(requests.direct);
  const bool can_export = requests.exports.retry && is_enabled(Command::export_still, snapshot().situation);
  exports_.apply(requests.exports, can_export);
  study_.apply(requests.study);
  WindowRequest wanted = WindowRequest::none;
  for (const Command command : requests.commands) {
    if (!is_enabled(command, snapshot().situation)) continue;
    const WindowRequest asked = command_info(command).carry_out(sessions_);
    if (asked != WindowRequest::none) wanted = asked;
  }
  return wanted;
}

void Studio::show(Step step) {
  shown_ = {step, open_.pipeline.stage.has_value() && step == Step::train};
  study_.close_page();
}

void Studio::open(const fs::path& path) {
  if (!is_enabled(Command::open_clip, snapshot().situation)) {
    if (recorder_.is_recording()) {
      notices_.fail({ErrorCode::failed, "A clip is being recorded.",
                     "Stop recording first; what is recorded is kept.", ""});
    } else if (study_.is_working()) {
      notices_.fail({ErrorCode::failed, "Methods are being compared.",
                     "Stop the comparison first; its finished trainings are kept.", ""});
    } else if (project_.is_filming_demo()) {
      notices_.fail(
          {ErrorCode::failed, "The demo is being filmed.", "Stop it first, or wait until it ends.", ""});
    } else {
      notices_.fail({ErrorCode::failed, "An avatar is being made or exported.",
                     "Stop it first; what has been made of the avatar is kept.", ""});
    }
    return;
  }
  recorder_.leave();
  project_.open(path);
}

void Studio::choose_projects(const fs::path& chosen) {
  std::error_code ignored;
  const fs::path folder = fs::absolute(chosen, ignored).lexically_normal();
  for (fs::path above = folder; above.has_relative_path(); above = above.parent_path())
    if (fs::exists(above / "project.json", ignored))
      return notices_.fail({ErrorCode::bad_input, fmt::format("{} is a project.", above.string()),
                            "Choose the folder it lies in, or another.", above.string()});
  if (const auto usable = make_writable_folder(folder); !usable) return notices_.fail(usable.error());
  projects_ = settings_.projects = folder;
  notices_.error.reset();
  const bool kept = write_settings(options_.settings, settings_).ok();
  notices_.message = fmt::format("New projects go to {}{}.", folder.string(),
                                 kept ? "" : ", until this window is closed: the choice cannot be kept");
  if (is_enabled(Command::open_clip, snapshot().situation)) project_.open_waiting_clip();
}

// Whether what went wrong is that nothing can be put where new projects go.
bool Studio::projects_refuse() const {
  if (!notices_.error) return false;
  const ErrorCode code = notices_.error->code;
  const auto within = [&](const fs::path& folder) {
    const fs::path inside = fs::path(notices_.error->where).lexically_relative(folder);
    return !folder.empty() && !inside.empty() && *inside.begin() != "..";
  };
  return (code == ErrorCode::io || code == ErrorCode::no_space) && within(projects_) && !within(open_.folder);
}

void Studio::remember_window(int width, int height, bool maximised) {
  settings_.maximised = maximised;
  if (!maximised) settings_.width = width, settings_.height = height;
}

bool Studio::is_working() const {
  return project_.is_working() || exports_.is_working() || study_.is_working() || recorder_.is_recording();
}

bool Studio::computes() const { return project_.computes() || exports_.is_working() || study_.is_working(); }

bool Studio::goes_on() const {
  return project_.goes_on() || study_.goes_on() || recorder_.goes_on() || exports_.goes_on();
}

double Studio::patience_s() const {
  return direct_.is_playing()                       ? kPlaying_s
         : direct_.is_driven() || recorder_.is_on() ? kDriving_s
         : masks_.is_settling()                     ? kSettling_s
         : is_working()                             ? kWorking_s
                                                    : kIdle_s;
}

void Studio::stop_work() {
  project_.stop_all();
  exports_.stop_all();
  study_.stop();
  recorder_.stop();
}

}  // namespace likeness::ui
