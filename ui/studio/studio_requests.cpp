// What the user asks for, handed to what carries it out: see studio.h.
#include "ui/studio/studio.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/files.h"
#include "core/project/care.h"
#include "core/project/further_clips.h"
#include "ui/platform/show_folder.h"
#include "ui/studio/diagnostics.h"
#include "ui/studio/same_place.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

void choose_budget(ProjectOptions& options, double budget_s) {
  options.budget_s = budget_s, options.full_budget_s = 0, options.steps = 0;
}

}  // namespace

WindowRequest Studio::apply(const Requests& requests) {
  if (requests.dismiss_error) notices_.error.reset(), damaged_.reset();
  if (requests.dismiss_message) notices_.message.clear();
  if (requests.open) open(*requests.open);
  if (requests.webcam && recorder_) recorder_->choose(*requests.webcam);
  if (requests.forget_recent) std::erase(settings_.recent, *requests.forget_recent);
  if (requests.show) {
    shown_.step = *requests.show;
    study_open_ = false;
    shown_.follow = open_.pipeline.stage.has_value() && shown_.step == Step::train;
  }
  if (requests.consent && open_.contents) {
    // The folder's own file is written at once, and read back.
    const auto answered =
        change_project(open_.folder, [&](Project& project) { project.consent = *requests.consent; });
    if (!answered) notices_.fail(answered.error());
    load(open_.folder);
  }
  if (requests.nobody_agreed && open_.contents) {
    // A project that holds nothing but the question goes; the clip itself stays where it is.
    const fs::path folder = open_.folder;
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
    notices_.message = "Without the person's agreement no avatar is made.";
  }
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
  if (requests.left_out && open_.contents && open_.contents->capture) {
    if (const auto fine = check_left_out(*open_.contents->capture, *requests.left_out); !fine) {
      notices_.fail(fine.error());
    } else {
      edit_options([&](ProjectOptions& o) {
        o.left_out = *requests.left_out;
        restore_budget(o);
      });
    }
  }
  if (requests.refit) refit(*requests.refit, true);
  if (requests.take_back) refit(*requests.take_back, false);
  if (requests.check_frame) show_frame(&Studio::check_picture_, *requests.check_frame, false);
  if (requests.face_frame) show_frame(&Studio::face_picture_, *requests.face_frame, true);
  if (requests.compare_frame) {
    show_frame(&Studio::compare_picture_, *requests.compare_frame, false);
    request_picture();
  }
  apply(requests.masks);
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
      notices_.fail({ErrorCode::failed, "Nothing is exported while the avatar is being made.",
                     "Pause or stop that first, or wait for its end.", ""});
    }
  }
  if (requests.forget_export) exports_.forget(*requests.forget_export);
  if (requests.budget_s) edit_options([&](ProjectOptions& o) { choose_budget(o, *requests.budget_s); });
  if (requests.picture_size)
    edit_options([&](ProjectOptions& o) {
      o.size = *requests.picture_size;
      restore_budget(o);
    });
  if (requests.study_choice && !studies()) {
    study_choice_ = *requests.study_choice;
    forecast_the_study();
  }
  if (requests.close_study) open_study(false);
  WindowRequest wanted = WindowRequest::none;
  for (const Command command : requests.commands) {
    if (!is_enabled(command, snapshot().situation)) continue;
    if (const WindowRequest w = carry_out(command); w != WindowRequest::none) wanted = w;
  }
  return wanted;
}

WindowRequest Studio::carry_out(Command command) {
  const auto show = [&](int by) {
    study_open_ = false;
    shown_.step = kSteps[std::size_t(std::clamp(int(shown_.step) + by, 0, int(kSteps.size()) - 1))];
    shown_.follow = false;
  };
  const auto rescale = [&](int by) {
    settings_.scale_percent = std::clamp(settings_.scale_percent + by, kLeastScale, kMostScale);
  };
  switch (command) {
    case Command::open_clip:
      return WindowRequest::pick_clip;
    case Command::record_clip:
      start_recorder();
      break;
    case Command::start_recording:
      if (recorder_) recorder_->record();
      break;
    case Command::stop_recording:
      if (recorder_) recorder_->finish();
      break;
    case Command::discard_recording:
      if (recorder_) recorder_->discard();
      break;
    case Command::leave_recorder:
      leave_recorder();
      break;
    case Command::open_project:
      return WindowRequest::pick_project;
    case Command::add_clip:
      return WindowRequest::pick_further_clip;
    case Command::quit:
      return WindowRequest::quit;
    case Command::film_guide:
      return WindowRequest::film_guide;
    case Command::shortcuts:
      return WindowRequest::shortcuts;
    case Command::licences:
      return WindowRequest::licences;
    case Command::find_clip:
      return WindowRequest::find_clip;
    case Command::delete_person:
      return WindowRequest::delete_person;
    case Command::try_demo:
      start_demo();
      break;
    case Command::repair_project:
      repair();
      break;
    case Command::close_project:
      close_project();
      break;
    case Command::compare_methods:
      open_study(true);
      break;
    case Command::start_study:
      if (!study_open_) open_study(true);
      start_study();
      break;
    case Command::stop_study:
      study_->stop();
      break;
    case Command::show_study:
      show_study();
      break;
    case Command::make_avatar:
      shown_.follow = true;
      start_pipeline(restore_budget);  // what is not finished starts anew
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
      finish_at_s_ = open_.pipeline.training.back().seconds;
      pipeline_job_->stop();
      break;
    case Command::train_longer: {
      shown_.follow = true;
      shown_.step = Step::train;
      start_pipeline([&](ProjectOptions& o) {
        const double spent =
            open_.contents->avatar ? open_.contents->avatar->avatar.train_seconds : o.budget_s;
        choose_budget(o, std::max(1.0, std::round(spent)) + options_.longer_s);
      });
      break;
    }
    case Command::undo:
    case Command::redo:
    case Command::previous_picture:
    case Command::next_picture:
      if (!masking()) return direct(command);
      correct(command);
      break;
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
      if (comparing_ && compare_picture_.frame < 0 && open_.contents)
        if (const auto frames = shown_frames(*open_.contents, false); !frames.empty())
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
    case Command::show_exports:
      if (const auto shown = show_folder(open_.contents->project.folder / "exports"); !shown)
        notices_.fail(shown.error());
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
  return WindowRequest::none;
}

void Studio::save_diagnostics() {
  const fs::path out = (open_.folder.empty() ? options_.projects : open_.folder) / "diagnostics.txt";
  if (const auto written = write_text(out, diagnostics_text(notices_.error, open_.contents.get()));
      !written) {
    notices_.fail(written.error());
  } else {
    notices_.message = "Written: " + out.string() + ". It holds no picture.";
  }
}

}  // namespace likeness::ui
