// Opening, reading, changing, closing and deleting projects: see project_session.h.
#include "ui/studio/project_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/file_names.h"
#include "core/base/files.h"
#include "core/project/care.h"
#include "core/project/further_clips.h"
#include "core/project/own_names.h"
#include "ui/studio/read_frames.h"
#include "ui/studio/same_place.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

// A project's project.json or avatar.bin stands for the project: a file manager shows the folder like any
// other, and people open what is in it.
fs::path project_folder_of(const fs::path& path) {
  std::error_code failure;
  fs::path whole = fs::absolute(path, failure).lexically_normal();
  if (failure) return path;
  if (!whole.has_filename()) whole = whole.parent_path();  // "me.likeness/"
  if (whole.filename() != "project.json" && whole.filename() != "avatar.bin") return whole;
  return fs::exists(whole.parent_path() / "project.json", failure) ? whole.parent_path() : whole;
}

// The folder of a clip's project: NAME.likeness, or NAME-2.likeness if that one belongs to another clip.
fs::path folder_for(const fs::path& projects, const fs::path& clip) {
  const std::string name = clip.stem().string();
  for (int number = 1;; ++number) {
    const fs::path folder =
        projects / name_with(name, number == 1 ? ".likeness" : fmt::format("-{}.likeness", number));
    std::error_code ignored;
    if (!fs::exists(folder, ignored)) return folder;
    const auto project = open_project(folder);
    if (project && same_place(project->options.shared.video, clip)) return folder;
  }
}

// Waits for a window that is just closing the project.
std::shared_ptr<const WindowLock> hold(const fs::path& folder) {
  constexpr auto kPause = std::chrono::milliseconds(50);
  auto lock = std::make_shared<const WindowLock>(folder);
  for (int tries = 0; lock->is_others() && tries < 10; ++tries) {
    std::this_thread::sleep_for(kPause);
    lock = std::make_shared<const WindowLock>(folder);
  }
  return lock;
}

}  // namespace

void choose_budget(ProjectOptions& options, double budget_s) {
  options.train.budget_s = budget_s, options.train.full_budget_s = 0, options.train.steps = 0;
}

ProjectView ProjectSession::view() const {
  ProjectView view;
  view.loading = loading_ && !open_.contents;
  view.contents = open_.contents;
  view.damaged = damaged_;
  view.elsewhere = elsewhere_;
  view.look_only = open_.look_only;
  view.pipeline = open_.pipeline;
  if (demo_) view.demo = demo_->status();
  if (check_) view.checking = check_->status();
  view.solving = solving_;
  const std::shared_ptr<const CheckedClip> kept = open_.contents ? open_.contents->checked : nullptr;
  if (const auto& checked = checked_ ? checked_ : kept) {
    view.verdict = {checked, &checked->verdict};
    view.checked = {checked, &checked->facts};
  }
  view.can_undo_camera = !earlier_cameras_.empty();
  view.can_redo_camera = !later_cameras_.empty();
  if (!open_.pipeline.curve.training.empty()) {
    view.curve = open_.pipeline.curve;
  } else if (open_.contents && open_.contents->curve) {
    view.curve = *open_.contents->curve;
  }
  view.deleting = deleting_;
  view.clip_picture = clip_picture_;
  view.check_picture = check_picture_;
  view.face_picture = face_picture_;
  return view;
}

void ProjectSession::apply(const ProjectRequests& requests) {
  if (requests.look_only && elsewhere_) {
    const fs::path folder = *std::exchange(elsewhere_, std::nullopt);
    if (*requests.look_only) read(folder, true);
  }
  if (requests.check_frame) show_check_frame(*requests.check_frame);
  if (requests.face_frame) show_face_frame(*requests.face_frame);
  if (open_.look_only) return;  // what follows changes the project
  if (requests.consent && open_.contents) answer_consent(*requests.consent);
  if (requests.nobody_agreed && open_.contents) refuse_consent();
  if (requests.relink) relink(*requests.relink, false);
  if (requests.add_clip)
    change_clips([clip = *requests.add_clip](Project& project) -> Result<std::string> {
      const auto number = add_further_clip(project, clip);
      if (!number) return number.error();
      return clip.filename().string() + " is added: the avatar learns from it when it is made again.";
    });
  if (requests.remove_clip)
    change_clips([number = *requests.remove_clip](Project& project) -> Result<std::string> {
      if (const auto removed = remove_further_clip(project, number); !removed) return removed.error();
      return fmt::format("Clip {} is taken out; the file stays where it is.", number);
    });
  if (requests.delete_person) delete_person(*requests.delete_person);
  if (requests.left_out && open_.contents && open_.contents->capture) leave_out(*requests.left_out);
  if (requests.rest_frames && open_.contents && open_.contents->capture) name_rest(*requests.rest_frames);
  if (requests.refit) refit(*requests.refit, true);
  if (requests.take_back) refit(*requests.take_back, false);
  if (requests.camera_kind && open_.contents) choose_camera(*requests.camera_kind);
  if (requests.budget_s) edit_options([&](ProjectOptions& o) { choose_budget(o, *requests.budget_s); });
  if (requests.picture_size)
    edit_options([&](ProjectOptions& o) {
      o.import.size = *requests.picture_size;
      restore_budget(o);
    });
}

// project.json is written at once, and the project read again.
void ProjectSession::answer_consent(Consent consent) {
  const auto answered = change_project(open_.folder, [&](Project& project) { project.consent = consent; });
  if (!answered) context_.notices.fail(answered.error());
  read_again();
}

// A project that holds nothing but the question is deleted; the clip itself stays where it is.
void ProjectSession::refuse_consent() {
  const fs::path folder = open_.folder;
  close();
  std::error_code ignored;
  bool only_the_question = true;
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored))
    only_the_question &=
        it->path().filename() == "project.json" || is_lock_name(it->path().filename().string());
  if (!ignored && only_the_question) {
    std::erase_if(context_.settings.recent,
                  [&](const fs::path& recent) { return same_place(recent, folder); });
    for (const char* name : {"project.json", kWorkLock, kWindowLock}) fs::remove(folder / name, ignored);
    fs::remove(folder, ignored);
  }
  context_.notices.message = "Without the person's agreement no avatar is made.";
}

void ProjectSession::leave_out(const std::vector<int>& frames) {
  if (const auto fine = check_left_out(*open_.contents->capture, frames); !fine)
    return context_.notices.fail(fine.error());
  edit_options([&](ProjectOptions& o) {
    o.train.left_out = frames;
    restore_budget(o);
  });
}

void ProjectSession::name_rest(const std::vector<int>& frames) {
  if (const auto fine = check_rest_frames(*open_.contents->capture, frames); !fine)
    return context_.notices.fail(fine.error());
  const bool changed = edit_options([&](ProjectOptions& o) {
    o.fit.rest_frames = frames;
    restore_budget(o);
  });
  if (changed)
    context_.notices.message = "Make the avatar again: every expression then counts from this rest.";
}

void ProjectSession::show_check_frame(int frame) {
  if (open_.contents) read_frame(context_, "frame check", frame, nullptr, check_picture_);
}

void ProjectSession::show_face_frame(int frame) {
  if (open_.contents) read_frame(context_, "frame face", frame, overlay_, face_picture_);
}

void ProjectSession::open(const fs::path& path) {
  std::error_code ignored;
  const fs::path folder = project_folder_of(path);
  waiting_clip_.reset();
  if (fs::is_directory(folder, ignored)) {
    // Asked for again, it may be free by now.
    if (open_.look_only && same_place(folder, open_.folder)) close();
    if (!fs::exists(folder / "project.json", ignored)) {
      if (const auto project = open_project(folder); !project) context_.notices.fail(project.error());
      return;
    }
    read(folder);
  } else if (open_.contents && !open_.contents->clip && !open_.look_only) {
    relink(path, true);  // the missing clip, or another one
  } else {
    open_clip(path, Consent::not_asked);
  }
}

// or_open: if it is another clip, its own project is opened.
// Saves the choice, with which the cameras and what is made from them are stale.
bool ProjectSession::set_camera(std::optional<CameraKind> kind) {
  return edit_options([&](ProjectOptions& o) {
    o.align.camera = kind;
    restore_budget(o);
  });
}

void ProjectSession::choose_camera(std::optional<CameraKind> kind) {
  const auto before = open_.contents->project.options.align.camera;
  if (kind == before || !set_camera(kind)) return;
  earlier_cameras_.push_back(before);
  later_cameras_.clear();
}

void ProjectSession::undo_camera() {
  if (!open_.contents || earlier_cameras_.empty()) return;
  const auto now = open_.contents->project.options.align.camera;
  if (!set_camera(earlier_cameras_.back())) return;
  earlier_cameras_.pop_back();
  later_cameras_.push_back(now);
}

void ProjectSession::redo_camera() {
  if (!open_.contents || later_cameras_.empty()) return;
  const auto now = open_.contents->project.options.align.camera;
  if (!set_camera(later_cameras_.back())) return;
  later_cameras_.pop_back();
  earlier_cameras_.push_back(now);
}

void ProjectSession::relink(const fs::path& clip, bool or_open) {
  if (!open_.contents || !open_.may_change()) return;
  loading_ = true;
  context_.background.run(
      "relink", [this, folder = open_.folder, clip, or_open](std::stop_token) -> Background::Delivery {
        const auto linked = relink_clip(folder, clip);
        return [this, folder, clip, or_open, error = linked ? std::nullopt : std::optional(linked.error())] {
          loading_ = false;
          if (folder != open_.folder) return;
          if (error && or_open && error->code == ErrorCode::bad_input) {
            open_clip(clip, Consent::not_asked);
          } else if (error) {
            context_.notices.fail(*error);
          } else {
            context_.notices.message = "The clip is found again: " + clip.string();
            read(folder);
          }
        };
      });
}

void ProjectSession::repair() {
  if (!damaged_) return;
  loading_ = true;
  context_.background.run(
      "repair", [this, folder = damaged_->folder](std::stop_token) -> Background::Delivery {
        const auto repaired = repair_project(folder);
        return [this, folder, error = repaired ? std::nullopt : std::optional(repaired.error())] {
          loading_ = false;
          if (error) return context_.notices.fail(*error);
          context_.notices.error.reset();
          context_.notices.message =
              "The project is repaired. Its choices are the defaults again: look through the Film step.";
          read(folder);
        };
      });
}

void ProjectSession::delete_person(bool keep_exports) {
  if ((!open_.contents && !damaged_) || is_working() || neighbours_.are_working()) return;
  const fs::path folder = open_.contents ? open_.folder : damaged_->folder;
  if (!open_.contents) context_.notices.error.reset();  // which says that it cannot be opened
  damaged_.reset();
  close();
  deleting_ = true;
  // Runs after anything that is still reading the project: one thread does both, in order.
  context_.background.run("", [this, folder, keep_exports](std::stop_token) -> Background::Delivery {
    const auto deleted = likeness::delete_person(folder, keep_exports);
    return [this, folder, deleted] {
      deleting_ = false;
      if (!deleted) {
        context_.notices.fail(deleted.error());
        return;
      }
      std::erase_if(context_.settings.recent,
                    [&](const fs::path& recent) { return same_place(recent, folder); });
      context_.notices.message = deletion_words(*deleted);
    };
  });
}

void ProjectSession::open_clip(const fs::path& clip, Consent consent) {
  loading_ = true;  // the open project stays until there is another
  waiting_clip_.reset();
  context_.background.run("open",
                          [this, clip, consent, options = context_.options.project,
                           projects = context_.projects](std::stop_token) mutable -> Background::Delivery {
                            const auto failed = [this](Error error) {
                              return [this, error] {
                                loading_ = false;
                                context_.notices.fail(error);
                              };
                            };
                            const auto info = probe_video(clip);
                            if (!info) return failed(info.error());
                            const fs::path folder = folder_for(projects, clip);
                            std::error_code ignored;
                            if (!fs::exists(folder / "project.json", ignored)) {
                              options.shared.video = clip;
                              auto made = open_or_create_project(folder, options);
                              if (made) {
                                made->consent = consent;
                                if (const auto saved = save_project(*made); !saved) made = saved.error();
                              }
                              if (!made)
                                return [this, clip, consent, tell = failed(made.error())] {
                                  waiting_clip_.emplace(clip, consent);
                                  tell();
                                };
                            }
                            return [this, folder] { read(folder); };
                          });
}

void ProjectSession::open_waiting_clip() {
  if (const auto clip = std::exchange(waiting_clip_, std::nullopt)) open_clip(clip->first, clip->second);
}

void ProjectSession::read_again() { read(open_.folder); }

void ProjectSession::read(const fs::path& folder, bool look_only) {
  damaged_.reset();
  elsewhere_.reset();
  if (!same_place(folder, open_.folder)) {
    close();
    open_.folder = folder;
    open_.look_only = look_only;
  }
  loading_ = true;
  neighbours_.reading_begins();
  const std::uint64_t number = ++readings_;
  context_.background.run("contents",
                          [this, folder = open_.folder, number, earlier = open_.contents, window = window_,
                           looks = open_.look_only](std::stop_token) mutable -> Background::Delivery {
                            if (!window && !looks) window = hold(folder);
                            if (window && window->is_others())
                              return [this, folder, number] {
                                if (folder != open_.folder || number != readings_) return;
                                close();
                                elsewhere_ = folder;
                              };
                            auto contents = read_contents(folder, earlier.get());
                            auto damaged = contents ? std::nullopt : find_damaged_project(folder);
                            auto overlay = contents && (!earlier || earlier->track != (*contents)->track)
                                               ? FaceOverlay::make(*contents)
                                               : nullptr;
                            return [this, folder, number, window, contents = std::move(contents),
                                    overlay = std::move(overlay), damaged = std::move(damaged)] {
                              if (folder != open_.folder || number != readings_)
                                return;  // another project was opened, or this one changed, meanwhile
                              loading_ = false;
                              if (!contents) {
                                context_.notices.fail(contents.error());
                                if (!open_.contents) close();
                                damaged_ = damaged;
                                // A damaged project stays on the list, to be repaired or deleted from there.
                                if (!damaged) std::erase(context_.settings.recent, folder);
                                return;
                              }
                              window_ = window;
                              if (overlay) overlay_ = overlay;
                              was_read(*contents);
                            };
                          });
}

void ProjectSession::was_read(std::shared_ptr<const ProjectContents> contents) {
  const bool first = open_.contents == nullptr;
  const ProjectContents earlier = first ? ProjectContents{} : *open_.contents;
  open_.contents = std::move(contents);
  const ProjectContents& now = *open_.contents;
  std::error_code ignored;
  const fs::path place = fs::absolute(open_.folder, ignored).lexically_normal();
  remember_recent(context_.settings, ignored ? open_.folder : place);
  if (first) {
    save_settings(context_);
    context_.shown.step = opening_step(now);
  }
  if (first || (now.clip && !earlier.clip)) read_clip_start(context_, clip_picture_);
  neighbours_.was_read({first, now.avatar && now.avatar != earlier.avatar});
  // A new clip is looked at before anything is built from it.
  if (!open_.look_only && !now.capture && !now.checked && now.clip &&
      now.project.consent != Consent::not_asked && !check_)
    check_clip();
  // Pictures of the steps, as soon as there are any.
  const auto middle = [](const FramePicture& picture, const auto& frames) {
    return picture.frame >= 0 ? picture.frame : frames[frames.size() / 2].frame;
  };
  if (now.capture && now.capture != earlier.capture && !now.capture->frames.empty())
    show_check_frame(middle(check_picture_, now.capture->frames));
  if (now.track && now.track != earlier.track && !now.track->frames.empty())
    show_face_frame(middle(face_picture_, now.track->frames));
}

void ProjectSession::close() {
  neighbours_.closing();
  context_.background.retire(std::move(run_));
  drop_check();
  solving_.reset();
  seen_states_ = {};
  seen_run_ = JobState::none;
  finish_at_s_.reset();
  refit_.reset();
  overlay_.reset();
  open_ = {};
  // Not before what still waits to be saved.
  if (window_)
    context_.background.run("", [window = std::exchange(window_, nullptr)](std::stop_token) mutable {
      window.reset();
      return Background::Delivery();
    });
  loading_ = false;
  context_.shown.step = Step::film;
  clip_picture_ = check_picture_ = face_picture_ = {};
  earlier_cameras_.clear(), later_cameras_.clear();
}

Project ProjectSession::latest() const {
  Project project = open_.contents->project;
  if (run_) project.stages = run_->status().records;
  return project;
}

// Changes the list of clips on the disk and reads it back. Until then no choice is written over it.
void ProjectSession::change_clips(const std::function<Result<std::string>(Project&)>& change) {
  if (!open_.contents || changing_clips_ || is_working() || neighbours_.are_working()) return;
  changing_clips_ = loading_ = true;
  context_.background.run(
      "clips", [this, change, project = latest()](std::stop_token) mutable -> Background::Delivery {
        const auto changed = change(project);
        return [this, folder = project.folder, changed] {
          changing_clips_ = loading_ = false;
          if (folder != open_.folder) return;
          if (!changed) return context_.notices.fail(changed.error());
          context_.notices.message = *changed;
          open_.pipeline = {};
          read(folder);
        };
      });
}

bool ProjectSession::edit_options(const std::function<void(ProjectOptions&)>& change) {
  if (!open_.contents || changing_clips_ || !open_.may_change()) return false;
  // What a command did to the project meanwhile is kept.
  auto changed = change_project(open_.folder, [&](Project& project) { change(project.options); });
  if (!changed) {
    context_.notices.fail(changed.error());
    return false;
  }
  auto contents = std::make_shared<ProjectContents>(*open_.contents);
  contents->project = std::move(*changed);
  open_.contents = std::move(contents);
  read(open_.folder);
  return true;
}

}  // namespace likeness::ui
