// The import of a project's clip: see stage_run.h.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/kept_work.h"
#include "core/capture/capture.h"
#include "core/capture/head_views.h"
#include "core/capture/split.h"
#include "core/face/landmarks.h"
#include "core/project/corrections.h"
#include "core/project/further_clips.h"
#include "core/project/kept_decoding.h"
#include "core/project/project_attributes.h"
#include "core/project/stage_run.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// The evaluation regions are frozen once per clip: those of another clip do not apply to this one.
Result<void> drop_foreign_regions(const Project& project, const Capture& capture) {
  const auto before = read_capture(capture_path(project));
  if (before && before->video_hash == capture.video_hash) return {};
  std::error_code failure;
  fs::remove_all(regions_path(project), failure);
  if (failure) return file_error(regions_path(project), "remove", failure.value());
  return {};
}

// Strokes on another clip's masks and faces do not apply to this one's; being the user's work, they are set
// aside, not removed.
Result<void> part_from_foreign_clip(Project& project, const Capture& capture,
                                    std::vector<std::string>& warnings) {
  const auto before = read_capture(capture_path(project));
  if (!before || before->video_hash == capture.video_hash) return {};
  // Nor does the answer about that clip's person.
  project.consent = Consent::not_asked;
  if (!project.further_clips.empty()) {
    project.further_clips.clear();
    warnings.push_back(
        "The further clips showed the previous person and were taken out; add clips of this person instead.");
  }
  if (path_exists(attributes_path(project))) {
    const auto aside = set_aside_attributes(project);
    if (!aside) return aside.error();
    warnings.push_back(
        fmt::format("The painted attributes belong to another clip; they are kept in {}.", aside->string()));
  }
  if (corrected_frames(project).empty()) return {};
  const auto kept = set_aside_corrections(project);
  if (!kept) return kept.error();
  warnings.push_back(
      fmt::format("The strokes on the masks belong to another clip; they are kept in {}.", kept->string()));
  return {};
}

// Of Split::sides, of which the other words do not say enough.
std::string sides_words(const Capture& capture) {
  int inside = 0, beyond = 0;
  for (const CaptureFrame& frame : capture.frames)
    if (frame.held_out) ++(angle_deg(*frame.view) <= capture.sides.inside_deg ? inside : beyond);
  const SideCounts counts = count_sides(capture.frames, capture.sides);
  return fmt::format(
      "The head is seen from up to {:.0f} degrees off its typical side: {} are held out within {:g} degrees, "
      "{} beyond {:g}; of the refused, {} are kept apart.",
      counts.widest_deg, inside, capture.sides.inside_deg, beyond, capture.sides.beyond_deg, counts.apart);
}

}  // namespace

Result<void> run_import(const StageContext& context) {
  const ImportInputs& inputs = context.inputs.import;
  ImportOptions options;
  options.size = inputs.choices.size;
  options.landmark_model = inputs.landmark_model;
  options.split = inputs.choices.split;
  options.sides = inputs.choices.sides;
  options.seconds = inputs.choices.seconds;
  // What is found in a picture depends on nothing else.
  options.kept_faces = std::make_shared<KeptWork>(
      decoded_path(context.project) / "import.kept",
      fmt::format("faces 1 {} {}", landmark_source_hash(inputs.landmark_model), inputs.video.string()));
  if (is_further(context.project)) options.held_out_share = 0;  // the first clip alone is measured
  KeptDecoding kept(context, options.kept_faces);
  const auto capture = import_clip(inputs.video, context.project.folder, options, kept.listeners(),
                                   context.progress, context.stop);
  if (!capture) {
    if (capture.error().code != ErrorCode::cancelled) options.kept_faces->finish();
    return capture.error();
  }
  kept.commit();
  options.kept_faces->finish();
  int used = 0, held_out = 0;
  for (const CaptureFrame& frame : capture->frames) used += frame.used, held_out += frame.held_out;
  context.record.message =
      fmt::format("{} frames: {} train, {} held out, {} refused.", capture->frames.size(), used, held_out,
                  int(capture->frames.size()) - used - held_out);
  if (capture->split == Split::sides) context.record.message += " " + sides_words(*capture);
  if (!capture->seconds.whole())
    context.record.message += fmt::format(" Read {}.", seconds_words(capture->seconds));
  context.record.warnings = capture->warnings;
  if (const auto dropped = drop_foreign_regions(context.project, *capture); !dropped) return dropped.error();
  if (const auto aside = part_from_foreign_clip(context.project, *capture, context.record.warnings); !aside)
    return aside.error();
  return write_capture(capture_path(context.project), *capture);
}

}  // namespace likeness
