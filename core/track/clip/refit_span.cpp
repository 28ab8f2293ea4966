// See refit_span.h.
#include "core/track/clip/refit_span.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>

#include "core/base/quantile.h"
#include "core/track/clip/span_fitter.h"

namespace likeness {
namespace {

std::string span_name(const RefitSpan& span) {
  return span.first == span.last ? fmt::format("frame {}", span.first)
                                 : fmt::format("frames {} to {}", span.first, span.last);
}

bool is_in(const RefitSpan& span, int frame) { return frame >= span.first && frame <= span.last; }

// The clip's median inner error, source px, of training frames; it says what error is usual here.
double usual_error(const Track& track, const std::set<int>& held_out) {
  std::vector<double> errors;
  for (const TrackedFrame& f : track.frames)
    if (f.status != FrameStatus::lost && !held_out.contains(f.frame)) errors.push_back(f.inner_error_px);
  return median(std::move(errors));
}

// The parts of a span in the shots of a film: each is fitted by itself.
std::vector<RefitSpan> parts_of(const RefitSpan& span, const std::vector<FrameSpan>& shots) {
  if (shots.empty()) return {span};
  std::vector<RefitSpan> parts;
  for (const FrameSpan& shot : shots)
    if (const RefitSpan part{std::max(span.first, shot.first), std::min(span.last, shot.last)};
        part.first <= part.last)
      parts.push_back(part);
  return parts;
}

// What of the clip is to be read: to the nearest good frame on either side and a margin beyond, in the same
// shot. Nothing is read after a span of held-out frames.
RefitSpan window_of(const Track& track, const std::set<int>& held_out, const RefitSpan& span,
                    const RefitOptions& options) {
  const auto& frames = track.frames;
  std::ptrdiff_t first = 0, last = 0;
  bool training = false;
  for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(frames.size()); ++i) {
    if (frames[std::size_t(i)].frame < span.first) first = i + 1;
    if (frames[std::size_t(i)].frame <= span.last) last = i;
    training |= is_in(span, frames[std::size_t(i)].frame) && !held_out.contains(frames[std::size_t(i)].frame);
  }
  const auto reached = [&](std::ptrdiff_t from, int step) {
    std::ptrdiff_t i = from;
    for (int away = 0; away < options.reach && i + step >= 0 && i + step < std::ptrdiff_t(frames.size());
         ++away) {
      i += step;
      const TrackedFrame& f = frames[std::size_t(i)];
      if (f.status == FrameStatus::good && !held_out.contains(f.frame)) break;
    }
    return std::clamp<std::ptrdiff_t>(i + step * options.margin, 0, std::ptrdiff_t(frames.size()) - 1);
  };
  RefitSpan window{frames[std::size_t(reached(first, -1))].frame,
                   frames[std::size_t(training ? reached(last, 1) : last)].frame};
  for (const FrameSpan& shot : options.track.shots)
    if (span.first >= shot.first && span.first <= shot.last)
      window = {std::max(window.first, shot.first), std::min(window.last, shot.last)};
  return window;
}

}  // namespace

std::vector<RefitSpan> merged_spans(std::vector<RefitSpan> spans) {
  std::ranges::sort(spans, {}, &RefitSpan::first);
  std::vector<RefitSpan> merged;
  for (const RefitSpan& span : spans) {
    if (!merged.empty() && span.first - 1 <= merged.back().last)
      merged.back().last = std::max(merged.back().last, span.last);
    else
      merged.push_back(span);
  }
  return merged;
}

Result<void> check_refits(const Track& track, const std::vector<RefitSpan>& spans) {
  if (track.frames.empty())
    return Error{ErrorCode::bad_input, "The track has no frame.", "Run the fit of the whole clip first.", ""};
  const int first = track.frames.front().frame, last = track.frames.back().frame;
  for (const RefitSpan& span : spans) {
    const auto inside =
        std::ranges::count_if(track.frames, [&](const TrackedFrame& f) { return is_in(span, f.frame); });
    if (span.first > span.last || span.first < first || span.last > last || inside == 0)
      return Error{ErrorCode::bad_input, fmt::format("The clip has no {}.", span_name(span)),
                   fmt::format("Its frames are {} to {}.", first, last), ""};
    if (parts_of(span, track.shots).empty())
      return Error{ErrorCode::bad_input,
                   fmt::format("The part of the film with {} is left out: it shows another place, angle or "
                               "crop, or no face.",
                               span_name(span)),
                   "Mark frames of the shots that serve.", ""};
    if (inside > kLongestRefit)
      return Error{ErrorCode::bad_input,
                   fmt::format("A span of {} frames is too long to be fitted again by itself.", inside),
                   fmt::format("Mark the bad stretches in it, at most {} frames each.", kLongestRefit), ""};
  }
  return {};
}

std::string refit_words(const RefitOutcome& o) {
  std::string name = span_name(o.span);
  name[0] = 'F';
  if (o.better == 0)
    return fmt::format("{} fitted again: nothing lies better, so {} what {} had.", name,
                       o.frames == 1 ? "it keeps" : "all keep", o.frames == 1 ? "it" : "they");
  if (o.frames == 1) return fmt::format("{} fitted again: it lies better.", name);
  return fmt::format("{} fitted again: {} of {} lie{} better, {} {} good (before {}).", name, o.better,
                     o.frames, o.better == 1 ? "s" : "", o.good, o.good == 1 ? "is" : "are", o.good_before);
}

Result<Refit> refit_span(const std::filesystem::path& video, const TrackRegion& region,
                         const CameraSet& cameras, const std::set<int>& held_out, const HeadModel& model,
                         const Track& track, const RefitSpan& span, const RefitOptions& options,
                         const Progress& progress, std::stop_token stop) {
  if (const auto fine = check_refits(track, {span}); !fine) return fine.error();
  if (track.head_model_hash != model.hash || track.neutral.expression.size() != model.expression_count())
    return Error{ErrorCode::bad_input,
                 fmt::format("The track was made with the {} head model, not with the {} one.",
                             track.head_model_name, model.name),
                 "Fit the whole clip again with this model.", "re-fit"};
  if (stop.stop_requested()) return cancelled_error();
  const std::vector<RefitSpan> parts = parts_of(span, options.track.shots);
  std::vector<SpanFrame> fitted;
  try {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Progress part =
          progress.stage(double(i) / double(parts.size()), double(i + 1) / double(parts.size()), "span");
      const RefitSpan window = window_of(track, held_out, parts[i], options);
      auto clip = read_grey_frames(video, region, held_out, options.track, window.first, window.last,
                                   part.stage(0, 0.3, "pictures"), stop);
      if (!clip) return clip.error();
      auto detector = FaceDetector::load(options.track.predictor);
      if (!detector) return detector.error();
      const double usual_px = usual_error(track, held_out) * clip->scale;
      SpanFitter fitter(model, track, options, std::move(*detector), usual_px);
      fitter.take(std::move(*clip), cameras, track, parts[i]);
      if (auto done = fitter.fit_training(part.stage(0.3, 0.8, "span"), stop); !done) return done.error();
      if (auto done = fitter.fit_held_out(part.stage(0.8, 1, "held out"), stop); !done) return done.error();
      fitter.bridge();
      for (const SpanFrame& frame : fitter.frames())
        if (is_in(parts[i], frame.tracked.frame)) fitted.push_back(frame);
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return Error{
        ErrorCode::failed, "Fitting the span again failed: " + std::string(e.what()),
        "Try it again with a span a little longer or shorter; if it fails again, report this message.",
        "re-fit"};
  }
  Refit refit;
  refit.outcome.span = span;
  for (const TrackedFrame& frame : track.frames) {
    if (!is_in(span, frame.frame)) continue;
    const auto own =
        std::ranges::find_if(fitted, [&](const SpanFrame& f) { return f.tracked.frame == frame.frame; });
    refit.frames.push_back(own == fitted.end() ? frame : own->tracked);
    ++refit.outcome.frames;
    refit.outcome.better += own != fitted.end() && own->changed;
    refit.outcome.good_before += frame.status == FrameStatus::good;
    refit.outcome.good += refit.frames.back().status == FrameStatus::good;
  }
  progress.report(1, "fitted again");
  return refit;
}

void put_frames(const std::vector<TrackedFrame>& frames, Track& track) {
  for (const TrackedFrame& frame : frames) {
    const auto own = std::ranges::lower_bound(track.frames, frame.frame, {}, &TrackedFrame::frame);
    if (own != track.frames.end() && own->frame == frame.frame) *own = frame;
  }
}

}  // namespace likeness
