// A stretch of a tracked clip fitted again, in seconds: where the net does not lie on the face between frames
// in which it does - a wrong jump, a hand, a reflection, frames lost between good ones.
//
// From the nearest frames outside that lie well (anchors) the head is followed into the span, forward and
// backward: by points on it to the next picture, and there by the landmark predictor, asked without the
// detector, and by how the good frames around say that the face looks. Where both ways meet, each frame is
// fitted once more between them. It keeps what it had unless the new state is judged better (judge_frame), or
// equal and nearer to its landmarks and the picture.
//
// Identity, neutral and torso stay as they are: the span's frames only learn from the rest. A training frame
// learns from training frames alone. A held-out frame learns from itself and from what came before it - it is
// followed forward only - and no training frame learns from it.
#pragma once

#include <filesystem>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/scene/track.h"
#include "core/track/clip/refit_options.h"
#include "core/track/track_options.h"

namespace likeness {

// Ascending; those that overlap or touch are one.
std::vector<RefitSpan> merged_spans(std::vector<RefitSpan> spans);

inline constexpr int kLongestRefit = 600;  // frames; more is a fit of the clip

// Whether these spans of the track can be fitted again: inside the clip, and not too long.
Result<void> check_refits(const Track& track, const std::vector<RefitSpan>& spans);

// What became of a span.
struct RefitOutcome {
  RefitSpan span;
  int frames = 0;  // of the track in it
  int better = 0;  // that changed; the others keep what they had
  int good = 0;    // afterwards
  int good_before = 0;
  bool operator==(const RefitOutcome&) const = default;
};

// "Frames 190 to 204 fitted again: 12 of 15 lie better, 9 are good (before 1)."
std::string refit_words(const RefitOutcome& outcome);

struct Refit {
  RefitOutcome outcome;
  std::vector<TrackedFrame> frames;  // the span's, all of them; torso poses as they were
};

// track: of this clip, as it was first fitted; region, cameras, held_out: as it was fitted with. Reads the
// clip up to the end of the margin. Where nothing near the span lies well, all frames keep what they had.
// Errors: a span that check_refits refuses, a model that is not the track's, a clip or landmark model that
// cannot be read, a stop. Repeats bit for bit, on any number of threads.
Result<Refit> refit_span(const std::filesystem::path& video, const TrackRegion& region,
                         const CameraSet& cameras, const std::set<int>& held_out, const HeadModel& model,
                         const Track& track, const RefitSpan& span, const RefitOptions& options,
                         const Progress& progress, std::stop_token stop);

// The span's frames put in the place of those the track has.
void put_frames(const std::vector<TrackedFrame>& frames, Track& track);

}  // namespace likeness
