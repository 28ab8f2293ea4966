// See refits.h.
#include "core/project/refits.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/project/project_views.h"
#include "core/project/stage_inputs.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kRefitsVersion = 1;

// Bit for bit: undoing all spans restores the very file of before.
Result<void> copy_bits(const fs::path& from, const fs::path& to) {
  const auto bytes = read_file(from);
  if (!bytes) return bytes.error();
  return write_file(to, *bytes);
}

Result<void> remove_file(const fs::path& path) {
  std::error_code failure;
  fs::remove(path, failure);
  if (failure) return file_error(path, "remove", failure.value());
  return {};
}

// The re-fits of the first track that is kept, if it was made from these inputs.
std::optional<Refits> kept_refits(const Project& project, const std::string& fit_inputs) {
  auto kept = read_refits(project);
  if (!kept || kept->fit_inputs != fit_inputs || !path_exists(first_track_path(project))) return std::nullopt;
  return std::move(*kept);
}

}  // namespace

fs::path first_track_path(const Project& project) { return project.folder / "track_first.json"; }
fs::path refits_path(const Project& project) { return project.folder / "refits.json"; }

Result<Refits> read_refits(const Project& project) {
  const fs::path path = refits_path(project);
  const auto text = read_text(path);
  if (!text) return text.error();
  try {
    const json j = parse_json(*text);
    if (whole_number_in(j.at("version")) > kRefitsVersion)
      return Error{ErrorCode::bad_input, path.string() + " was made by a newer Likeness.", "Update Likeness.",
                   path.string()};
    Refits refits;
    refits.fit_inputs = j.at("fit_inputs");
    for (const json& s : j.at("spans")) {
      RefitOutcome& o = refits.outcomes.emplace_back();
      o.span = {whole_number_in(s.at("first")), whole_number_in(s.at("last"))};
      o.frames = whole_number_in(s.at("frames")), o.better = whole_number_in(s.at("better"));
      o.good = whole_number_in(s.at("good")), o.good_before = whole_number_in(s.at("good_before"));
    }
    return refits;
  } catch (const json::exception& e) {
    return Error{ErrorCode::bad_input, fmt::format("{} cannot be read: {}.", path.string(), e.what()),
                 "Delete this file: the fit then starts from the whole clip again.", path.string()};
  }
}

Result<void> write_refits(const Project& project, const Refits& refits) {
  json spans = json::array();
  for (const RefitOutcome& o : refits.outcomes)
    spans.push_back({{"first", o.span.first},
                     {"last", o.span.last},
                     {"frames", o.frames},
                     {"better", o.better},
                     {"good", o.good},
                     {"good_before", o.good_before}});
  return write_text(
      refits_path(project),
      json_text(json{{"version", kRefitsVersion}, {"fit_inputs", refits.fit_inputs}, {"spans", spans}}, 1) +
          "\n");
}

const RefitOutcome* find_refit(const std::vector<RefitOutcome>& outcomes, int frame) {
  const auto own = std::ranges::find_if(
      outcomes, [&](const RefitOutcome& o) { return o.span.first <= frame && frame <= o.span.last; });
  return own == outcomes.end() ? nullptr : &*own;
}

std::string refits_words(const std::vector<RefitOutcome>& outcomes) {
  constexpr std::size_t kFew = 3;
  std::string words;
  if (outcomes.size() <= kFew) {
    for (const RefitOutcome& o : outcomes) {
      if (!words.empty()) words.append(" ");
      words.append(refit_words(o));
    }
    return words;
  }
  int frames = 0, better = 0, good = 0, before = 0;
  for (const RefitOutcome& o : outcomes)
    frames += o.frames, better += o.better, good += o.good, before += o.good_before;
  return fmt::format("{} spans fitted again: {} of {} frames lie better, {} are good (before {}).",
                     outcomes.size(), better, frames, good, before);
}

Result<void> check_project_refits(const Project& project, const std::vector<RefitSpan>& spans) {
  // A re-fit that was stopped left the first track.
  const bool fitted =
      project.record(Stage::fit).state == StageState::done || path_exists(first_track_path(project));
  if (!fitted || !path_exists(track_path(project)))
    return Error{ErrorCode::not_found, "This project is not fitted yet.",
                 fmt::format("Fit the whole clip first: likeness fit {}", project.folder.string()),
                 project.folder.string()};
  const auto track = read_track(track_path(project));
  if (!track) return track.error();
  return check_refits(*track, spans);
}

Result<void> forget_refits(const Project& project) {
  for (const fs::path& file : {refits_path(project), first_track_path(project)})
    if (const auto removed = remove_file(file); !removed) return removed.error();
  return {};
}

Result<std::optional<Track>> first_track(const Project& project, const RefitWork& work) {
  const bool kept = kept_refits(project, work.fit_inputs).has_value();
  if (!kept && !work.fitted) return std::optional<Track>();
  auto track = read_track(kept ? first_track_path(project) : track_path(project));
  // Damaged: the whole clip again.
  if (!track || !check_track_fits(*track, work.model)) return std::optional<Track>();
  return std::optional<Track>(std::move(*track));
}

Result<Track> apply_refits(const Project& project, const RefitWork& work, const Track& first,
                           std::vector<RefitOutcome>& outcomes, std::vector<std::string>& warnings,
                           const Progress& progress, std::stop_token stop) {
  const FitInputs inputs = stage_inputs(project.options).fit;
  const fs::path first_path = first_track_path(project), path = track_path(project);
  std::vector<RefitSpan> spans;
  for (const RefitSpan& span : inputs.choices.refits) {
    if (const auto fine = check_refits(first, {span}); fine)
      spans.push_back(span);
    else
      warnings.push_back("Not fitted again: " + fine.error().what);
  }
  auto kept = kept_refits(project, work.fit_inputs);
  if (spans.empty()) {
    // A track just made is in no file yet; if re-fits are undone, the first track is restored to the bit.
    const auto written = kept          ? copy_bits(first_path, path)
                         : work.fitted ? Result<void>()
                                       : write_track(path, first);
    if (!written) return written.error();
    if (const auto forgotten = forget_refits(project); !forgotten) return forgotten.error();
    progress.report(1);
    return first;
  }
  if (!kept) {
    if (const auto written = work.fitted ? copy_bits(path, first_path) : write_track(first_path, first);
        !written)
      return written.error();
    kept = Refits{work.fit_inputs, {}};
  }
  // What is no longer asked for is forgotten before the track changes: a kill in between only costs the time
  // of a span.
  std::erase_if(kept->outcomes,
                [&](const RefitOutcome& o) { return std::ranges::find(spans, o.span) == spans.end(); });
  if (const auto written = write_refits(project, *kept); !written) return written.error();
  const auto current = kept->outcomes.empty() ? Result<Track>(first) : read_track(path);
  Track track = first;
  for (std::size_t i = 0; i < spans.size(); ++i) {
    const RefitSpan& span = spans[i];
    const auto known = std::ranges::find(kept->outcomes, span, &RefitOutcome::span);
    if (known != kept->outcomes.end() && current) {
      std::vector<TrackedFrame> frames;
      for (const TrackedFrame& frame : current->frames)
        if (span.first <= frame.frame && frame.frame <= span.last) frames.push_back(frame);
      put_frames(frames, track);
      outcomes.push_back(*known);
      continue;
    }
    const PixelRect part = tracked_part(work.capture);
    const TrackRegion region{part.x, part.y, part.width, part.height};
    RefitOptions options;
    options.track = work.options;
    auto refit = refit_span(inputs.video, region, work.cameras, silent_frames(work.capture), work.model,
                            first, span, options,
                            progress.stage(double(i) / double(spans.size()),
                                           double(i + 1) / double(spans.size()), "fitting a span again"),
                            stop);
    if (!refit) return refit.error();
    put_frames(refit->frames, track);
    outcomes.push_back(refit->outcome);
  }
  if (const auto written = write_track(path, track); !written) return written.error();
  if (const auto written = write_refits(project, {work.fit_inputs, outcomes}); !written)
    return written.error();
  progress.report(1);
  return track;
}

}  // namespace likeness
