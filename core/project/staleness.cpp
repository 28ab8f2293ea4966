// What makes each stage stale: see staleness.h.
//
// The functions below bind all of a stage's inputs by name: a new input does not compile until it is named
// here.
#include "core/project/staleness.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/capture/capture.h"
#include "core/capture/split.h"
#include "core/face/landmarks.h"
#include "core/head/detail_maps.h"
#include "core/head/load_head_model.h"
#include "core/matte/matting_network.h"
#include "core/matte/person_network.h"
#include "core/project/corrections.h"
#include "core/project/further_clips.h"
#include "core/project/project_attributes.h"
#include "core/project/stage_inputs.h"
#include "core/project/stage_results.h"
#include "core/video/decode.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// Raised when a stage's method changes in such a way that old results should be made again.
constexpr std::array<int, kStages.size()> kStageVersion{2, 6, 11, 4, 8};
constexpr int kDetailVersion = 1;         // the same for what is learnt from detail maps
constexpr int kRefitVersion = 1;          // the same for spans fitted again
constexpr int kPersonNetworkVersion = 1;  // the same for how the person network is heard

std::string content_of(const fs::path& path) {
  if (path.empty()) return "none";
  const auto hash = hash_file(path);
  return hash ? *hash : "absent";
}

// A head model may be a folder, or a file that is read together with others beside it.
std::string head_model_content(const fs::path& path) {
  if (path.empty()) return "none";
  const auto hash = head_model_files_hash(path);
  return hash ? *hash : "absent";
}

// The clip's content. For a clip that was moved or deleted after its import it is the hash that the import
// recorded, so that training continues without the clip.
std::string clip_content(const Project& project, const fs::path& video) {
  std::error_code ignored;
  if (!fs::exists(video, ignored)) {
    if (const auto capture = read_capture(capture_path(project))) return capture->video_hash;
  }
  const auto hash = hash_video(video);
  return hash ? *hash : "absent";
}

// Import and align find the face with it. Empty for the system's dlib model, so that the hashes of projects
// made with it stay as they are.
std::string landmark_model_text(const fs::path& landmark_model) {
  const std::string hash = landmark_source_hash(landmark_model);
  return hash.empty() ? "" : " landmark model " + hash;
}

// Empty without a network, so that the hashes of other projects stay as they are.
std::string person_network_text(const fs::path& choice) {
  const std::string hash = person_network_hash(choice);
  return hash.empty() ? "" : fmt::format(" person network {} {}", kPersonNetworkVersion, hash);
}

// Empty for the usual one, so that the hashes of projects from before there were others stay as they are.
std::string split_text(Split split, const SideRange& sides) {
  if (split == Split::tail) return "";
  std::string text = fmt::format(" {}", split_name(split));
  if (split == Split::sides) text += fmt::format(" {}-{}", sides.inside_deg, sides.beyond_deg);
  return text;
}

std::string import_text(const Project& project, const ImportInputs& inputs) {
  const auto& [video, landmark_model, person_network, camera, choices] = inputs;
  const auto& [size, split, seconds, sides] = choices;
  std::string text = fmt::format("{} {}", clip_content(project, video), size);
  if (is_further(project)) text += " further";
  if (!seconds.whole()) text += fmt::format(" seconds {}-{}", seconds.from_s, seconds.to_s);
  text += split_text(split, sides);
  if (split == Split::views && camera == CameraKind::resting) text += " rests";  // what such a split refuses
  // Such a split asks where the camera moves, which is measured beside the person.
  if (split == Split::views && camera != CameraKind::resting) text += person_network_text(person_network);
  return text + landmark_model_text(landmark_model);
}

std::string align_text(const Project& project, const AlignInputs& inputs) {
  const auto& [video, landmark_model, person_network, seed, split, sides, choices] = inputs;
  const auto& [camera, lens_mm] = choices;
  std::string text = fmt::format("{} {}", clip_content(project, video), seed);
  if (camera)
    text += *camera == CameraKind::resting ? " rests" : fmt::format(" {}", camera_kind_name(*camera));
  if (camera != CameraKind::resting) text += split_text(split, sides);
  if (lens_mm > 0) text += fmt::format(" {} mm", lens_mm);
  if (camera != CameraKind::resting)
    text += person_network_text(person_network);  // else nobody is looked for
  // Only of a film with bars, or of which parts are left out, so that the hashes of other projects stay as
  // they are.
  if (const auto capture = read_capture(capture_path(project))) {
    if (const PixelRect& film = capture->film; !film.empty())
      text += fmt::format(" film {} {} {} {}", film.x, film.y, film.width, film.height);
    for (const FrameSpan& part : stretches_that_serve(*capture))
      text += fmt::format(" {}-{}", part.first, part.last);
  }
  return text + landmark_model_text(landmark_model);
}

// What the person's shape in a project's track was made from. Spans fitted again do not change it.
std::string person_content(const fs::path& folder) {
  const auto project = open_project(folder);
  return project ? first_track_hash(*project) : "absent";
}

// video does not enter: the contents of the capture and the cameras stand for it.
std::string fit_text(const Project& project, const FitInputs& inputs) {
  const auto& [video, head_model, landmark_model, choices] = inputs;
  const auto& [identity, displacement, refits, rest_frames] = choices;
  const std::string landmarks = landmark_source_hash(landmark_model);
  std::string text =
      fmt::format("{} {} {} {}", content_of(capture_path(project)), content_of(cameras_path(project)),
                  head_model_content(head_model), landmarks.empty() ? "none" : landmarks);
  if (is_further(project))
    text += " of " + person_content(project.first_clip);
  else if (!identity.empty())
    text += " person " + content_of(identity);
  // Only if maps are given, so that the hashes of other projects stay as they are; the same below.
  if (!displacement.empty() && !is_further(project)) {
    const auto maps = detail_maps_hash(displacement);
    text += fmt::format(" displacement {} {}", kDetailVersion, maps ? *maps : "absent");
  }
  if (!rest_frames.empty()) text += fmt::format(" rest {}", fmt::join(rest_frames, ","));
  if (!refits.empty()) {
    text += fmt::format(" again {}:", kRefitVersion);
    for (const RefitSpan& span : refits) text += fmt::format(" {}-{}", span.first, span.last);
  }
  return text;
}

// seed does not enter: it is for the room behind a moving camera, whose path, found with the same seed,
// counts by content.
std::string matte_text(const Project& project, const MatteInputs& inputs) {
  const auto& [head_model, person_network, seed, choices] = inputs;
  const auto& [matting_network] = choices;
  std::string text =
      fmt::format("{} {} {} {}", content_of(capture_path(project)), content_of(cameras_path(project)),
                  content_of(track_path(project)), head_model_content(head_model));
  // A matting network is heard instead of the person network.
  text += matting_network.empty() ? person_network_text(person_network)
                                  : " " + matting_network_hash(matting_network);
  // Only if strokes were painted, so that the hashes of other projects stay as they are.
  if (const auto strokes = corrections_hash(project); !strokes.empty())
    text.append(" strokes ").append(strokes);
  return text;
}

// What a training sees of a further clip.
std::string further_content(const Project& project, int number) {
  const auto further = open_further_clip(project, number);
  if (!further) return fmt::format(" clip {} absent", number);
  return fmt::format(" clip {} {} {}", number, further->record(Stage::matte).input_hash,
                     content_of(track_path(*further)));
}

// These do not enter: head_model, which the matte's hash names; checkpoint_every_s, which changes nothing
// that is learnt; full_budget_s, which is for the next training.
std::string train_text(const Project& project, const TrainInputs& inputs) {
  const auto& [head_model, seed, choices] = inputs;
  const auto& [budget_s, full_budget_s, steps, checkpoint_every_s, mode, use_latent, use_occupancy,
               refine_track, landmark_loss, use_proxies, left_out] = choices;
  const ModeParts parts = mode_parts(mode.value_or(kDefaultMode));
  std::string text = fmt::format(
      "{} {} {} {} {} {} {} {} {} {} {} {}", project.record(Stage::matte).input_hash,
      content_of(track_path(project)), content_of(plate_path(project)), content_of(plate_known_path(project)),
      budget_s, steps, seed, parts.ambient, use_latent, use_occupancy, parts.warp, refine_track);
  // Only if chosen, so that the hashes of projects from before these choices stay as they are.
  if (!parts.expression) text += " static";
  // If no mode was asked for, the choice follows from the inputs above.
  if (mode == kDefaultMode) text += " asked";
  if (!use_proxies) text += " no proxies";
  if (landmark_loss != 0) text += fmt::format(" landmarks {}", landmark_loss);
  if (const auto attributes = attributes_hash(project); !attributes.empty())
    text.append(" attributes ").append(attributes);
  if (path_exists(detail_path(project))) text += " detail " + content_of(detail_path(project));
  if (!left_out.empty()) text += fmt::format(" left out {}", fmt::join(left_out, ","));
  for (const int number : project.further_clips) text += further_content(project, number);
  return text;
}

std::string inputs_text(const Project& project, const StageInputs& inputs, Stage stage) {
  switch (stage) {
    case Stage::import:
      return import_text(project, inputs.import);
    case Stage::align:
      return align_text(project, inputs.align);
    case Stage::fit:
      return fit_text(project, inputs.fit);
    case Stage::matte:
      return matte_text(project, inputs.matte);
    case Stage::train:
      return train_text(project, inputs.train);
  }
  return {};
}

std::string hash_of(const Project& project, const StageInputs& inputs, Stage stage) {
  return hash_text(fmt::format("{} {}\n", stage_name(stage), kStageVersion[std::size_t(stage)]) +
                   inputs_text(project, inputs, stage));
}

bool results_exist(const Project& project, Stage stage) {
  switch (stage) {
    case Stage::import:
      return path_exists(capture_path(project)) && path_exists(project.folder / "frames");
    case Stage::align:
      return path_exists(cameras_path(project));
    case Stage::fit:
      return path_exists(track_path(project));
    case Stage::matte:
      return path_exists(project.folder / "masks");
    case Stage::train:
      return path_exists(avatar_path(project));
  }
  return false;
}

// What a stage writes beside its result if asked to; if deleted, it is made again.
bool lesser_results_exist(const Project& project, Stage stage) {
  if (stage == Stage::fit)
    return stage_inputs(project.options).fit.choices.displacement.empty() || is_further(project) ||
           path_exists(detail_path(project));
  if (stage == Stage::train)
    return !path_exists(attributes_path(project)) || path_exists(attribute_values_path(project));
  return true;
}

// Whether the stage's result is still what it wrote, as far as its record knows.
bool is_unharmed(const Project& project, Stage stage) {
  const auto& kept = project.record(stage).results;
  return kept.empty() || kept == stage_results(project, stage);
}

}  // namespace

std::string input_hash(const Project& project, Stage stage) {
  return hash_of(project, stage_inputs(project.options), stage);
}

std::string first_track_hash(const Project& project) {
  StageInputs inputs = stage_inputs(project.options);
  inputs.fit.choices.refits.clear();
  inputs.fit.choices.displacement.clear();
  return hash_of(project, inputs, Stage::fit);
}

bool is_current_alone(const Project& project, Stage stage) {
  const StageRecord& record = project.record(stage);
  return record.state == StageState::done && results_exist(project, stage) &&
         lesser_results_exist(project, stage) && is_unharmed(project, stage) &&
         record.input_hash == input_hash(project, stage);
}

bool is_current(const Project& project, Stage stage) {
  if (!is_current_alone(project, stage)) return false;
  if (stage == Stage::train) return true;  // its inputs name the further clips
  return std::ranges::all_of(project.further_clips, [&](int number) {
    const auto further = open_further_clip(project, number);
    return further && is_current_alone(*further, stage);
  });
}

Freshness read_freshness(const Project& project) {
  Freshness fresh;
  std::array<bool, kStages.size()> there{};
  for (const Stage stage : kStages) {
    const auto i = std::size_t(stage);
    there[i] = project.record(stage).state == StageState::done && results_exist(project, stage);
    fresh.current[i] = there[i] && is_current(project, stage);
  }
  for (const Stage stage : kStages)
    for (const Stage earlier : kStages) {
      if (earlier > stage) break;
      if (stage == Stage::align && earlier == Stage::import) continue;  // reads the clip, not the import
      const auto e = std::size_t(earlier);
      fresh.stale[std::size_t(stage)] |= there[std::size_t(stage)] && there[e] && !fresh.current[e];
    }
  return fresh;
}

}  // namespace likeness
