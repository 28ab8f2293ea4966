// What the studio sets to work - stages, demo, check, exports - each in threads of its own: see studio.h.
#include "ui/studio/studio.h"

#include <fmt/format.h>

#include <utility>

#include "core/project/refits.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

// A name in exports/ that no file has and no waiting export takes.
fs::path export_path(const fs::path& folder, const ExportChoice& choice, const ExportQueue& queue) {
  for (int number = 1;; ++number) {
    const fs::path path = folder / "exports" / export_file_name(choice, number);
    std::error_code ignored;
    if (!fs::exists(path, ignored) && !queue.holds(path)) return path;
  }
}

}  // namespace

void Studio::start_pipeline(const std::function<void(ProjectOptions&)>& change, Stage last) {
  if (!open_.contents) return;
  save_strokes();  // that could not be written when they were painted, and those just painted
  if (!edit_options(change)) return;
  const Project& project = open_.contents->project;
  open_.pipeline = {};
  study_open_ = false;
  refit_.reset();
  seen_pipeline_ = JobState::none;
  seen_states_ = {};
  for (const Stage stage : kStages) seen_states_[std::size_t(stage)] = project.record(stage).state;
  background_.retire(std::move(pipeline_job_));
  pipeline_job_ = std::make_unique<PipelineJob>(project, last, options_.previews, wake_,
                                                background_.after_waiting(), options_.compute);
  open_.pipeline = pipeline_job_->status();
}

void Studio::refit(const RefitSpan& span, bool again) {
  if (!open_.contents || open_.is_running()) return;
  if (studies()) {
    notices_.fail({ErrorCode::failed, "Nothing is fitted again while other methods are compared.",
                   "Stop the comparison first, or wait for its end.", ""});
    return;
  }
  const auto with_span = [&](ProjectOptions& options) {
    if (again) {
      options.refits.push_back(span);
      options.refits = merged_spans(std::move(options.refits));
    } else {
      std::erase_if(options.refits, [&](const RefitSpan& other) {
        return other.first <= span.last && span.first <= other.last;
      });
    }
  };
  ProjectOptions known = open_.contents->project.options;
  with_span(known);
  if (const auto fine = again ? check_project_refits(latest_project(), known.refits) : Result<void>();
      !fine) {
    notices_.fail(fine.error());
    return;
  }
  shown_.follow = false;  // the Face step stays in sight
  start_pipeline(with_span, Stage::fit);
  refit_ = span;
}

// What became of the span that was asked for.
void Studio::tell_refit() {
  if (!refit_ || !open_.contents) return;
  const RefitSpan span = *refit_;
  refit_.reset();
  if (open_.pipeline.job.state != JobState::done) return;
  const auto refits = read_refits(open_.contents->project);
  const RefitOutcome* own = refits ? find_refit(refits->outcomes, span.first) : nullptr;
  if (!own) {
    notices_.message = "These frames are again as they were first fitted.";
  } else {
    notices_.message = refit_words(*own);
    if (own->better > 0) notices_.message.append(" Make the avatar again to use it.");
  }
}

// Looks again and again how far the cameras' solve has come.
void Studio::watch_solve() {
  constexpr auto kPause = std::chrono::seconds(1);
  if (open_.pipeline.stage != Stage::align) return solving_.reset();
  const auto now = std::chrono::steady_clock::now();
  if (now - solve_watched_ < kPause) return;
  solve_watched_ = now;
  background_.run("solve", [this, folder = open_.folder](std::stop_token) -> Background::Delivery {
    auto solving = read_solving_cameras(folder / "colmap");
    return [this, folder, solving = std::move(solving)]() mutable {
      if (solving && folder == open_.folder && open_.pipeline.stage == Stage::align)
        solving_ = std::move(solving);
    };
  });
}

void Studio::start_demo() {
  leave_recorder();
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
  background_.retire(std::move(check_));
}

void Studio::start_check() {
  drop_check();
  checked_ = std::make_shared<CaptureVerdict>();
  check_ = std::make_unique<Job>(
      [options = open_.contents->project.options, into = checked_](
          const Progress& progress, std::stop_token stop) -> Result<std::string> {
        const auto measures =
            measure_clip(options.video, options.landmark_model, progress.stage(0, 1, "check"), stop);
        if (!measures) return measures.error();
        *into = judge_capture(*measures);
        return std::string(verdict_words(into->verdict));
      },
      wake_);
}

void Studio::start_export(ExportKind kind) {
  if (!open_.contents || !open_.contents->avatar) return;
  export_choice_.kind = kind;
  const ProjectAvatar& avatar = *open_.contents->avatar;
  const double time_s = directing_.playhead_s();
  const ViewPoint view = direct_moment(avatar.directed, *directing_.performance(), time_s).view;
  const ExportChoice choice = settled(export_choice_, view, avatar.avatar);
  ExportOrder order{choice,
                    open_.contents,
                    directing_.performance(),
                    time_s,
                    export_path(open_.folder, choice, exports_),
                    options_.compute.open,
                    drive_.gains()};
  if (const auto fine = check_order(order); !fine) {
    notices_.fail(fine.error());
    return;
  }
  const fs::path out = order.out;
  exports_.add(out, [order = std::move(order)](const Progress& progress, std::stop_token stop) {
    return write_order(order, progress.stage(0, 1, "export"), stop);
  });
}

}  // namespace likeness::ui
