// What the camera does, by evidence: it rests, is held in a hand, or walks. Each explanation is checked
// against the pictures, and where it fails the next one is tried.
#include "core/camera/align.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "core/camera/assumed_lens.h"
#include "core/camera/camera_kind.h"
#include "core/camera/grey_plate.h"
#include "core/camera/handheld.h"
#include "core/camera/kept_path.h"
#include "core/camera/motion.h"
#include "core/camera/solve_path.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

struct Lens {
  Intrinsics intrinsics;
  std::string evidence;  // a sentence after a space, or nothing
  double log_sigma = 0;  // of the focal length's logarithm: how far it may be off
};

// What was filmed of the clip's pictures: the lens and everything that is measured are about it alone.
VideoInfo film_of(VideoInfo whole, const AlignOptions& options) {
  if (!options.film.empty()) whole.width = options.film.width, whole.height = options.film.height;
  return whole;
}

Lens lens_of(const VideoInfo& whole, const AlignOptions& options) {
  const VideoInfo info = film_of(whole, options);
  const Intrinsics usual = assumed_intrinsics(info.width, info.height, 0);
  if (options.lens_mm > 0) {
    const Intrinsics given = film_intrinsics(info.width, info.height, options.lens_mm);
    return {given,
            fmt::format(" Its lens was given as {:.3g} mm (on 35 mm film): {:.0f} px.", options.lens_mm,
                        given.fx),
            0};
  }
  const Intrinsics named = assumed_intrinsics(info.width, info.height, info.focal_35mm);
  // Phones film with 24 to 35 mm, and crop. What a clip names is rounded to a millimetre, and a stabiliser's
  // crop is left out.
  constexpr double kUsualSpread = 0.25, kNamedSpread = 0.05;
  if (named.fx == usual.fx) return {usual, "", kUsualSpread};
  return {named,
          fmt::format(" The clip names its lens: {:.3g} mm (on 35 mm film), {:.0f} px.", info.focal_35mm,
                      named.fx),
          kNamedSpread};
}

AlignResult resting_result(const VideoInfo& info, const AlignOptions& options, std::size_t frames,
                           const std::string& evidence) {
  const Lens lens = lens_of(info, options);
  AlignResult result;
  result.cameras.kind = CameraKind::resting;
  result.cameras.scale = CameraScale::metric;
  result.cameras.cameras.push_back(
      {-1, in_whole_picture(lens.intrinsics, options.film, info.width, info.height), Pose::Identity()});
  result.evidence = evidence + lens.evidence;
  result.frames = result.registered = int(frames);
  return result;
}

// One clip while its camera is being found out.
struct Search {
  const fs::path& video;
  const PersonMask& person;
  const fs::path& work;
  const AlignOptions& options;
  const VideoInfo& info;
  std::stop_token stop;
  BackgroundMotion motion{};
  BackgroundPictures pictures{};
  std::string doubts{};            // why explanations were given up, in sentences, each after a space
  std::optional<Error> missing{};  // colmap, without which no path can be found
};

// As kept, or measured.
Result<void> look_at_background(Search& search, const Progress& progress) {
  const AlignOptions& options = search.options;
  if (!options.kept.empty()) {
    const auto video_hash = hash_video(search.video);
    if (!video_hash) return video_hash.error();
    const std::string inputs = motion_inputs(*video_hash, options);
    auto motion = kept_motion(options.kept, inputs);
    auto pictures = motion ? kept_background(options.kept, inputs) : std::nullopt;
    // Two files: one may be from another run.
    if (pictures && pictures->frames.size() == motion->frames.size()) {
      search.motion = std::move(*motion), search.pictures = std::move(*pictures);
      progress.report(1);
      return {};
    }
  }
  auto motion = measure_background_motion(search.video, search.person, rest_limit(options), progress,
                                          search.stop, &search.pictures, options.film, options.stretches);
  if (!motion) return motion.error();
  search.motion = std::move(*motion);
  return {};
}

std::vector<HandheldFrame> background_frames(const Search& search) {
  const BackgroundPictures& pictures = search.pictures;
  std::vector<HandheldFrame> frames;
  for (std::size_t i = 0; i < pictures.frames.size(); ++i) {
    HandheldFrame& frame = frames.emplace_back();
    frame.frame = pictures.frames[i];
    frame.grey = &pictures.grey[i], frame.person = pictures.person_at(i);
    frame.held_out = search.options.held_out.contains(frame.frame);
    frame.time_s = search.motion.frames[i].time_s;
    frame.shot = span_of(search.options.shots, frame.frame);
  }
  return frames;
}

Result<HandheldSolve> solve_background(const Search& search, const Progress& progress) {
  const auto frames = background_frames(search);
  const Lens lens = lens_of(search.info, search.options);
  Camera reference;
  reference.intrinsics = lens.intrinsics;
  reference = resized(reference, search.pictures.grey.front().width);
  HandheldOptions options;
  options.lens_sigma = lens.log_sigma;
  return solve_handheld(frames, reference.intrinsics, options, progress, search.stop);
}

AlignResult handheld_result(const Search& search, const HandheldSolve& solve, const std::string& evidence) {
  AlignResult result;
  result.cameras.kind = CameraKind::handheld;
  result.cameras.scale = CameraScale::metric;
  const VideoInfo film = film_of(search.info, search.options);
  for (const HandheldCamera& solved : solve.cameras) {
    Camera& camera =
        result.cameras.cameras.emplace_back(handheld_camera(solve, solved.frame, film.width, film.height));
    camera.intrinsics =
        in_whole_picture(camera.intrinsics, search.options.film, search.info.width, search.info.height);
  }
  result.evidence = evidence + lens_of(search.info, search.options).evidence;
  result.frames = int(solve.cameras.size());
  result.registered = int(std::ranges::count(solve.cameras, true, &HandheldCamera::found));
  if (result.registered < result.frames)
    result.warnings.push_back(fmt::format(
        "In {} of {} frames the background could not be found again; their cameras are taken from the "
        "frames beside them.",
        result.frames - result.registered, result.frames));
  return result;
}

bool could_tell(const BackgroundMotion& motion) { return motion.tracks >= kLeastTracks; }

// Whether the tracks say that the camera rests, and in which words.
std::optional<std::string> rests_by_tracks(const Search& search) {
  const BackgroundMotion& motion = search.motion;
  const double limit = search.options.static_motion_px_per_1000;
  if (!could_tell(motion) || motion.motion > limit) return std::nullopt;
  return fmt::format(
      "The camera rests: the background moves by {:.2f} thousandths of the picture's width over {} "
      "frames ({:.0f} feature tracks on average; limit {:.2f}).",
      motion.motion, motion.frames.size(), motion.tracks, limit);
}

// nullopt: no path is believed, and `doubts` says why.
Result<std::optional<AlignResult>> try_walking(Search& search, const std::optional<SolveLimits>& limits,
                                               const Progress& progress) {
  auto walked = solve_path(search.video, search.person, search.work, search.options, search.motion,
                           search.info, limits, progress, search.stop);
  if (walked) return std::optional<AlignResult>(std::move(*walked));
  const ErrorCode code = walked.error().code;
  // A full disk or a damaged clip is no statement about the camera.
  if (!limits || (code != ErrorCode::failed && code != ErrorCode::missing_dependency)) return walked.error();
  if (code == ErrorCode::missing_dependency) search.missing = walked.error();
  search.doubts += " " + walked.error().what;
  return std::optional<AlignResult>{};
}

// What a path must be to be preferred to a mosaic. Where one that is a little soft shows nearly all there is
// to see, only a path from which depth is plain shows more: a room that is learnt from a short one goes to
// pieces beside it.
SolveLimits limits_beside(const HandheldSolve& solve) {
  constexpr double kShows = 9;          // grey values, rms: 29 dB
  constexpr double kPlainParallax = 8;  // degrees
  SolveLimits limits;
  if (solve.explained >= CameraKindLimits{}.explained && solve.residual <= kShows)
    limits.parallax = kPlainParallax;
  return limits;
}

// The kind as the user states it.
Result<AlignResult> as_stated(Search& search, CameraKind kind, const Progress& progress) {
  if (kind == CameraKind::walking) {
    auto walked = try_walking(search, std::nullopt, progress);
    if (!walked) return walked.error();
    return std::move(**walked);
  }
  const auto solve = solve_background(search, progress);
  if (!solve) return solve.error();
  return handheld_result(search, *solve, "The camera is hand-held, as stated. " + solve->evidence);
}

Result<AlignResult> found_out(Search& search, const Progress& progress) {
  const std::size_t frames = search.motion.frames.size();
  if (const auto evidence = rests_by_tracks(search)) {
    const PlateFit fit = fit_of_plate(search.pictures);
    if (fit.holds()) return resting_result(search.info, search.options, frames, *evidence);
    search.doubts += fmt::format(
        " The tracks rest, but in {:.0f} % of {} frames the background differs from the picture "
        "of it.",
        100 * fit.unexplained, fit.frames);
  }
  const auto untextured = [&](const CameraVerdict& verdict) {
    AlignResult result = resting_result(
        search.info, search.options, frames,
        verdict.reason + " It is taken to rest, which makes no difference before such a wall.");
    result.kind_assumed = true;
    return result;
  };
  // A clip of which nothing can tell need not be solved to find that out.
  const double textured = share_with_texture(background_frames(search));
  if (textured < CameraKindLimits{}.judged) return untextured(without_texture(textured));
  // Before any path: it takes seconds, and where a camera that stays in its place explains the background,
  // what a path is found by, near and far moving apart, is noise.
  const auto solve = solve_background(search, progress.stage(0, 0.3, "hand-held camera"));
  if (!solve) return solve.error();
  const CameraVerdict verdict = judge_camera_kind(*solve);
  if (verdict.explanation == CameraExplanation::resting)
    return resting_result(search.info, search.options, frames, verdict.reason);
  if (verdict.explanation == CameraExplanation::no_texture) return untextured(verdict);
  if (verdict.explanation == CameraExplanation::handheld)
    return handheld_result(search, *solve, verdict.reason + search.doubts);
  auto walked = try_walking(search, limits_beside(*solve), progress.stage(0.3, 1, "camera path"));
  if (!walked) return walked.error();
  if (*walked) return std::move(**walked);
  if (search.missing) return *search.missing;  // it walks, and could be followed
  auto result = handheld_result(search, *solve, "The camera is taken to be hand-held. " + verdict.reason);
  result.kind_assumed = true;
  result.warnings.push_back(
      "The camera travels, and no path was found for it, so parts of the background will be soft." +
      search.doubts + " For a sharper result rest the phone on something, or walk slowly round the head.");
  return result;
}

}  // namespace

Result<AlignResult> align_clip(const fs::path& video, const PersonMask& person, const fs::path& work,
                               const AlignOptions& options, const Progress& progress, std::stop_token stop) {
  const auto info = probe_video(video);
  if (!info) return info.error();
  if (options.kind == CameraKind::resting) {
    progress.report(1);
    return resting_result(*info, options, std::size_t(info->frame_count),
                          "The camera is at rest as stated; nothing was measured.");
  }
  Search search{video, person, work, options, *info, stop};
  if (auto looked = look_at_background(search, progress.stage(0, 0.2, "background")); !looked)
    return looked.error();
  const Progress rest = progress.stage(0.2, 1, "camera");
  auto result = options.kind ? as_stated(search, *options.kind, rest) : found_out(search, rest);
  if (!result) return result;
  result->cameras.shots = {{0, search.motion.seconds, result->cameras.kind}};
  progress.report(1);
  return result;
}

}  // namespace likeness
