// Tracking a clip once per step: see track_study.h.
#include "core/lab/truth/track_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/video/decode.h"

namespace likeness {
namespace {

constexpr double kHeldOutShare = 0.1;  // as import holds out

// The tracker's steps, each with its switch, in the order in which they are added; a new one is one more
// line.
struct StepSwitch {
  const char* name;
  void (*set)(TrackOptions&, bool on);
};
constexpr StepSwitch kSwitches[] = {
    {"landmarks", [](TrackOptions&, bool) {}},
    {"dense", [](TrackOptions& options, bool on) { options.dense = on; }},
    {"photometric", [](TrackOptions& options, bool on) { options.photometric = on; }},
    {"shape", [](TrackOptions& options, bool on) { options.own_shape = on; }},
};

struct TimedTrack {
  Track track;
  double seconds = 0;
};

Result<TimedTrack> track_timed(const StudyClip& clip, const TrackStep& step,
                               const std::filesystem::path& tracks, const Progress& progress,
                               std::stop_token stop) {
  const auto start = std::chrono::steady_clock::now();
  auto track = track_clip(clip.video, clip.region, clip.cameras, clip.held_out, clip.model, step.options,
                          progress, stop);
  if (!track) return track.error();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!tracks.empty()) {
    if (const auto written = write_track(tracks / (step.name + ".track.json"), *track); !written)
      return written.error();
  }
  return TimedTrack{std::move(*track), seconds};
}

}  // namespace

const std::vector<std::string>& track_step_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const StepSwitch& s : kSwitches) all.emplace_back(s.name);
    return all;
  }();
  return names;
}

Result<std::vector<TrackStep>> track_steps(const std::vector<std::string>& names, const TrackOptions& base) {
  std::vector<TrackStep> steps;
  for (const std::string& name : names.empty() ? track_step_names() : names) {
    const auto last = std::ranges::find(track_step_names(), name);
    if (last == track_step_names().end()) {
      return Error{ErrorCode::bad_input, fmt::format("The tracker has no step named \"{}\".", name),
                   fmt::format("Choose from: {}.", fmt::join(track_step_names(), ", ")), ""};
    }
    TrackStep step{name, base};
    for (const StepSwitch& s : kSwitches)
      s.set(step.options, &s - kSwitches <= last - track_step_names().begin());
    steps.push_back(std::move(step));
  }
  return steps;
}

Result<std::vector<TruthRow>> study_against_truth(const std::filesystem::path& demo, const HeadModel& model,
                                                  const std::vector<TrackStep>& steps,
                                                  const std::filesystem::path& tracks,
                                                  const Progress& progress, std::stop_token stop) {
  const auto truth = read_track_truth(demo);
  if (!truth) return truth.error();
  StudyClip clip{demo / "demo.mp4", {}, truth->cameras, {}, model};
  const int count = int(truth->track.frames.size());
  for (int i = count - int(std::lround(kHeldOutShare * count)); i < count; ++i)
    clip.held_out.insert(truth->track.frames[std::size_t(i)].frame);
  std::vector<TruthRow> rows;
  for (const TrackStep& step : steps) {
    const double from = double(rows.size()) / double(steps.size());
    const auto timed = track_timed(clip, step, tracks,
                                   progress.stage(from, from + 1.0 / double(steps.size()), step.name), stop);
    if (!timed) return timed.error();
    const auto comparison = compare_with_truth(timed->track, model, *truth, clip.held_out);
    if (!comparison) return comparison.error();
    rows.push_back({step.name, *comparison, timed->seconds,
                    double(timed->track.frames.size()) / std::max(timed->seconds, 1e-9)});
  }
  return rows;
}

Result<std::vector<CheckRow>> study_real_clip(const StudyClip& clip, const std::vector<TrackStep>& steps,
                                              const std::filesystem::path& tracks, const Progress& progress,
                                              std::stop_token stop) {
  std::vector<CheckRow> rows;
  std::vector<Track> found;
  std::shared_ptr<WithheldPoints> withheld;
  for (TrackStep step : steps) {
    const double from = double(rows.size()) / double(steps.size()), share = 1.0 / double(steps.size());
    step.options.withheld = std::make_shared<WithheldPoints>();
    auto timed = track_timed(clip, step, tracks, progress.stage(from, from + 0.85 * share, step.name), stop);
    if (!timed) return timed.error();
    if (!step.options.withheld->tracks.empty()) withheld = step.options.withheld;
    CheckRow row;
    row.step = step.name;
    row.seconds = timed->seconds;
    row.frames = int(timed->track.frames.size());
    row.frames_per_second = row.frames / std::max(timed->seconds, 1e-9);
    for (const TrackedFrame& frame : timed->track.frames) {
      row.good += frame.status == FrameStatus::good;
      row.weak += frame.status == FrameStatus::weak;
      row.lost += frame.status == FrameStatus::lost;
      if (frame.status != FrameStatus::lost) row.inner_error_px += frame.inner_error_px;
    }
    row.inner_error_px /= std::max(1, row.good + row.weak);
    const auto projected =
        project_track(timed->track, clip.model, clip.cameras, clip.region, step.options.working_size);
    row.stillness = measure_stillness(projected);
    const auto fresh =
        find_fresh_landmarks(clip.video, timed->track, projected, clip.region, step.options,
                             progress.stage(from + 0.85 * share, from + share, "fresh landmarks"), stop);
    if (!fresh) return fresh.error();
    row.fresh = *fresh;
    row.marks = score_marks(timed->track, clip.model, clip.marks);
    rows.push_back(std::move(row));
    found.push_back(std::move(timed->track));
  }
  for (std::size_t i = 0; withheld && i < rows.size(); ++i)
    rows[i].withheld = score_withheld(*withheld, found[i], clip.cameras);
  return rows;
}

}  // namespace likeness
