// The studio as the panels see it: see studio.h.
#include "ui/studio/studio.h"

#include <algorithm>
#include <functional>

#include "core/base/memory.h"
#include "core/base/parallel.h"

namespace likeness::ui {

namespace fs = std::filesystem;

Snapshot Studio::snapshot() const {
  Snapshot s;
  s.loading = loading_ && !open_.contents;
  s.contents = open_.contents;
  s.damaged = damaged_;
  s.pipeline = open_.pipeline;
  if (demo_) s.demo = demo_->status();
  s.exporting = exports_.status();
  s.exports = exports_.items();
  if (check_) s.checking = check_->status();
  s.solving = solving_;
  s.verdict = verdict_;
  s.exported = exports_.last_written();
  s.steps = view_steps(open_.contents.get(), s.loading, s.pipeline, s.exporting, s.exported);
  add_verdict(s.checking, s.verdict.get(), s.steps[std::size_t(Step::check)]);
  if (!open_.pipeline.curve.training.empty()) {
    s.curve = open_.pipeline.curve;
  } else if (open_.contents && open_.contents->curve) {
    s.curve = *open_.contents->curve;
  }
  s.study = study_view();
  s.deleting = deleting_;
  s.shown = shown_.step;
  s.export_choice = export_choice_;
  s.settings = settings_;
  s.directing = directing_.view();
  if (open_.contents && open_.contents->avatar) {
    const ProjectAvatar& avatar = *open_.contents->avatar;
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
  s.masks = masks_view();
  s.mask_picture = mask_picture_;
  s.system.threads = current_thread_limit();
  s.system.memory = memory_in_use();
  s.system.available = available_memory().value_or(0);
  if (renderer_.on_device()) s.system.backend = "GPU";
  s.error = notices_.error;
  s.message = notices_.message;

  Situation& now = s.situation;
  now.project = open_.contents != nullptr;
  now.clip_there = open_.contents && (open_.contents->clip || open_.contents->capture);
  now.clip_missing = open_.contents && !open_.contents->clip;
  now.damaged = !open_.contents && damaged_;
  now.repairable = now.damaged && !damaged_->newer;
  now.running = open_.is_running() || ui::is_working(s.demo);
  now.paused = (open_.is_running() && open_.pipeline.job.paused) || (ui::is_working(s.demo) && s.demo.paused);
  now.training =
      open_.is_running() && open_.pipeline.stage == Stage::train && !open_.pipeline.training.empty();
  now.finished = open_.contents && std::ranges::all_of(open_.contents->current, std::identity{}) &&
                 std::ranges::none_of(open_.contents->stale, std::identity{});
  now.avatar = open_.contents && open_.contents->avatar;
  now.exporting = exports_.is_working();
  now.checking = ui::is_working(s.checking);
  now.can_check = open_.contents && open_.contents->clip;
  now.directing = shown_.step == Step::direct;
  now.masking = masking();
  now.can_undo = now.masking ? s.masks.can_undo : !s.directing.undo_name.empty();
  now.can_redo = now.masking ? s.masks.can_redo : !s.directing.redo_name.empty();
  now.keys = !s.directing.performance->channels.empty();
  now.keys_chosen = !s.directing.selected->empty();
  now.keys_copied = s.directing.keys_copied;
  now.pose_copied = s.directing.pose_copied;
  now.driven = s.live.on;
  now.consent = open_.contents && open_.contents->project.consent != Consent::not_asked;
  now.studying = studies();
  now.can_study = open_.contents && s.study.missing.empty() && !s.study.choice.tables.empty();
  now.studied = studied_ != nullptr;
  if (recorder_) {
    s.recorder = recorder_->status();
    // What lies behind the camera's page can neither be seen nor changed meanwhile.
    now = {.exporting = now.exporting,
           .studying = now.studying,
           .recorder = true,
           .camera_ready = s.recorder->state == RecorderState::watching,
           .recording = is_recording(*s.recorder),
           .can_stop_recording = s.recorder->state == RecorderState::recording};
  }
  return s;
}

}  // namespace likeness::ui
