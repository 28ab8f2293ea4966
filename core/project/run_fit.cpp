// The track of a project's clip: see stage_run.h.
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/kept_work.h"
#include "core/base/parallel.h"
#include "core/base/path_text.h"
#include "core/capture/capture.h"
#include "core/face/landmarks.h"
#include "core/head/read_person.h"
#include "core/project/further_clips.h"
#include "core/project/kept_decoding.h"
#include "core/project/project_detail.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/refits.h"
#include "core/project/stage_run.h"
#include "core/project/staleness.h"
#include "core/track/clip/track_clip.h"
#include "core/track/kept_frames.h"
#include "core/track/points/judge_scale.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// Whether track.json is the whole clip's fit from these inputs, without spans fitted again.
bool first_track_is_there(const StageContext& context, const HeadModel& model, const std::string& inputs) {
  if (!path_exists(track_path(context.project))) return false;
  if (context.before.track_inputs == inputs) return true;
  if (context.before.state == StageState::done && context.before.input_hash == inputs) return true;
  if (path_exists(refits_path(context.project))) return false;
  const auto detail = read_project_detail(context.project, model);
  return detail && *detail && (*detail)->track_inputs == inputs;
}

// Writes the project's detail.npz, or removes it if the options name no maps.
Result<void> keep_detail(const StageContext& context, const Capture& capture, const Track& track,
                         const HeadModel& model, const std::string& track_inputs) {
  const fs::path& maps = context.inputs.fit.choices.displacement;
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

// The person's shape if it is not fitted: the first clip's, or a given one.
Result<std::optional<PersonShape>> known_person(const StageContext& context, const HeadModel& model) {
  if (is_further(context.project)) {
    auto track = read_track(track_path({.folder = context.project.first_clip}));
    if (!track) return track.error();
    if (const auto fits = check_track_fits(*track, model); !fits) return fits.error();
    return std::optional<PersonShape>(std::move(track->person));
  }
  const fs::path& identity = context.inputs.fit.choices.identity;
  if (identity.empty()) return std::optional<PersonShape>{};
  auto person = read_person(identity, model);
  if (!person) return person.error();
  return std::optional<PersonShape>(std::move(*person));
}

// Threads: sums are as they add them. The numbers are raised when a part of the fit, or what is kept of it,
// changes.
std::shared_ptr<KeptWork> kept_fit_work(const Project& project, const FitInputs& inputs,
                                        const std::string& fit_inputs) {
  constexpr int kFitParts = 1;
  return std::make_shared<KeptWork>(
      decoded_path(project) / "fit.kept",
      fmt::format("fit {} {} {} {}", kFitParts, fit_inputs, landmark_source_hash(inputs.landmark_model),
                  current_thread_limit()));
}

// shots: of a film that was cut, those that serve; the rest of it is not looked at.
std::string track_words(const Track& track, const HeadModel& model, const std::vector<FrameSpan>& shots) {
  std::array<int, 3> count{};
  double error_px = 0;
  for (const TrackedFrame& frame : track.frames) {
    if (span_of(shots, frame.frame) < 0) continue;
    ++count[std::size_t(frame.status)];
    if (frame.status != FrameStatus::lost) error_px += frame.inner_error_px;
  }
  const int followed = count[0] + count[1];
  return fmt::format("{} head; {} frames good, {} weak, {} lost; landmarks {:.2f} px off on average.",
                     model.name, count[0], count[1], count[2], followed > 0 ? error_px / followed : 0.0);
}

}  // namespace

Result<void> run_fit(const StageContext& context) {
  const FitInputs& inputs = context.inputs.fit;
  const auto capture = read_capture(capture_path(context.project));
  if (!capture) return capture.error();
  const auto cameras = read_cameras(cameras_path(context.project));
  if (!cameras) return cameras.error();
  const auto model = head_model_at(inputs.head_model);
  if (!model) return model.error();
  RefitWork work{*capture, *cameras, *model, {}, first_track_hash(context.project)};
  work.options.predictor = inputs.landmark_model;
  work.options.shots = spans_where_cut(*capture);
  work.options.part = frames_of_seconds(*capture);
  work.options.kept = decoded_path(context.project);
  work.options.kept_work = kept_fit_work(context.project, inputs, work.fit_inputs);
  work.fitted = first_track_is_there(context, *model, work.fit_inputs);
  context.record.track_inputs = work.fitted ? work.fit_inputs : "";
  work.options.rest_frames = inputs.choices.rest_frames;
  auto person = known_person(context, *model);
  if (!person) return person.error();
  work.options.person = std::move(*person);
  auto first = first_track(context.project, work);
  if (!first) return first.error();
  Progress rest = context.progress;
  if (!*first) {
    work.fitted = false;
    const PixelRect part = tracked_part(*capture);
    const TrackRegion region{part.x, part.y, part.width, part.height};
    const bool again = !inputs.choices.refits.empty();
    auto whole = track_clip(inputs.video, region, *cameras, silent_frames(*capture), *model, work.options,
                            rest.stage(0, again ? 0.9 : 1, "fit"), context.stop);
    if (!whole) return whole.error();
    whole->head_model_file = text_of_path(inputs.head_model);
    if (const auto forgotten = forget_refits(context.project); !forgotten) return forgotten.error();
    *first = std::move(*whole);
    rest = rest.stage(0.9, 1, "spans");
  }
  std::vector<RefitOutcome> outcomes;
  auto track =
      apply_refits(context.project, work, **first, outcomes, context.record.warnings, rest, context.stop);
  if (!track) return track.error();
  context.record.track_inputs = inputs.choices.refits.empty() ? work.fit_inputs : "";
  if (!track->metre_known) {
    context.record.warnings.push_back(
        "The camera moved too little to give distances in metres; for a better avatar walk a wider arc "
        "round the head.");
  }
  if (const std::string doubt = scale_warning(*track, *cameras); !doubt.empty())
    context.record.warnings.push_back(doubt);
  if (!track->rest.warning.empty() && !is_further(context.project))
    context.record.warnings.push_back(track->rest.warning);
  drop_clip_frames(decoded_path(context.project));
  work.options.kept_work->finish();
  context.record.message = track_words(*track, *model, work.options.shots);
  if (work.options.person && !is_further(context.project))
    context.record.message +=
        fmt::format(" The person's shape is that of {}.", inputs.choices.identity.filename().string());
  if (!outcomes.empty()) context.record.message += " " + refits_words(outcomes);
  return keep_detail(context, *capture, *track, *model, work.fit_inputs);
}

}  // namespace likeness
