// One clip at a time, each kept as soon as it is done: see kind_study.h.
#include "core/lab/truth/kind_study.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/json_text.h"
#include "core/base/program_files.h"
#include "core/camera/align.h"
#include "core/capture/capture.h"
#include "core/capture/choose_shots.h"
#include "core/capture/scan_clip.h"
#include "core/face/landmarks.h"
#include "core/lab/truth/camera_truth.h"
#include "core/matte/coarse_mask.h"
#include "core/matte/person_network.h"
#include "core/synth/demo_capture.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// Filming takes most of the time.
constexpr double kFilming = 0.75;

Result<void> film_clip(const KindClip& clip, const fs::path& folder, const Progress& progress,
                       std::stop_token stop) {
  const std::string words = demo_words(clip.film) + "\n";
  const auto filmed = read_text(folder / "clip.txt");
  if (filmed && *filmed == words && path_exists(folder / "demo.mp4") &&
      path_exists(folder / "cameras_truth.json"))
    return {};
  if (auto written = write_demo_capture(folder, clip.film, progress, stop); !written) return written;
  return write_text(folder / "clip.txt", words);  // last: a film without it is not finished
}

// What the cameras found depend on. Not the version but the program itself: it is the program that is tried.
std::string inputs_of(const KindClip& clip, const KindStudyOptions& options) {
  const auto program = hash_file(program_file());
  std::string text =
      fmt::format("kinds {} {} {}", program ? *program : "", demo_words(clip.film), options.align.seed);
  for (const FrameSpan& part : options.align.stretches) text += fmt::format(" {}-{}", part.first, part.last);
  if (!options.landmark_model.empty()) {
    const auto model = hash_file(options.landmark_model);
    text += model ? *model : "absent";
  }
  return hash_text(text + person_network_hash({}));
}

bool read_found(KindRow& row, CameraSet& cameras, const fs::path& folder, const std::string& inputs) {
  const auto text = read_text(folder / "found.json");
  auto found = read_cameras(folder / "cameras.json");
  if (!text || !found) return false;
  try {
    const nlohmann::json json = parse_json(*text);
    if (json.at("inputs") != inputs) return false;
    row.found = KindFound{found->kind, json.at("assumed").get<bool>()};
    row.evidence = json.at("evidence").get<std::string>();
    row.warnings = json.at("warnings").get<std::vector<std::string>>();
    row.align = {json.at("seconds").get<double>(), json.at("processor_seconds").get<double>()};
  } catch (const nlohmann::json::exception&) {
    return false;
  }
  cameras = std::move(*found);
  return true;
}

Result<void> write_found(const KindRow& row, const CameraSet& cameras, const fs::path& folder,
                         const std::string& inputs) {
  std::error_code ignored;
  fs::remove(folder / "found.json", ignored);  // of other cameras
  if (auto written = write_cameras(folder / "cameras.json", cameras); !written) return written;
  const nlohmann::json json = {{"inputs", inputs},          {"assumed", row.found->assumed},
                               {"evidence", row.evidence},  {"warnings", row.warnings},
                               {"seconds", row.align.wall}, {"processor_seconds", row.align.processor}};
  return write_text(folder / "found.json", json_text(json, 1) + "\n");
}

// Fills in what the stage says; without cameras where it fails as it may fail on a clip.
Result<CameraSet> cameras_of(KindRow& row, const fs::path& folder, const KindStudyOptions& options,
                             const Progress& progress, std::stop_token stop) {
  const std::string inputs = inputs_of(row.clip, options);
  CameraSet cameras;
  if (read_found(row, cameras, folder, inputs)) return cameras;
  const auto person = coarse_person_mask(options.landmark_model);
  if (!person) return person.error();
  const fs::path work = folder / "align";
  std::error_code ignored;
  fs::remove_all(work, ignored);  // seconds are those of the whole stage
  const SpentSeconds start = spent_seconds();
  auto aligned = align_clip(folder / "demo.mp4", *person, work, options.align, progress, stop);
  row.align = spent_since(start);
  fs::remove_all(work, ignored);
  if (!aligned && aligned.error().code != ErrorCode::failed) return aligned.error();
  if (!aligned) {
    row.evidence = aligned.error().what + " " + aligned.error().fix;
    return cameras;
  }
  row.found = KindFound{aligned->cameras.kind, aligned->kind_assumed};
  row.evidence = aligned->evidence;
  row.warnings = aligned->warnings;
  if (auto written = write_found(row, aligned->cameras, folder, inputs); !written) return written.error();
  return std::move(aligned->cameras);
}

// Of a film that was cut, the parts that import would use; empty: all of it.
Result<std::vector<FrameSpan>> serving_stretches(const fs::path& video, const fs::path& landmark_model,
                                                 const Progress& progress, std::stop_token stop) {
  const auto detector = FaceDetector::load(landmark_model);
  if (!detector) return detector.error();
  const auto scan = scan_clip(video, *detector, {}, {}, progress, stop);
  if (!scan) return scan.error();
  Capture capture;
  capture.frames = scan->frames;
  capture.shots = shots_of(*scan, {}, false);
  return stretches_that_serve(capture);
}

// What the camera does between cuts, and only where import would use the film.
void keep_stretches(const std::vector<FrameSpan>& stretches, const DemoOptions& film, CameraTruth& truth) {
  std::erase_if(truth.cameras.cameras,
                [&](const Camera& camera) { return span_of(stretches, camera.frame) < 0; });
  if (film.camera == DemoCamera::resting) truth.kind = CameraKind::resting;
}

Result<KindRow> study_clip(const KindClip& clip, const fs::path& folder, const KindStudyOptions& options,
                           const Progress& progress, std::stop_token stop) {
  KindRow row;
  row.clip = clip;
  if (auto filmed = film_clip(clip, folder, progress.stage(0, kFilming, clip.name), stop); !filmed)
    return filmed.error();
  auto truth = read_camera_truth(folder);
  if (!truth) return truth.error();
  KindStudyOptions own = options;
  if (clip.film.cuts > 0) {
    const auto stretches = serving_stretches(truth->input, options.landmark_model, {}, stop);
    if (!stretches) return stretches.error();
    own.align.stretches = *stretches;
    keep_stretches(*stretches, clip.film, *truth);
  }
  row.truth = truth->kind;
  const auto cameras = cameras_of(row, folder, own, progress.stage(kFilming, 1, clip.name), stop);
  if (!cameras) return cameras.error();
  row.outcome = judge_kind(clip.film.wall, row.truth, row.found);
  row.views = compare_views(*cameras, truth->cameras, truth->shots);
  return row;
}

}  // namespace

Result<std::vector<KindRow>> study_camera_kinds(const std::vector<KindClip>& clips, const fs::path& folder,
                                                const KindStudyOptions& options, const Progress& progress,
                                                std::stop_token stop) {
  std::vector<KindRow> rows;
  const double n = double(clips.size());
  for (const KindClip& clip : clips) {
    if (stop.stop_requested()) return cancelled_error();
    const double done = double(rows.size());
    const Progress part = progress.stage(done / n, (done + 1) / n, clip.name);
    auto row = study_clip(clip, folder / clip.name, options, part, stop);
    if (!row) return row.error();
    rows.push_back(std::move(*row));
    part.report(1);
  }
  return rows;
}

}  // namespace likeness
