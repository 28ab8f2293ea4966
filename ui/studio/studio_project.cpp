// Opening, closing, finding again and deleting projects: see studio.h.
#include "ui/studio/studio.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/files.h"
#include "core/project/care.h"
#include "ui/studio/same_place.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

// What is meant by a file of a project - its project.json, its avatar - is the project: a file manager shows
// the folder as any other, and people open what is in it.
fs::path project_folder_of(const fs::path& path) {
  std::error_code failure;
  fs::path whole = fs::absolute(path, failure).lexically_normal();
  if (failure) return path;
  if (!whole.has_filename()) whole = whole.parent_path();  // "me.likeness/"
  if (whole.filename() != "project.json" && whole.filename() != "avatar.bin") return whole;
  return fs::exists(whole.parent_path() / "project.json", failure) ? whole.parent_path() : whole;
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

}  // namespace

void Studio::open(const fs::path& path) {
  if (is_enabled(Command::open_clip, snapshot().situation) == false) {
    if (records()) {
      notices_.fail({ErrorCode::failed, "A clip is being recorded just now.",
                     "Stop recording first; what is recorded is kept.", ""});
    } else if (studies()) {
      notices_.fail({ErrorCode::failed, "Methods are being compared just now.",
                     "Stop the comparison first; what is finished of it is kept.", ""});
    } else if (demo_ && ui::is_working(demo_->status())) {
      notices_.fail({ErrorCode::failed, "The demo is being filmed just now.",
                     "Stop it first, or wait for its end.", ""});
    } else {
      notices_.fail({ErrorCode::failed, "An avatar is being made or exported just now.",
                     "Stop it first; what is made of the avatar so far is kept.", ""});
    }
    return;
  }
  leave_recorder();
  std::error_code ignored;
  const fs::path folder = project_folder_of(path);
  if (fs::is_directory(folder, ignored)) {
    if (!fs::exists(folder / "project.json", ignored)) {
      if (const auto project = open_project(folder); !project) notices_.fail(project.error());
      return;
    }
    load(folder);
  } else if (open_.contents && !open_.contents->clip) {
    relink(path, true);  // the clip that is looked for, or another one
  } else {
    open_clip(path, Consent::not_asked, options_.project);
  }
}

// or_open: another clip is opened as such.
void Studio::relink(const fs::path& clip, bool or_open) {
  if (!open_.contents || open_.is_running()) return;
  loading_ = true;
  background_.run(
      "relink", [this, folder = open_.folder, clip, or_open](std::stop_token) -> Background::Delivery {
        const auto linked = relink_clip(folder, clip);
        return [this, folder, clip, or_open, error = linked ? std::nullopt : std::optional(linked.error())] {
          loading_ = false;
          if (folder != open_.folder) return;
          if (error && or_open && error->code == ErrorCode::bad_input) {
            open_clip(clip, Consent::not_asked, options_.project);
          } else if (error) {
            notices_.fail(*error);
          } else {
            notices_.message = "The clip is found again: " + clip.string();
            load(folder);
          }
        };
      });
}

void Studio::repair() {
  if (!damaged_) return;
  loading_ = true;
  background_.run("repair", [this, folder = damaged_->folder](std::stop_token) -> Background::Delivery {
    const auto repaired = repair_project(folder);
    return [this, folder, error = repaired ? std::nullopt : std::optional(repaired.error())] {
      loading_ = false;
      if (error) return notices_.fail(*error);
      notices_.error.reset();
      notices_.message =
          "The project is repaired. What was chosen for it is the usual again: look through the Film step.";
      load(folder);
    };
  });
}

void Studio::delete_person(bool keep_exports) {
  if ((!open_.contents && !damaged_) || is_working()) return;
  const fs::path folder = open_.contents ? open_.folder : damaged_->folder;
  if (!open_.contents) notices_.error.reset();  // that it cannot be opened
  damaged_.reset();
  close_project();
  deleting_ = true;
  // After whatever was being read of the project: one thread does both, in order.
  background_.run("", [this, folder, keep_exports](std::stop_token) -> Background::Delivery {
    const auto deleted = likeness::delete_person(folder, keep_exports);
    return [this, folder, deleted] {
      deleting_ = false;
      if (!deleted) {
        notices_.fail(deleted.error());
        return;
      }
      std::erase_if(settings_.recent, [&](const fs::path& recent) { return same_place(recent, folder); });
      notices_.message = deletion_words(*deleted);
    };
  });
}

void Studio::open_clip(const fs::path& clip, Consent consent, ProjectOptions options) {
  loading_ = true;  // the open project stays until there is another
  background_.run("open", [this, clip, consent, options](std::stop_token) mutable -> Background::Delivery {
    const auto failed = [this](Error error) {
      return [this, error] {
        loading_ = false;
        notices_.fail(error);
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
  damaged_.reset();
  if (!same_place(folder, open_.folder)) {
    close_project();
    open_.folder = folder;
  }
  loading_ = true;
  const std::uint64_t number = ++load_number_;
  background_.run("contents",
                  [this, folder = open_.folder, number, earlier = open_.contents,
                   edit = painted_edit()](std::stop_token) -> Background::Delivery {
                    auto contents = read_contents(folder, earlier.get());
                    auto damaged = contents ? std::nullopt : find_damaged_project(folder);
                    auto overlay = contents && (!earlier || earlier->track != (*contents)->track)
                                       ? FaceOverlay::make(*contents)
                                       : nullptr;
                    return [this, folder, number, edit, contents = std::move(contents),
                            overlay = std::move(overlay), damaged = std::move(damaged)] {
                      if (folder != open_.folder || number != load_number_)
                        return;  // another was opened or changed meanwhile
                      loading_ = false;
                      if (!contents) {
                        notices_.fail(contents.error());
                        if (!open_.contents) close_project();
                        damaged_ = damaged;
                        // A damaged one stays on the list: it can be repaired or deleted from there.
                        if (!damaged) std::erase(settings_.recent, folder);
                        return;
                      }
                      if (overlay) overlay_ = overlay;
                      loaded(*contents, edit);
                    };
                  });
}

void Studio::loaded(std::shared_ptr<const ProjectContents> contents, std::uint64_t masks_edit) {
  const bool first = open_.contents == nullptr;
  const ProjectContents earlier = open_.contents ? *open_.contents : ProjectContents{};
  open_.contents = std::move(contents);
  std::error_code ignored;
  const fs::path place = fs::absolute(open_.folder, ignored).lexically_normal();
  remember_recent(settings_, ignored ? open_.folder : place);
  if (first) {
    save_settings();
    take_performance(open_.folder);
    shown_.step = open_.contents->avatar ? Step::direct : Step::film;
    read_clip_picture();
  }
  take_masks(first, masks_edit);
  if (!first && open_.contents->clip && !earlier.clip) read_clip_picture();
  if (open_.contents->avatar && open_.contents->avatar != earlier.avatar) request_picture();
  // A new clip is looked at before anything is built from it.
  if (!open_.contents->capture && open_.contents->clip &&
      open_.contents->project.consent != Consent::not_asked && !check_)
    start_check();
  // Pictures of the steps, as soon as there are any.
  const auto middle = [](const FramePicture& picture, const auto& frames) {
    return picture.frame >= 0 ? picture.frame : frames[frames.size() / 2].frame;
  };
  if (open_.contents->capture && open_.contents->capture != earlier.capture &&
      !open_.contents->capture->frames.empty())
    show_frame(&Studio::check_picture_, middle(check_picture_, open_.contents->capture->frames), false);
  if (open_.contents->track && open_.contents->track != earlier.track &&
      !open_.contents->track->frames.empty())
    show_frame(&Studio::face_picture_, middle(face_picture_, open_.contents->track->frames), true);
}

void Studio::close_project() {
  save_strokes();
  masks_.open({}, {});
  attributes_.open({}, {});
  masks_.set_frames({});
  mask_picture_ = {};
  mask_source_.reset();
  strokes_changed_.reset();
  lay_takes();
  save_performance(true);
  directing_.open({});
  background_.retire(drive_.stop());
  background_.retire(std::move(pipeline_job_));
  background_.retire(exports_.clear());
  forget_study();
  drop_check();
  open_.pipeline = {};
  solving_.reset();
  seen_states_ = {};
  seen_pipeline_ = JobState::none;
  finish_at_s_.reset();
  refit_.reset();
  open_.contents.reset();
  overlay_.reset();
  open_.folder.clear();
  loading_ = false;
  shown_.step = Step::film;
  comparing_ = false;
  for (FramePicture* picture : {&clip_picture_, &check_picture_, &face_picture_, &compare_picture_})
    *picture = {};
  renderer_.clear();
}

// With the records of the run that may be newer than the last reading of the folder.
Project Studio::latest_project() const {
  Project project = open_.contents->project;
  if (pipeline_job_) project.stages = pipeline_job_->status().records;
  return project;
}

// The list of clips, changed on the disk and read back. Until then no choice is written over it.
void Studio::change_clips(const std::function<Result<std::string>(Project&)>& change) {
  if (!open_.contents || changing_clips_ || is_working()) return;
  changing_clips_ = loading_ = true;
  background_.run(
      "clips", [this, change, project = latest_project()](std::stop_token) mutable -> Background::Delivery {
        const auto changed = change(project);
        return [this, folder = project.folder, changed] {
          changing_clips_ = loading_ = false;
          if (folder != open_.folder) return;
          if (!changed) return notices_.fail(changed.error());
          notices_.message = *changed;
          open_.pipeline = {};
          load(folder);
        };
      });
}

bool Studio::edit_options(const std::function<void(ProjectOptions&)>& change) {
  if (!open_.contents || changing_clips_ || open_.is_running()) return false;
  // What a command line did to the project meanwhile stays.
  auto changed = change_project(open_.folder, [&](Project& project) { change(project.options); });
  if (!changed) {
    notices_.fail(changed.error());
    return false;
  }
  auto contents = std::make_shared<ProjectContents>(*open_.contents);
  contents->project = std::move(*changed);
  open_.contents = std::move(contents);
  load(open_.folder);
  return true;
}

}  // namespace likeness::ui
