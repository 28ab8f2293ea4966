// Spans of a project's track that were fitted again (core/track/clip/refit_span).
//
//   track_first.json  the track as the fit of the whole clip left it; absent where no span was fitted again
//   refits.json       from which inputs that was, and what became of each span
//
// Every span is fitted from the first track, so that the order of edits changes nothing and each can be taken
// back; track.json is the first track with the spans' frames put in.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/project/project.h"
#include "core/track/clip/refit_span.h"

namespace likeness {

struct Refits {
  std::string fit_inputs;              // hash of what the first track was made from
  std::vector<RefitOutcome> outcomes;  // ascending; of the spans that are in track.json
};

std::filesystem::path first_track_path(const Project& project);
std::filesystem::path refits_path(const Project& project);
Result<Refits> read_refits(const Project& project);
Result<void> write_refits(const Project& project, const Refits& refits);

// The outcome of the span in which the frame lies, or null.
const RefitOutcome* find_refit(const std::vector<RefitOutcome>& outcomes, int frame);

// What became of all of them: a sentence each where they are few.
std::string refits_words(const std::vector<RefitOutcome>& outcomes);

// Whether a span may be asked for: the project is fitted, and its track has the spans. The error says what to
// do otherwise.
Result<void> check_project_refits(const Project& project, const std::vector<RefitSpan>& spans);

// Removes the files above: another first track is there, or about to be.
Result<void> forget_refits(const Project& project);

// What the fit works with.
struct RefitWork {
  const Capture& capture;
  const CameraSet& cameras;
  const HeadModel& model;
  TrackOptions options;
  std::string fit_inputs;  // hash, without the spans
  bool fitted = false;     // track.json is the first track, made from these inputs
};

// The first track, where it is there already: nullopt where the whole clip is to be fitted.
Result<std::optional<Track>> first_track(const Project& project, const RefitWork& work);

// Brings track.json and the files above to what the project's options ask: from `first`, with each span that
// is not there yet fitted again. Spans the track does not have are left out and noted. A stop keeps the first
// track, and the spans that were there.
Result<Track> apply_refits(const Project& project, const RefitWork& work, const Track& first,
                           std::vector<RefitOutcome>& outcomes, std::vector<std::string>& warnings,
                           const Progress& progress, std::stop_token stop);

}  // namespace likeness
