#include "core/track/clip/track_clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/rigid.h"
#include "core/track/clip/clip_work.h"
#include "core/track/clip/kept_fit.h"
#include "core/track/clip/wandering_poses.h"
#include "core/track/fit/neutral.h"
#include "core/track/fit/personal_shape.h"
#include "core/track/fit/rest.h"
#include "core/track/kept_frames.h"
#include "core/track/photo/photometric.h"
#include "core/track/points/camera_scale.h"
#include "core/track/points/rigid_head.h"
#include "core/track/torso/torso.h"
#include "core/track/torso/torso_picture.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

// As kept, or read.
Result<ClipFrames> find_clip_frames(const std::filesystem::path& video, const TrackRegion& region,
                                    const std::set<int>& held_out, const TrackOptions& options,
                                    const Progress& progress, std::stop_token stop) {
  if (!options.kept.empty() && !options.every_frame) {
    const auto video_hash = hash_video(video);
    if (!video_hash) return video_hash.error();
    const auto inputs = clip_frames_inputs(*video_hash, region, held_out, options);
    if (!inputs) return inputs.error();
    if (auto kept = kept_clip_frames(options.kept, *inputs)) {
      progress.report(1);
      return std::move(*kept);
    }
  }
  return read_clip_frames(video, region, held_out, options, progress, stop);
}

// Dense poses for the frames that have a landmark pose.
Result<void> refine_poses(const HeadModel& model, const TrackOptions& options, bool resting_camera,
                          ClipWork& work, const Progress& progress, std::stop_token stop) {
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    work.dense[i].known = work.faces[i].seen;
    work.dense[i].intrinsics = work.intrinsics[i];
    work.dense[i].cam_from_head = work.faces[i].state.cam_from_head;
  }
  const RigidHead rigid = rigid_head(model, work.shape(model));
  auto summary =
      track_dense_head(work.clip, rigid, resting_camera, work.dense, progress, stop, options.withheld.get());
  if (!summary) return summary.error();
  work.points = std::move(summary->points);
  for (std::size_t i = 0; i < work.faces.size(); ++i)
    if (work.dense[i].solved) {
      work.faces[i].state.cam_from_head = work.dense[i].cam_from_head;
      work.faces[i].pose_given = true;
    }
  return {};
}

// For the first fit, which only places the head: landmarks alone leave turn and mouth to be confused, and
// what is forbidden the mouth there goes into the turn.
ExpressionPrior placing_prior(const HeadModel& model) {
  constexpr double kFree = 2.5;
  ExpressionPrior prior = expression_prior(model);
  prior.pairs.clear();
  prior.change.setOnes();
  for (std::size_t e = 0; e < model.expression_names.size(); ++e)
    for (const char* name :
         {"mouthPucker", "mouthFunnel", "mouthLeft", "mouthRight", "mouthStretch", "mouthFrown"})
      if (model.expression_names[e].starts_with(name)) prior.weight[static_cast<Eigen::Index>(e)] = kFree;
  return prior;
}

// The person as known from another clip, or from elsewhere; before anything is fitted.
void take_person(const HeadModel& model, const PersonShape& person, ClipWork& work) {
  work.offsets = person.offsets;
  work.head = reduce_head(model, kIdentityDirections, person);
  const Eigen::Index count = std::min(work.identity.size(), person.identity.size());
  work.identity.head(count) = person.identity.head(count).cast<double>();
  work.fine_identity = person.identity.tail(person.identity.size() - count);
}

Result<void> fit_faces(const ExpressionPrior& prior, bool person_known, ClipWork& work,
                       const Progress& progress, std::stop_token stop) {
  ClipFitOptions options;
  options.hold_identity = person_known;
  auto fit = fit_identity(work.head, prior, options, work.identity, work.faces,
                          progress.stage(0, 0.5, "identity"), stop);
  if (!fit) return fit.error();
  work.identity = fit->identity;
  for (DenseFrame& dense : work.dense)
    if (dense.solved) dense.cam_from_head = dense.cam_from_head * fit->registration;
  const Pose new_from_old = inverse(fit->registration);
  for (HeadPoint& point : work.points) point.track.point = new_from_old * point.track.point;
  return fit_states(work.head, work.identity, prior, {.spacing = work.spacing}, work.faces,
                    progress.stage(0.5, 1, "frames"), stop);
}

// Of every frame, in order.
using FoundLandmarks = std::vector<std::pair<std::optional<Landmarks>, FaceObservation>>;

FoundLandmarks found_landmarks(const ClipWork& work) {
  FoundLandmarks found;
  for (std::size_t i = 0; i < work.faces.size(); ++i)
    found.emplace_back(work.clip.frames[i].landmarks, work.faces[i].observation);
  return found;
}

void take_landmarks(FoundLandmarks&& found, ClipWork& work) {
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    work.clip.frames[i].landmarks = std::move(found[i].first);
    work.faces[i].observation = std::move(found[i].second);
  }
}

// What the pictures say of landmarks, brows, lids and rest, and the faces fitted with it.
Result<void> read_and_fit(const HeadModel& model, const TrackOptions& options, bool person_known,
                          ClipWork& work, StageClock& clock, const Progress& progress, std::stop_token stop) {
  if (auto checked = cross_check(work, progress.stage(0, 0.5, "landmarks followed"), stop); !checked)
    return checked.error();
  clock.lap("landmarks followed");
  if (auto brows = find_lost_brows(work, stop); !brows) return brows.error();
  clock.lap("brows");
  if (auto watched = watch_lids(model, work, stop); !watched) return watched.error();
  clock.lap("lids");
  find_rest(options, work);
  return fit_faces(work.prior, person_known, work, progress.stage(0.5, 1, "fitting again"), stop);
}

// The person's own surface on top of the identity, and every frame's expression on it.
Result<void> fit_shape(const HeadModel& model, ClipWork& work, const Progress& progress,
                       std::stop_token stop) {
  std::vector<ShapeFrame> frames(work.faces.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FaceFrame& face = work.faces[i];
    if (!face.seen || !face.pose_given) continue;
    frames[i] = {&work.clip.frames[i].grey, face.held_out, work.intrinsics[i], face.state, &face.observation};
  }
  auto offsets = fit_personal_shape(model, work.full_identity(model), skin_points(work.points, work.dense),
                                    frames, {}, progress.stage(0, 0.7, "own shape"), stop);
  if (!offsets) return offsets.error();
  work.offsets = std::move(*offsets);
  work.head = reduce_head(model, kIdentityDirections, work.offsets);
  return fit_states(work.head, work.identity, work.prior, {.spacing = work.spacing}, work.faces,
                    progress.stage(0.7, 1, "frames"), stop);
}

// Pose, jaw and expression by the pictures themselves, where the dense poses hold the head.
Result<void> refine_on_pictures(const HeadModel& model, ClipWork& work, const Progress& progress,
                                std::stop_token stop) {
  std::vector<PhotometricFrame> pictures(work.faces.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (!work.cameras[i]) continue;
    pictures[i] = {&work.clip.frames[i].grey, work.intrinsics[i],
                   work.cameras[i]->cam_from_world.linear().transpose()};
  }
  auto refined =
      refine_photometric(model, work.shape(model), work.head, reduced_person(work.head, work.identity),
                         work.prior, pictures, {.spacing = work.spacing}, work.faces, progress, stop);
  if (!refined) return refined.error();
  return {};
}

// Two people of one size: whichever is followed, it may be the wrong one.
Result<void> check_alone(const ClipFrames& clip, const std::filesystem::path& video) {
  int scanned = 0, rivals = 0;
  for (const ClipFrame& f : clip.frames) scanned += f.scanned, rivals += f.scanned && f.rival;
  if (2 * rivals <= scanned) return {};
  return Error{ErrorCode::bad_input,
               fmt::format("Two faces of nearly the same size are in view in {} of {} pictures searched.",
                           rivals, scanned),
               "Film one person alone, or crop the video to the person who is meant.", video.string()};
}

std::optional<double> find_scale(const CameraSet& cameras, const ClipWork& work) {
  if (cameras.rests() || cameras.scale == CameraScale::metric) return 1;
  std::vector<HeadSighting> sightings;
  for (std::size_t i = 0; i < work.faces.size(); ++i)
    if (work.faces[i].seen && !work.faces[i].held_out)
      sightings.push_back({work.cameras[i]->cam_from_world, work.faces[i].state.cam_from_head});
  return steady_metres_per_unit(sightings);
}

Result<void> add_torso(const ClipWork& work, const CameraSet& cameras, const HeadModel& model, Track& track,
                       const Progress& progress, std::stop_token stop) {
  const HeadShape person = shape_head(model, track.person);
  const Vec3d chin = landmark_positions(model, person.vertices)[8].cast<double>();
  std::vector<TorsoFrame> frames(track.frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].grey = &work.clip.frames[i].grey;
    frames[i].held_out = work.clip.frames[i].held_out;
    frames[i].shot = work.clip.frames[i].shot;
    frames[i].usable = work.cameras[i] && track.frames[i].status != FrameStatus::lost;
    frames[i].intrinsics = work.intrinsics[i];
    if (work.cameras[i])
      frames[i].cam_from_world = metric_camera(work.cameras[i]->cam_from_world, track.metres_per_unit);
    frames[i].world_from_head = track.frames[i].pose.world_from_head;
    if (frames[i].usable)
      frames[i].head_outline = head_outline(
          person.vertices, chin, frames[i].cam_from_world * frames[i].world_from_head, frames[i].intrinsics);
  }
  TorsoOptions options;
  options.approaches = cameras.kind == CameraKind::handheld;
  auto torso = track_torso(frames, chin, progress, stop, options);
  if (!torso) return torso.error();
  track.has_torso = torso->has_torso;
  track.torso_modes = std::move(torso->modes);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    track.frames[i].pose.world_from_torso = torso->world_from_torso[i];
    track.frames[i].pose.torso_shape = torso->shapes[i];
  }
  return {};
}

// The landmarks again, from the dense poses, and the faces fitted with all that the pictures say of them.
Result<void> fit_again(const HeadModel& model, const TrackOptions& options, ClipWork& work, StageClock& clock,
                       const Progress& progress, std::stop_token stop) {
  const bool person_known = options.person.has_value();
  FoundLandmarks first = found_landmarks(work);
  if (auto again = find_landmarks_again(options, work, progress.stage(0.75, 0.85, "landmarks again"), stop);
      !again)
    return again.error();
  clock.lap("landmarks again");
  if (auto fitted =
          read_and_fit(model, options, person_known, work, clock, progress.stage(0.85, 0.89, ""), stop);
      !fitted)
    return fitted.error();
  if (drop_wandering_poses(work)) {
    const bool all = std::ranges::none_of(work.faces, &FaceFrame::pose_given);
    if (all) take_landmarks(std::move(first), work);
    auto refitted =
        all ? read_and_fit(model, options, person_known, work, clock, progress.stage(0.89, 0.895, ""), stop)
            : fit_faces(work.prior, person_known, work, progress.stage(0.89, 0.895, "third fit"), stop);
    if (!refitted) return refitted.error();
  }
  clock.lap("fit again");
  return {};
}

// From the clip's landmarks to its faces and their eyes, part by part; parts that a killed run had kept are
// not run again.
Result<void> fit_work(const HeadModel& model, const TrackOptions& options, bool resting_camera,
                      ClipWork& work, StageClock& clock, const Progress& progress, std::stop_token stop) {
  const bool person_known = options.person.has_value();
  KeptFit kept(options.kept_work, model, person_known, work);
  kept.go_on({"placed", "dense head", "landmarks", "own shape", "rest", "pictures"});
  const auto placed = kept.part("placed", [&]() -> Result<void> {
    if (auto started = start_clip(work.head, work.identity, work.prior, work.faces,
                                  progress.stage(0.38, 0.40, "faces"), stop);
        !started)
      return started;
    return fit_faces(placing_prior(model), person_known, work, progress.stage(0.40, 0.45, "first fit"), stop);
  });
  if (!placed) return placed;
  clock.lap("fit");
  if (options.dense) {
    const auto dense = kept.part("dense head", [&] {
      return refine_poses(model, options, resting_camera, work, progress.stage(0.45, 0.75, "dense head"),
                          stop);
    });
    if (!dense) return dense;
    clock.lap("dense head");
    const auto again =
        kept.part("landmarks", [&] { return fit_again(model, options, work, clock, progress, stop); });
    if (!again) return again;
    if (options.own_shape && !person_known) {
      const auto shape = kept.part(
          "own shape", [&] { return fit_shape(model, work, progress.stage(0.895, 0.9, "own shape"), stop); });
      if (!shape) return shape;
      clock.lap("own shape");
    }
    const auto rest = kept.part("rest", [&]() -> Result<void> {
      auto settled = fit_from_rest(model, work.head, work.identity, work.prior, {.spacing = work.spacing},
                                   work.faces, progress.stage(0.9, 0.91, "rest"), stop, work.rest.trust);
      if (!settled) return settled.error();
      work.prior = std::move(*settled);
      return {};
    });
    if (!rest) return rest;
    clock.lap("rest");
    if (options.photometric) {
      const auto refined = kept.part("pictures", [&] {
        return refine_on_pictures(model, work, progress.stage(0.91, 0.955, "pictures"), stop);
      });
      if (!refined) return refined;
    }
    clock.lap("pictures");
  }
  if (options.gaze)
    if (auto measured = measure_eyes(model, work, progress.stage(0.955, 0.96, "gaze"), stop); !measured)
      return measured;
  clock.lap("eyes");
  return {};
}

}  // namespace

Result<Track> track_clip(const std::filesystem::path& video, const TrackRegion& region,
                         const CameraSet& cameras, const std::set<int>& held_out, const HeadModel& model,
                         const TrackOptions& options, const Progress& progress, std::stop_token stop) {
  if (cameras.cameras.empty())
    return Error{ErrorCode::bad_input, "There is no camera for this clip.", "Run the camera alignment first.",
                 "track"};
  StageClock clock(options.seconds.get());
  ClipWork work;
  auto clip = find_clip_frames(video, region, held_out, options, progress.stage(0, 0.38, "landmarks"), stop);
  if (!clip) return clip.error();
  work.clip = std::move(*clip);
  prepare(cameras, model, work);
  clock.lap("landmarks");
  int seen = 0, training = 0;
  for (const FaceFrame& f : work.faces) seen += f.seen, training += f.seen && !f.held_out;
  const auto placed = static_cast<std::size_t>(std::count_if(
      work.cameras.begin(), work.cameras.end(), [](const Camera* camera) { return camera != nullptr; }));
  if (training < 5 && 2 * placed < work.cameras.size())
    return Error{
        ErrorCode::bad_input,
        fmt::format("The camera is known in only {} of {} frames.", placed, work.cameras.size()),
        "Film again: move the camera more slowly, in front of a background with detail, or put it on "
        "a tripod.",
        video.string()};
  if (training < 5)
    return Error{
        ErrorCode::no_face, fmt::format("A face was found in {} of {} frames.", seen, work.faces.size()),
        "Film the face from nearer and in good light; it should be at least 80 px wide in the picture.",
        video.string()};

  if (auto alone = check_alone(work.clip, video); !alone) return alone.error();
  if (options.person) take_person(model, *options.person, work);
  if (auto fitted = fit_work(model, options, cameras.rests(), work, clock, progress, stop); !fitted)
    return fitted.error();

  Track track;
  track.head_model_name = model.name;
  track.head_model_hash = model.hash;
  track.person = {work.full_identity(model), work.offsets};
  const std::optional<double> scale = find_scale(cameras, work);
  track.metre_known = scale.has_value();
  track.metres_per_unit = scale.value_or(1.0);
  track.frames = describe_frames(work, model, track.metres_per_unit);
  leave_out_parted(work);
  track.rest = work.rest;
  track.shots = options.shots;
  track.neutral = calibrate_neutral(model, track.frames, held_out, track.rest);
  if (auto torso = add_torso(work, cameras, model, track, progress.stage(0.96, 1, "torso"), stop); !torso)
    return torso.error();
  clock.lap("torso");
  progress.report(1, "tracked");
  return track;
}

}  // namespace likeness
