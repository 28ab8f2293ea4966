// Carrying out what the user asks for: see studio.h.
#include "ui/studio.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <numbers>
#include <utility>

#include "core/base/files.h"
#include "core/base/memory.h"
#include "core/base/parallel.h"
#include "core/image/files.h"
#include "core/project/care.h"
#include "core/project/project_views.h"
#include "core/track/overlay.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

constexpr double kLeastBudget_s = 120;
constexpr double kOverrunOfTraining = 1.16;  // a budget spent by more than this ends a training at once

bool same_place(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return a == b || fs::weakly_canonical(a, ignored) == fs::weakly_canonical(b, ignored);
}

// A training that was finished early left its few seconds as the budget: too little for one that starts anew.
void repair_budget(ProjectOptions& options) {
  if (options.steps == 0 && options.budget_s < kLeastBudget_s) options.budget_s = ProjectOptions{}.budget_s;
}

// The folder of a clip's project: NAME.likeness, or NAME-2.likeness where that one is another clip's.
fs::path folder_for(const fs::path& projects, const fs::path& clip) {
  const std::string name = clip.stem().string();
  for (int number = 1;; ++number) {
    const fs::path folder =
        projects / (number == 1 ? name + ".likeness" : fmt::format("{}-{}.likeness", name, number));
    std::error_code ignored;
    if (!fs::exists(folder, ignored)) return folder;
    const auto project = open_project(folder);
    if (project && same_place(project->options.video, clip)) return folder;
  }
}

// A name in exports/ that no file has and no waiting export takes.
fs::path export_path(const fs::path& folder, const ExportChoice& choice, const ExportQueue& queue) {
  for (int number = 1;; ++number) {
    const fs::path path = folder / "exports" / export_file_name(choice, number);
    std::error_code ignored;
    if (!fs::exists(path, ignored) && !queue.holds(path)) return path;
  }
}

}  // namespace

// The track in the terms of the project's cropped pictures, so that it can be drawn over them.
struct Studio::FaceOverlay {
  std::shared_ptr<const ProjectContents> contents;
  Track track;
  CameraSet cameras;
  std::unique_ptr<TrackOverlay> overlay;

  static std::shared_ptr<const FaceOverlay> make(std::shared_ptr<const ProjectContents> contents) {
    if (!contents || !contents->capture || !contents->cameras || !contents->track || !contents->model ||
        !check_track_fits(*contents->track, *contents->model))
      return nullptr;
    auto made = std::make_shared<FaceOverlay>();
    made->contents = contents;
    const Capture& capture = *contents->capture;
    const SquareCrop& crop = capture.crop;
    const double scale = double(capture.size) / std::max(1, crop.side);
    made->track = *contents->track;
    for (TrackedFrame& frame : made->track.frames)
      for (std::size_t i = 0; i < frame.landmarks.size(); ++i) {
        if (frame.landmarks[i] != Vec2d::Zero())
          frame.landmarks[i] = (frame.landmarks[i] - Vec2d(crop.x, crop.y)) * scale;
        frame.landmark_spread[i] *= scale;
      }
    made->cameras = *contents->cameras;
    for (Camera& camera : made->cameras.cameras)
      camera.intrinsics = crop_intrinsics(camera.intrinsics, crop.x, crop.y, crop.side, capture.size);
    made->overlay = std::make_unique<TrackOverlay>(made->track, *contents->model, made->cameras,
                                                   OverlayOptions{.longer_side = 768});
    return made;
  }

  Image8 draw(const Image8& rgb, int frame) const {
    const TrackedFrame* tracked = find_tracked(track, frame);
    if (!tracked) return rgb;
    const Image8 drawn = overlay->draw(rgb, *tracked);
    return crop(drawn, 0, 0, drawn.width, drawn.width * rgb.height / rgb.width);  // without its line of text
  }
};

Studio::Studio(StudioOptions options, std::function<void()> wake)
    : options_(std::move(options)),
      wake_(std::move(wake)),
      settings_(read_settings(options_.settings)),
      renderer_(wake_),
      exports_(wake_),
      background_(
          [this](const std::string& what) {
            loading_ = false;
            fail({ErrorCode::failed, "Reading broke off: " + what + ".",
                  "Close other programs and try again.", ""});
          },
          wake_) {}

Studio::~Studio() {
  lay_takes();
  save_performance(true);
  save_settings();
}

void Studio::tick() {
  background_.deliver();
  if (directing_.advance(Directing::Clock::now())) request_picture();
  save_performance(false);
  if (drive_.has_ended()) {
    take_drive();
    if (const auto error = drive_.view().status.error) fail(*error);
    retire(drive_.stop());
    request_picture();
  }
  if (demo_ && !ui::is_working(demo_->status())) {
    const JobStatus status = demo_->status();
    demo_.reset();
    if (status.error && status.error->code != ErrorCode::cancelled) fail(*status.error);
    if (!status.error) {
      ProjectOptions project = options_.project;
      open_clip(status.outcome, Consent::no_real_person, project);
    }
  }
  exports_.tick();
  if (check_ && checked_ && check_->status().state == JobState::done)
    verdict_ = std::exchange(checked_, nullptr);
  if (!pipeline_job_) return;
  pipeline_ = pipeline_job_->status();
  for (const Stage stage : kStages) {
    const StageState now = pipeline_.records[std::size_t(stage)].state;
    StageState& before = seen_states_[std::size_t(stage)];
    if (now == before) continue;
    before = now;
    if (now == StageState::done) load(folder_);  // another result can be shown
  }
  if (pipeline_.stage && follow_ && shown_ != Step::direct && shown_ != Step::export_out) {
    constexpr std::array<Step, kStages.size()> kShown{Step::check, Step::cameras, Step::face, Step::face,
                                                      Step::train};
    shown_ = kShown[std::size_t(*pipeline_.stage)];
  }
  if (pipeline_.job.state != seen_pipeline_ && !ui::is_working(pipeline_.job)) {
    load(folder_);
    if (pipeline_.job.state == JobState::done && follow_ && shown_ == Step::train) shown_ = Step::direct;
    if (pipeline_.job.state == JobState::stopped && finish_at_s_ && contents_) {
      ProjectOptions finished = pipeline_job_->started_with().options;
      finished.steps = 0;
      finished.budget_s = std::max(1.0, *finish_at_s_ / kOverrunOfTraining);
      finish_at_s_.reset();
      start_pipeline(finished);
      return;
    }
    finish_at_s_.reset();
    const auto told = [](const StageRecord& record) { return record.state == StageState::failed; };
    if (pipeline_.job.state == JobState::failed && pipeline_.job.error &&
        std::ranges::none_of(pipeline_.records, told))
      fail(*pipeline_.job.error);  // of no single stage: a busy project, a full disk, no memory
  }
  seen_pipeline_ = pipeline_.job.state;
}

Snapshot Studio::snapshot() const {
  Snapshot s;
  s.loading = loading_ && !contents_;
  s.contents = contents_;
  s.pipeline = pipeline_;
  if (demo_) s.demo = demo_->status();
  s.exporting = exports_.status();
  s.exports = exports_.items();
  if (check_) s.checking = check_->status();
  s.verdict = verdict_;
  s.exported = exports_.last_written();
  s.steps = view_steps(contents_.get(), s.loading, s.pipeline, s.exporting, s.exported);
  add_verdict(s.checking, s.verdict.get(), s.steps[std::size_t(Step::check)]);
  if (!pipeline_.curve.training.empty()) {
    s.curve = pipeline_.curve;
  } else if (contents_ && contents_->curve) {
    s.curve = *contents_->curve;
  }
  s.deleting = deleting_;
  s.shown = shown_;
  s.export_choice = export_choice_;
  s.settings = settings_;
  s.directing = directing_.view();
  if (contents_ && contents_->avatar) {
    const ProjectAvatar& avatar = *contents_->avatar;
    const Performance& performance = *s.directing.performance;
    s.directing.view = direct_moment(avatar.directed, performance, s.directing.playhead_s).view;
    s.directing.beyond =
        beyond_seen(avatar.directed, avatar.views, avatar.limits, performance, s.directing.playhead_s);
  }
  s.moment = moment_number_;
  s.live = drive_.view();
  s.picture = renderer_.latest();
  s.rendering = renderer_.busy();
  s.comparing = comparing_;
  s.clip_picture = clip_picture_;
  s.check_picture = check_picture_;
  s.face_picture = face_picture_;
  s.compare_picture = compare_picture_;
  s.system.threads = current_thread_limit();
  s.system.memory = memory_in_use();
  s.system.available = available_memory().value_or(0);
  s.error = error_;
  s.message = message_;

  Situation& now = s.situation;
  now.project = contents_ != nullptr;
  now.clip_there = contents_ && (contents_->clip || contents_->capture);
  now.clip_missing = contents_ && !contents_->clip;
  now.running = ui::is_working(pipeline_.job) || ui::is_working(s.demo);
  now.paused =
      (ui::is_working(pipeline_.job) && pipeline_.job.paused) || (ui::is_working(s.demo) && s.demo.paused);
  now.training =
      ui::is_working(pipeline_.job) && pipeline_.stage == Stage::train && !pipeline_.training.empty();
  now.finished = contents_ && std::ranges::all_of(contents_->current, std::identity{}) &&
                 std::ranges::none_of(contents_->stale, std::identity{});
  now.avatar = contents_ && contents_->avatar;
  now.exporting = exports_.is_working();
  now.checking = ui::is_working(s.checking);
  now.can_check = contents_ && contents_->clip;
  now.directing = shown_ == Step::direct;
  now.can_undo = !s.directing.undo_name.empty();
  now.can_redo = !s.directing.redo_name.empty();
  now.keys = !s.directing.performance->channels.empty();
  now.keys_chosen = !s.directing.selected->empty();
  now.keys_copied = s.directing.keys_copied;
  now.pose_copied = s.directing.pose_copied;
  now.driven = s.live.on;
  now.consent = contents_ && contents_->project.consent != Consent::not_asked;
  return s;
}

Wish Studio::apply(const Requests& requests) {
  if (requests.dismiss_error) error_.reset();
  if (requests.dismiss_message) message_.clear();
  if (requests.open) open(*requests.open);
  if (requests.forget_recent) std::erase(settings_.recent, *requests.forget_recent);
  if (requests.show) {
    shown_ = *requests.show;
    follow_ = pipeline_.stage.has_value() && shown_ == Step::train;
  }
  if (requests.consent && contents_) {
    // The folder's own file is written at once, and read back.
    Project project = latest_project();
    project.consent = *requests.consent;
    if (const auto saved = save_project(project); !saved) fail(saved.error());
    load(folder_);
  }
  if (requests.nobody_agreed && contents_) {
    // A project that holds nothing but the question goes; the clip itself stays where it is.
    const fs::path folder = folder_;
    close_project();
    std::error_code ignored;
    bool only_the_question = true;
    for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored))
      only_the_question &= it->path().filename() == "project.json" || it->path().filename() == ".lock";
    if (!ignored && only_the_question) {
      std::erase_if(settings_.recent, [&](const fs::path& recent) { return same_place(recent, folder); });
      for (const char* name : {"project.json", ".lock"}) fs::remove(folder / name, ignored);
      fs::remove(folder, ignored);
    }
    message_ = "Without the person's agreement no avatar is made.";
  }
  if (requests.relink) relink(*requests.relink, false);
  if (requests.delete_person) delete_person(*requests.delete_person);
  if (requests.left_out && contents_ && contents_->capture) {
    if (const auto fine = check_left_out(*contents_->capture, *requests.left_out); !fine) {
      fail(fine.error());
    } else {
      edit_options([&](ProjectOptions& o) {
        o.left_out = *requests.left_out;
        repair_budget(o);
      });
    }
  }
  if (requests.check_frame) show_frame(&Studio::check_picture_, *requests.check_frame, false);
  if (requests.face_frame) show_frame(&Studio::face_picture_, *requests.face_frame, true);
  if (requests.compare_frame) {
    show_frame(&Studio::compare_picture_, *requests.compare_frame, false);
    request_picture();
  }
  apply(requests.direct);
  if (requests.gains) drive_.set_gains(*requests.gains);
  if (requests.drive_video) start_driving([file = *requests.drive_video] { return open_clip_source(file); });
  if (requests.open_performance) open_performance(*requests.open_performance);
  if (requests.save_performance) {
    save_performance_as(*requests.save_performance);
  }
  if (requests.view_px && *requests.view_px != view_px_) {
    view_px_ = *requests.view_px;
    request_picture();
  }
  if (requests.export_choice) export_choice_ = *requests.export_choice;
  if (requests.stop_export) exports_.stop(*requests.stop_export);
  if (requests.retry_export) {
    if (is_enabled(Command::export_still, snapshot().situation)) {
      exports_.retry(*requests.retry_export);
    } else {
      fail({ErrorCode::failed, "Nothing is exported while the avatar is being made.",
            "Pause or stop that first, or wait for its end.", ""});
    }
  }
  if (requests.forget_export) exports_.forget(*requests.forget_export);
  if (requests.budget_s)
    edit_options([&](ProjectOptions& o) { o.budget_s = *requests.budget_s, o.steps = 0; });
  if (requests.picture_size)
    edit_options([&](ProjectOptions& o) {
      o.size = *requests.picture_size;
      repair_budget(o);
    });
  Wish wish = Wish::none;
  for (const Command command : requests.commands) {
    if (!is_enabled(command, snapshot().situation)) continue;
    if (const Wish w = carry_out(command); w != Wish::none) wish = w;
  }
  return wish;
}

Wish Studio::carry_out(Command command) {
  const auto show = [&](int by) {
    shown_ = kSteps[std::size_t(std::clamp(int(shown_) + by, 0, int(kSteps.size()) - 1))];
    follow_ = false;
  };
  const auto rescale = [&](int by) {
    settings_.scale_percent = std::clamp(settings_.scale_percent + by, kLeastScale, kMostScale);
  };
  switch (command) {
    case Command::open_clip:
      return Wish::pick_clip;
    case Command::open_project:
      return Wish::pick_project;
    case Command::quit:
      return Wish::quit;
    case Command::film_guide:
      return Wish::film_guide;
    case Command::shortcuts:
      return Wish::shortcuts;
    case Command::licences:
      return Wish::licences;
    case Command::find_clip:
      return Wish::find_clip;
    case Command::delete_person:
      return Wish::delete_person;
    case Command::try_demo:
      start_demo();
      break;
    case Command::close_project:
      close_project();
      break;
    case Command::make_avatar:
      follow_ = true;
      start_pipeline(contents_->project.options);
      break;
    case Command::check_clip:
      start_check();
      break;
    case Command::pause:
      if (demo_) demo_->pause();
      if (pipeline_job_) pipeline_job_->pause();
      break;
    case Command::go_on:
      if (demo_) demo_->go_on();
      if (pipeline_job_) pipeline_job_->go_on();
      break;
    case Command::stop_work:
      finish_at_s_.reset();
      if (demo_) demo_->stop();
      if (pipeline_job_) pipeline_job_->stop();
      break;
    case Command::finish_now:
      finish_at_s_ = pipeline_.training.back().seconds;
      pipeline_job_->stop();
      break;
    case Command::train_longer: {
      ProjectOptions longer = contents_->project.options;
      const double spent = contents_->avatar ? contents_->avatar->avatar.train_seconds : longer.budget_s;
      longer.budget_s = std::max(1.0, std::round(spent)) + options_.longer_s;
      longer.steps = 0;
      follow_ = true;
      shown_ = Step::train;
      start_pipeline(longer);
      break;
    }
    case Command::undo:
    case Command::redo:
    case Command::reset_face:
    case Command::reset_head:
    case Command::reset_view:
    case Command::copy_keys:
    case Command::paste_keys:
    case Command::delete_keys:
    case Command::choose_all_keys:
    case Command::choose_keys_here:
    case Command::copy_pose:
    case Command::paste_pose:
    case Command::open_performance:
    case Command::save_performance:
    case Command::play:
    case Command::repeat:
    case Command::record_keys:
    case Command::add_keys:
    case Command::keys_earlier:
    case Command::keys_later:
    case Command::next_easing:
    case Command::previous_picture:
    case Command::next_picture:
    case Command::previous_key:
    case Command::next_key:
    case Command::go_to_start:
    case Command::go_to_end:
    case Command::random_walk:
    case Command::camera_orbit:
    case Command::camera_dolly:
    case Command::drive_video:
    case Command::drive_webcam:
    case Command::rest_face:
    case Command::record_drive:
    case Command::stop_driving:
      return direct(command);
    case Command::compare:
      comparing_ = !comparing_;
      if (comparing_ && compare_picture_.frame < 0 && contents_)
        if (const auto frames = shown_frames(*contents_, false); !frames.empty())
          show_frame(&Studio::compare_picture_, frames[frames.size() / 2], false);
      request_picture();
      break;
    case Command::previous_step:
      show(-1);
      break;
    case Command::next_step:
      show(1);
      break;
    case Command::export_still:
      start_export(ExportKind::still);
      break;
    case Command::export_orbit:
      start_export(ExportKind::orbit);
      break;
    case Command::export_performance:
      start_export(ExportKind::performance);
      break;
    case Command::export_driven:
      start_export(ExportKind::driven);
      break;
    case Command::export_mesh:
      start_export(ExportKind::mesh);
      break;
    case Command::stop_export:
      exports_.stop_all();
      break;
    case Command::toggle_theme:
      settings_.dark = !settings_.dark;
      break;
    case Command::larger:
      rescale(kScaleStep);
      break;
    case Command::smaller:
      rescale(-kScaleStep);
      break;
    case Command::save_diagnostics:
      save_diagnostics();
      break;
  }
  return Wish::none;
}

void Studio::open(const fs::path& path) {
  if (is_enabled(Command::open_clip, snapshot().situation) == false) {
    fail({ErrorCode::failed, "An avatar is being made or exported just now.",
          "Pause or stop it first; what is made of the avatar so far is kept.", ""});
    return;
  }
  std::error_code ignored;
  const fs::path folder = path.filename() == "project.json" ? path.parent_path() : path;
  if (fs::is_directory(folder, ignored)) {
    if (!fs::exists(folder / "project.json", ignored)) {
      if (const auto project = open_project(folder); !project) fail(project.error());
      return;
    }
    load(folder);
  } else if (contents_ && !contents_->clip) {
    relink(path, true);  // the clip that is looked for, or another one
  } else {
    open_clip(path, Consent::not_asked, options_.project);
  }
}

// or_open: another clip is opened as such.
void Studio::relink(const fs::path& clip, bool or_open) {
  if (!contents_ || ui::is_working(pipeline_.job)) return;
  loading_ = true;
  background_.run("relink", [this, folder = folder_, clip, or_open](std::stop_token) -> Background::Delivery {
    const auto linked = relink_clip(folder, clip);
    return [this, folder, clip, or_open, error = linked ? std::nullopt : std::optional(linked.error())] {
      loading_ = false;
      if (folder != folder_) return;
      if (error && or_open && error->code == ErrorCode::bad_input) {
        open_clip(clip, Consent::not_asked, options_.project);
      } else if (error) {
        fail(*error);
      } else {
        message_ = "The clip is found again: " + clip.string();
        load(folder);
      }
    };
  });
}

void Studio::delete_person(bool keep_exports) {
  if (!contents_ || is_working()) return;
  const fs::path folder = folder_;
  close_project();
  deleting_ = true;
  // After whatever was being read of the project: one thread does both, in order.
  background_.run("", [this, folder, keep_exports](std::stop_token) -> Background::Delivery {
    const auto deleted = likeness::delete_person(folder, keep_exports);
    return [this, folder, deleted] {
      deleting_ = false;
      if (!deleted) {
        fail(deleted.error());
        return;
      }
      std::erase_if(settings_.recent, [&](const fs::path& recent) { return same_place(recent, folder); });
      message_ = fmt::format("The person is deleted: {:.1f} MB were removed.", double(deleted->bytes) / 1e6);
      if (!deleted->folder_gone)
        message_ += " Kept: " + fmt::format("{}", fmt::join(deleted->kept, ", ")) + ".";
    };
  });
}

void Studio::open_clip(const fs::path& clip, Consent consent, ProjectOptions options) {
  loading_ = true;  // the open project stays until there is another
  background_.run("open", [this, clip, consent, options](std::stop_token) mutable -> Background::Delivery {
    const auto failed = [this](Error error) {
      return [this, error] {
        loading_ = false;
        fail(error);
      };
    };
    const auto info = probe_video(clip);
    if (!info) return failed(info.error());
    const fs::path folder = folder_for(options_.projects, clip);
    std::error_code ignored;
    if (!fs::exists(folder / "project.json", ignored)) {
      options.video = clip;
      auto made = open_or_create_project(folder, options);
      if (!made) return failed(made.error());
      made->consent = consent;
      if (const auto saved = save_project(*made); !saved) return failed(saved.error());
    }
    return [this, folder] { load(folder); };
  });
}

void Studio::load(const fs::path& folder) {
  if (!same_place(folder, folder_)) {
    close_project();
    folder_ = folder;
  }
  loading_ = true;
  const std::uint64_t number = ++load_number_;
  background_.run(
      "contents",
      [this, folder = folder_, number, earlier = contents_](std::stop_token) -> Background::Delivery {
        auto contents = read_contents(folder, earlier.get());
        auto overlay = contents && (!earlier || earlier->track != (*contents)->track)
                           ? FaceOverlay::make(*contents)
                           : nullptr;
        return [this, folder, number, contents = std::move(contents), overlay = std::move(overlay)] {
          if (folder != folder_ || number != load_number_) return;  // another was opened or changed meanwhile
          loading_ = false;
          if (!contents) {
            fail(contents.error());
            if (!contents_) close_project();
            std::erase(settings_.recent, folder);
            return;
          }
          if (overlay) overlay_ = overlay;
          loaded(*contents);
        };
      });
}

void Studio::loaded(std::shared_ptr<const ProjectContents> contents) {
  const bool first = contents_ == nullptr;
  const ProjectContents earlier = contents_ ? *contents_ : ProjectContents{};
  contents_ = std::move(contents);
  std::error_code ignored;
  const fs::path place = fs::absolute(folder_, ignored).lexically_normal();
  remember_recent(settings_, ignored ? folder_ : place);
  if (first) {
    save_settings();
    take_performance(folder_);
    shown_ = contents_->avatar ? Step::direct : Step::film;
    read_clip_picture();
  }
  if (!first && contents_->clip && !earlier.clip) read_clip_picture();
  if (contents_->avatar && contents_->avatar != earlier.avatar) request_picture();
  // A new clip is looked at before anything is built from it.
  if (!contents_->capture && contents_->clip && contents_->project.consent != Consent::not_asked && !check_)
    start_check();
  // Pictures of the steps, as soon as there are any.
  const auto middle = [](const FramePicture& picture, const auto& frames) {
    return picture.frame >= 0 ? picture.frame : frames[frames.size() / 2].frame;
  };
  if (contents_->capture && contents_->capture != earlier.capture && !contents_->capture->frames.empty())
    show_frame(&Studio::check_picture_, middle(check_picture_, contents_->capture->frames), false);
  if (contents_->track && contents_->track != earlier.track && !contents_->track->frames.empty())
    show_frame(&Studio::face_picture_, middle(face_picture_, contents_->track->frames), true);
}

void Studio::close_project() {
  lay_takes();
  save_performance(true);
  directing_.open({});
  retire(drive_.stop());
  retire(std::move(pipeline_job_));
  retire(exports_.clear());
  drop_check();
  pipeline_ = {};
  seen_states_ = {};
  seen_pipeline_ = JobState::none;
  finish_at_s_.reset();
  contents_.reset();
  overlay_.reset();
  folder_.clear();
  loading_ = false;
  shown_ = Step::film;
  comparing_ = false;
  for (FramePicture* picture : {&clip_picture_, &check_picture_, &face_picture_, &compare_picture_})
    *picture = {};
  renderer_.clear();
}

void Studio::start_pipeline(ProjectOptions options) {
  if (!contents_) return;
  edit_options([&](ProjectOptions& o) { o = options; });
  Project project = latest_project();
  project.options = options;
  pipeline_ = {};
  seen_pipeline_ = JobState::none;
  seen_states_ = {};
  for (const Stage stage : kStages) seen_states_[std::size_t(stage)] = project.record(stage).state;
  retire(std::move(pipeline_job_));
  pipeline_job_ = std::make_unique<PipelineJob>(project, options_.previews, wake_);
  pipeline_ = pipeline_job_->status();
}

// With the records of the run that may be newer than the last reading of the folder.
Project Studio::latest_project() const {
  Project project = contents_->project;
  if (pipeline_job_) project.stages = pipeline_job_->status().records;
  return project;
}

void Studio::edit_options(const std::function<void(ProjectOptions&)>& change) {
  if (!contents_ || ui::is_working(pipeline_.job)) return;
  auto contents = std::make_shared<ProjectContents>(*contents_);
  contents->project = latest_project();
  change(contents->project.options);
  if (const auto saved = save_project(contents->project); !saved) {
    fail(saved.error());
    return;
  }
  contents_ = std::move(contents);
  load(folder_);
}

void Studio::start_demo() {
  close_project();
  const fs::path clip = options_.projects / "demo" / "demo.mp4";
  demo_ = std::make_unique<Job>(
      [clip, demo = options_.demo](const Progress& progress, std::stop_token stop) -> Result<std::string> {
        std::error_code ignored;
        if (fs::exists(clip, ignored)) return clip.string();
        if (const auto made =
                write_demo_capture(clip.parent_path(), demo, progress.stage(0, 1, "demo"), stop);
            !made)
          return made.error();
        return clip.string();
      },
      wake_);
}

void Studio::drop_check() {
  checked_.reset();
  verdict_.reset();
  retire(std::move(check_));
}

// Work ends between two pictures or two fits: too long to wait for here.
template <class J>
void Studio::retire(std::unique_ptr<J> job) {
  if (!job) return;
  job->stop();
  background_.run("", [ending = std::shared_ptr<J>(std::move(job))](std::stop_token) mutable {
    ending.reset();
    return Background::Delivery();
  });
}

void Studio::start_check() {
  drop_check();
  checked_ = std::make_shared<CaptureVerdict>();
  check_ = std::make_unique<Job>(
      [options = contents_->project.options, into = checked_](const Progress& progress,
                                                              std::stop_token stop) -> Result<std::string> {
        const auto measures =
            measure_clip(options.video, options.landmark_model, progress.stage(0, 1, "check"), stop);
        if (!measures) return measures.error();
        *into = judge_capture(*measures);
        return std::string(verdict_words(into->verdict));
      },
      wake_);
}

void Studio::start_export(ExportKind kind) {
  if (!contents_ || !contents_->avatar) return;
  export_choice_.kind = kind;
  const ProjectAvatar& avatar = *contents_->avatar;
  const double time_s = directing_.playhead_s();
  const ViewPoint view = direct_moment(avatar.directed, *directing_.performance(), time_s).view;
  const ExportChoice choice = settled(export_choice_, view, avatar.avatar);
  ExportOrder order{choice, contents_, directing_.performance(), time_s,
                    export_path(folder_, choice, exports_)};
  if (const auto fine = check_order(order); !fine) {
    fail(fine.error());
    return;
  }
  const fs::path out = order.out;
  exports_.add(out, [order = std::move(order)](const Progress& progress, std::stop_token stop) {
    return write_order(order, progress.stage(0, 1, "export"), stop);
  });
}

void Studio::read_clip_picture() {
  clip_picture_ = {};
  background_.run("clip",
                  [this, video = contents_->project.options.video,
                   folder = folder_](std::stop_token) -> Background::Delivery {
                    std::shared_ptr<const Image8> image;
                    std::string missing;
                    auto reader = VideoReader::open(video);
                    if (reader) {
                      auto frame = reader->next();
                      if (frame && *frame) image = std::make_shared<const Image8>(std::move((*frame)->rgb));
                    } else {
                      missing = reader.error().what;
                    }
                    return [this, folder, image, missing] {
                      if (folder == folder_) clip_picture_ = {0, ++picture_number_, image, missing};
                    };
                  });
}

void Studio::show_frame(FramePicture Studio::*slot, int frame, bool overlay) {
  if (!contents_) return;
  (this->*slot).frame = frame;
  const std::string key = fmt::format("frame {}", slot == &Studio::check_picture_  ? "check"
                                                  : slot == &Studio::face_picture_ ? "face"
                                                                                   : "compare");
  background_.run(key,
                  [this, slot, frame, folder = folder_,
                   draw = overlay ? overlay_ : nullptr](std::stop_token) -> Background::Delivery {
                    auto read = read_image(folder / frame_name(frame));
                    std::shared_ptr<const Image8> image;
                    std::string missing;
                    if (!read) {
                      missing = "No picture of this frame was kept.";
                    } else {
                      image = std::make_shared<const Image8>(
                          draw && read->channels == 3 ? draw->draw(*read, frame) : std::move(*read));
                    }
                    return [this, slot, frame, folder, image, missing] {
                      if (folder == folder_ && (this->*slot).frame == frame)
                        this->*slot = {frame, ++picture_number_, image, missing};
                    };
                  });
}

void Studio::remember_window(int width, int height, bool maximised) {
  settings_.maximised = maximised;
  if (!maximised) settings_.width = width, settings_.height = height;
}

void Studio::save_settings() {
  if (const auto saved = write_settings(options_.settings, settings_); !saved) message_ = saved.error().what;
}

bool Studio::is_working() const {
  return ui::is_working(pipeline_.job) || (demo_ && ui::is_working(demo_->status())) || exports_.is_working();
}

bool Studio::goes_on() const {
  const auto runs = [](const JobStatus& status) { return status.state == JobState::running; };
  return (pipeline_job_ && runs(pipeline_job_->status().job)) || (demo_ && runs(demo_->status())) ||
         std::ranges::any_of(exports_.items(), [&](const ExportItem& item) {
           return item.status.state == JobState::none || runs(item.status);
         });
}

void Studio::stop_work() {
  finish_at_s_.reset();
  if (demo_) demo_->stop();
  if (pipeline_job_) pipeline_job_->stop();
  exports_.stop_all();
  if (check_) check_->stop();
}

void Studio::save_diagnostics() {
  const fs::path out = (folder_.empty() ? options_.projects : folder_) / "diagnostics.txt";
  std::string text =
      fmt::format("Likeness studio\nthreads {}\nmemory in use {} MiB, free {} MiB\n", current_thread_limit(),
                  memory_in_use() >> 20, available_memory().value_or(0) >> 20);
  if (error_)
    text += fmt::format("last error: {}\nremedy: {}\nwhere: {}\n", error_->what, error_->fix, error_->where);
  if (contents_) {
    const Project& p = contents_->project;
    text += fmt::format("picture size {} px, budget {} s, steps {}\n", p.options.size, p.options.budget_s,
                        p.options.steps);
    for (const Stage stage : kStages) {
      const StageRecord& record = p.record(stage);
      text += fmt::format("{}: {} {:.1f} s, {}\n", stage_name(stage),
                          contents_->is_current(stage) ? "current" : "stale", record.seconds, record.message);
      for (const std::string& warning : record.warnings) text += "  note: " + warning + "\n";
    }
  }
  if (const auto written = write_text(out, text); !written) {
    fail(written.error());
  } else {
    message_ = "Written: " + out.string() + ". It holds no picture.";
  }
}

}  // namespace likeness::ui
