#include "core/track/track_clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "core/head/pose_head.h"
#include "core/track/brow_line.h"
#include "core/track/camera_scale.h"
#include "core/track/clip_frames.h"
#include "core/track/dense_head.h"
#include "core/track/face_look.h"
#include "core/track/fit_clip.h"
#include "core/track/frame_verdict.h"
#include "core/track/gaze.h"
#include "core/track/lids.h"
#include "core/track/neutral.h"
#include "core/track/optical_support.h"
#include "core/track/personal_shape.h"
#include "core/track/photometric.h"
#include "core/track/rest.h"
#include "core/track/rigid_head.h"
#include "core/track/torso.h"
#include "core/track/torso_picture.h"

namespace likeness {
namespace {

constexpr int kIdentityDirections = 60;  // landmarks say nothing about the finer ones

// Everything known of the clip while it is fitted; one entry a decoded frame in each array.
struct Work {
  ClipFrames clip;
  std::vector<const Camera*> cameras;  // null: unknown
  std::vector<Intrinsics> intrinsics;  // of the working pictures
  std::vector<FaceFrame> faces;
  std::vector<DenseFrame> dense;
  std::vector<std::optional<Gaze>> gaze;
  std::vector<OpticalVerdict> optical;  // empty before the landmarks were followed
  std::vector<LidOpenings> lids;        // by the pixels; empty before they were read
  std::vector<double> look;             // agreement with the person's other frames; empty before it is known
  ReducedHead head;
  ExpressionPrior prior;
  Eigen::VectorXd identity;
  std::vector<HeadPoint> points;  // of the dense step
  std::vector<Vec3f> offsets;     // the personal shape, part of `head`; empty before it is known

  HeadShape shape(const HeadModel& model) const {
    return shape_head(model, PersonShape{full_identity(model), offsets});
  }
  Eigen::VectorXf full_identity(const HeadModel& model) const {
    Eigen::VectorXf full = Eigen::VectorXf::Zero(model.identity_count());
    full.head(identity.size()) = identity.cast<float>();
    return full;
  }
};

void observe(const Landmarks& landmarks, const Intrinsics& source, double scale, double focal_px,
             FaceObservation* out) {
  // The predictor's own noise grows with the face: 1 px for eyes 150 px apart, and never below its rounding.
  const double eyes_px = (landmarks.points[36] - landmarks.points[45]).norm() * scale;
  const double floor = std::clamp(eyes_px / 150.0, 0.4, 2.0);
  out->focal_px = focal_px;
  for (int k = 0; k < kLandmarkCount; ++k) {
    out->rays[k] = ray_direction(source, landmarks.points[k]).head<2>();
    out->sigma_px[k] = std::hypot(floor, landmarks.spread[k] * scale);
  }
}

void prepare(const CameraSet& cameras, const HeadModel& model, Work& work) {
  const std::size_t n = work.clip.frames.size();
  work.head = reduce_head(model, kIdentityDirections);
  work.prior = expression_prior(model);
  work.identity = Eigen::VectorXd::Zero(work.head.identity_count());
  work.faces.resize(n), work.intrinsics.resize(n), work.cameras.resize(n), work.dense.resize(n),
      work.gaze.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const ClipFrame& source = work.clip.frames[i];
    work.cameras[i] = find_camera(cameras, source.frame);
    FaceFrame& face = work.faces[i];
    face.frame = source.frame;
    face.held_out = source.held_out;
    face.state.expression = Eigen::VectorXd::Zero(work.head.expression_count());
    if (!work.cameras[i]) continue;
    work.intrinsics[i] = working_intrinsics(work.cameras[i]->intrinsics, work.clip);
    face.seen = source.landmarks.has_value();
    if (face.seen)
      observe(*source.landmarks, work.cameras[i]->intrinsics, work.clip.scale, work.intrinsics[i].fx,
              &face.observation);
  }
}

// Dense poses for the frames that have a landmark pose.
Result<void> refine_poses(const HeadModel& model, const TrackOptions& options, Work& work,
                          const Progress& progress, std::stop_token stop) {
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    work.dense[i].known = work.faces[i].seen;
    work.dense[i].intrinsics = work.intrinsics[i];
    work.dense[i].cam_from_head = work.faces[i].state.cam_from_head;
  }
  const RigidHead rigid = rigid_head(model, work.full_identity(model));
  auto summary = track_dense_head(work.clip, rigid, work.dense, progress, stop, options.withheld.get());
  if (!summary) return summary.error();
  work.points = std::move(summary->points);
  for (std::size_t i = 0; i < work.faces.size(); ++i)
    if (work.dense[i].solved) {
      work.faces[i].state.cam_from_head = work.dense[i].cam_from_head;
      work.faces[i].pose_given = true;
    }
  return {};
}

// Landmarks again, started from where the dense pose says the face is: a bowed head shifts the detector's
// box, and with it the mouth, by a whole lip.
Result<void> find_landmarks_again(const TrackOptions& options, Work& work, const Progress& progress,
                                  std::stop_token stop) {
  auto detector = FaceDetector::load(options.predictor);
  if (!detector) return detector.error();
  const ReducedPerson person = reduced_person(work.head, work.identity);
  const Eigen::VectorXd neutral = Eigen::VectorXd::Zero(work.head.expression_count());
  const Vec2d corner(work.clip.region.x, work.clip.region.y);
  constexpr std::size_t kBatch = 16;
  for (std::size_t from = 0; from < work.faces.size(); from += kBatch) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(static_cast<double>(from) / work.faces.size(), "landmarks from the dense poses");
    parallel_for(std::min(kBatch, work.faces.size() - from), [&](std::size_t k) {
      const std::size_t i = from + k;
      FaceFrame& face = work.faces[i];
      if (!face.pose_given || stop.stop_requested()) return;
      LandmarkHint hint;
      Vec2d low = Vec2d::Constant(1e9), high = Vec2d::Constant(-1e9);
      for (int p = 0; p < kLandmarkCount; ++p) {
        const Vec3d in_cam = face.state.cam_from_head * reduced_point(work.head, person, p, neutral, 0);
        hint.points[p] = project<double>(work.intrinsics[i], in_cam);
        if (p < kJawLineCount) continue;
        low = low.cwiseMin(hint.points[p]);
        high = high.cwiseMax(hint.points[p]);
      }
      // dlib's boxes reach from above the brows to the chin, about 1.5 times as wide as brows and mouth.
      const double side = 1.45 * std::max(high.x() - low.x(), 0.95 * (high.y() - low.y()));
      const Vec2d centre = 0.5 * (low + high) + Vec2d(0, 0.02 * side);
      hint.sigma = 0.02 * side;
      const FaceBox box{centre.x() - 0.5 * side, centre.y() - 0.5 * side, side, side, 0};
      Landmarks found = detector->landmarks(work.clip.frames[i].grey, box, 0, &hint, {8, 32});
      for (int p = 0; p < kLandmarkCount; ++p) {
        found.points[p] = found.points[p] / work.clip.scale + corner;
        found.spread[p] /= work.clip.scale;
      }
      observe(found, work.cameras[i]->intrinsics, work.clip.scale, work.intrinsics[i].fx, &face.observation);
      work.clip.frames[i].landmarks = found;
    });
  }
  progress.report(1);
  return {};
}

// Neighbouring frames vote on the landmarks, and every face is compared with what it looks like elsewhere.
Result<void> cross_check(Work& work, const Progress& progress, std::stop_token stop) {
  auto optical = support_landmarks(work.clip, {}, progress, stop);
  if (!optical) return optical.error();
  work.optical = std::move(*optical);
  const std::size_t n = work.faces.size();
  const Vec2d corner(work.clip.region.x, work.clip.region.y);
  std::vector<FaceLook> looks(n);
  parallel_for(n, [&](std::size_t i) {
    const ClipFrame& source = work.clip.frames[i];
    if (!work.faces[i].seen || !work.cameras[i]) return;
    std::array<Vec2d, kLandmarkCount> px;
    for (int k = 0; k < kLandmarkCount; ++k) px[k] = (source.landmarks->points[k] - corner) * work.clip.scale;
    looks[i] = face_look(source.grey, px);
    observe(*source.landmarks, work.cameras[i]->intrinsics, work.clip.scale, work.intrinsics[i].fx,
            &work.faces[i].observation);
  });
  std::vector<int> training, references;
  for (std::size_t i = 0; i < n; ++i)
    if (!looks[i].values.empty() && !work.faces[i].held_out) training.push_back(static_cast<int>(i));
  const std::size_t step = std::max<std::size_t>(1, training.size() / 48);
  for (std::size_t k = 0; k < training.size(); k += step) references.push_back(training[k]);
  work.look = agreement_of_looks(looks, references);
  return {};
}

// Brows raised so high that the predictor loses them are found by what they look like.
Result<void> find_lost_brows(Work& work, std::stop_token stop) {
  std::vector<BrowPicture> pictures(work.faces.size());
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (work.cameras[i]) pictures[i] = {&work.clip.frames[i].grey, work.intrinsics[i]};
  auto found = correct_brows(work.head, reduced_person(work.head, work.identity), pictures, work.faces, stop);
  if (!found) return found.error();
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    if (!work.faces[i].seen || !work.cameras[i]) continue;
    Landmarks& shown = *work.clip.frames[i].landmarks;
    const FaceObservation& used = work.faces[i].observation;
    for (int k = 17; k < 27; ++k) {
      const Vec2d place = project<double>(work.cameras[i]->intrinsics, Vec3d(used.rays[k].homogeneous()));
      if ((place - shown.points[k]).norm() * work.clip.scale < 0.01) continue;
      shown.points[k] = place;
      shown.spread[k] = used.sigma_px[k] / work.clip.scale;
    }
  }
  return {};
}

// How far the lids are open, by the pixels; evidence for every fit from here on.
Result<void> watch_lids(const HeadModel& model, Work& work, std::stop_token stop) {
  const Vec2d corner(work.clip.region.x, work.clip.region.y);
  std::vector<LidView> views(work.faces.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ClipFrame& source = work.clip.frames[i];
    const FaceFrame& face = work.faces[i];
    if (!face.seen || !face.pose_given) continue;
    views[i] = {&source.grey, work.intrinsics[i], face.state.cam_from_head, {}, face.held_out};
    for (int k = 0; k < kLandmarkCount; ++k)
      views[i].landmarks[k] = (source.landmarks->points[k] - corner) * work.clip.scale;
  }
  const HeadShape person = shape_head(model, work.full_identity(model));
  auto read = read_lids(eye_balls(model, person), views, stop);
  if (!read) return read.error();
  for (std::size_t i = 0; i < views.size(); ++i)
    observe_lids(read->frames[i], read->usual_gap_m, &work.faces[i].observation);
  work.lids = std::move(read->frames);
  return {};
}

bool eyes_shut(const Work& work, std::size_t i) {
  constexpr double kShut = 0.3;  // of the usual opening: there is no iris to look for
  if (work.lids.empty()) return false;
  const LidOpenings& lids = work.lids[i];
  return (lids[0].known || lids[1].known) && (!lids[0].known || lids[0].opening < kShut) &&
         (!lids[1].known || lids[1].opening < kShut);
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

Result<void> fit_faces(const ExpressionPrior& prior, Work& work, const Progress& progress,
                       std::stop_token stop) {
  auto identity =
      fit_identity(work.head, prior, {}, work.identity, work.faces, progress.stage(0, 0.5, "identity"), stop);
  if (!identity) return identity.error();
  work.identity = *identity;
  return fit_states(work.head, work.identity, prior, {}, work.faces, progress.stage(0.5, 1, "frames"), stop);
}

// The person's own surface on top of the identity, and every frame's expression on it.
Result<void> fit_shape(const HeadModel& model, Work& work, const Progress& progress, std::stop_token stop) {
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
  return fit_states(work.head, work.identity, work.prior, {}, work.faces, progress.stage(0.7, 1, "frames"),
                    stop);
}

// Pose, jaw and expression by the pictures themselves, where the dense poses hold the head.
Result<void> refine_on_pictures(const HeadModel& model, Work& work, const Progress& progress,
                                std::stop_token stop) {
  std::vector<PhotometricFrame> pictures(work.faces.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (!work.cameras[i]) continue;
    pictures[i] = {&work.clip.frames[i].grey, work.intrinsics[i],
                   work.cameras[i]->cam_from_world.linear().transpose()};
  }
  auto refined =
      refine_photometric(model, work.shape(model), work.head, reduced_person(work.head, work.identity),
                         work.prior, pictures, {}, work.faces, progress, stop);
  if (!refined) return refined.error();
  return {};
}

void measure_eyes(const HeadModel& model, Work& work) {
  const HeadShape person = work.shape(model);
  const EyeBalls eyes = eye_balls(model, person);
  const Vec2d corner(work.clip.region.x, work.clip.region.y);
  std::vector<std::optional<Gaze>> raw(work.faces.size());
  parallel_for(work.faces.size(), [&](std::size_t i) {
    if (!work.faces[i].seen || eyes_shut(work, i)) return;
    std::array<Vec2d, kLandmarkCount> px;
    for (int k = 0; k < kLandmarkCount; ++k)
      px[k] = (work.clip.frames[i].landmarks->points[k] - corner) * work.clip.scale;
    raw[i] = measure_gaze(work.clip.frames[i].grey, work.intrinsics[i], work.faces[i].state.cam_from_head,
                          eyes, px);
  });
  // Through a blink the last gaze holds; single frames are steadied by their neighbours, held-out ones by
  // none.
  std::optional<Gaze> last, last_training;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const bool held_out = work.faces[i].held_out;
    Gaze sum;
    double weight = 0;
    for (int k = held_out ? 0 : -1; k <= (held_out ? 0 : 1); ++k) {
      const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + k;
      if (j < 0 || j >= static_cast<std::ptrdiff_t>(raw.size()) || !raw[j] ||
          (!held_out && work.faces[j].held_out))
        continue;
      const double w = k == 0 ? 2 : 1;
      sum.yaw += w * raw[j]->yaw, sum.pitch += w * raw[j]->pitch, weight += w;
    }
    if (weight > 0)
      work.gaze[i] = Gaze{sum.yaw / weight, sum.pitch / weight, 0};
    else
      work.gaze[i] = held_out ? last : last_training;
    last = work.gaze[i];
    if (!held_out) last_training = work.gaze[i];
  }
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// What the verdict on a frame rests on.
FrameEvidence evidence_of(const Work& work, std::size_t i, const TrackedFrame& tracked) {
  const ClipFrame& source = work.clip.frames[i];
  FrameEvidence e;
  e.camera_known = work.cameras[i] != nullptr;
  e.seen = work.faces[i].seen;
  e.detected = source.detected;
  e.dense_solved = work.dense[i].solved;
  e.source_px = 1 / work.clip.scale;
  e.inner_error_px = tracked.inner_error_px * work.clip.scale;
  if (source.landmarks) {
    e.cluster_share = source.landmarks->cluster_share;
    e.spread = inner_spread(*source.landmarks) /
               std::max(1.0, (source.landmarks->points[36] - source.landmarks->points[45]).norm());
  }
  if (!work.optical.empty()) {
    e.votes = work.optical[i].votes;
    e.disagreement_px = work.optical[i].disagreement_px * work.clip.scale;
    e.carried = work.optical[i].carried;
  }
  if (!work.look.empty()) e.look = work.look[i];
  return e;
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

std::optional<double> find_scale(const CameraSet& cameras, const Work& work) {
  if (cameras.is_static || cameras.scale == CameraScale::metric) return 1;
  std::vector<HeadSighting> sightings;
  for (std::size_t i = 0; i < work.faces.size(); ++i)
    if (work.faces[i].seen && !work.faces[i].held_out)
      sightings.push_back({work.cameras[i]->cam_from_world, work.faces[i].state.cam_from_head});
  return steady_metres_per_unit(sightings);
}

std::vector<TrackedFrame> describe_frames(const Work& work, const HeadModel& model, double metres_per_unit) {
  const ReducedPerson person = reduced_person(work.head, work.identity);
  std::vector<TrackedFrame> frames(work.faces.size());
  std::vector<double> errors;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    TrackedFrame& out = frames[i];
    const FaceFrame& face = work.faces[i];
    out.frame = face.frame;
    out.time_s = work.clip.frames[i].time_s;
    out.articulation = neutral_articulation(model);
    out.landmarks.fill(Vec2d::Zero());
    if (!face.seen) continue;
    out.landmarks = work.clip.frames[i].landmarks->points;
    if (!work.look.empty()) out.look = work.look[i];
    out.landmark_spread = work.clip.frames[i].landmarks->spread;
    out.inner_error_px = inner_error(work.head, person, face.observation, face.state) / work.clip.scale;
    if (!face.held_out) errors.push_back(out.inner_error_px * work.clip.scale);
    out.articulation.expression = face.state.expression.cast<float>();
    out.articulation.jaw.x() = static_cast<float>(face.state.jaw);
    if (work.gaze[i]) out.articulation.left_eye = out.articulation.right_eye = eye_rotation(*work.gaze[i]);
    const Pose world_from_cam = metric_camera(work.cameras[i]->cam_from_world, metres_per_unit).inverse();
    out.world_from_head = world_from_cam * face.state.cam_from_head;
  }
  const double usual = median_of(errors);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameVerdict verdict = judge_frame(evidence_of(work, i, frames[i]), usual);
    frames[i].status = verdict.status;
    frames[i].reason = verdict.reason;
  }
  bridge_lost(frames);
  return frames;
}

Result<void> add_torso(const Work& work, const HeadModel& model, Track& track, const Progress& progress,
                       std::stop_token stop) {
  const HeadShape person = shape_head(model, track.person);
  const Vec3d chin = landmark_positions(model, person.vertices)[8].cast<double>();
  std::vector<TorsoFrame> frames(track.frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].grey = &work.clip.frames[i].grey;
    frames[i].held_out = work.clip.frames[i].held_out;
    frames[i].usable = work.cameras[i] && track.frames[i].status != FrameStatus::lost;
    frames[i].intrinsics = work.intrinsics[i];
    if (work.cameras[i])
      frames[i].cam_from_world = metric_camera(work.cameras[i]->cam_from_world, track.metres_per_unit);
    frames[i].world_from_head = track.frames[i].world_from_head;
    if (frames[i].usable)
      frames[i].head_outline = head_outline(
          person.vertices, chin, frames[i].cam_from_world * frames[i].world_from_head, frames[i].intrinsics);
  }
  auto torso = track_torso(frames, chin, progress, stop);
  if (!torso) return torso.error();
  track.has_torso = torso->has_torso;
  track.torso_modes = std::move(torso->modes);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    track.frames[i].world_from_torso = torso->world_from_torso[i];
    track.frames[i].torso_shape = torso->shapes[i];
  }
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
  Work work;
  auto clip = read_clip_frames(video, region, held_out, options, progress.stage(0, 0.4, "landmarks"), stop);
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
  start_clip(work.head, work.identity, work.prior, work.faces);
  if (auto fitted = fit_faces(placing_prior(model), work, progress.stage(0.40, 0.45, "first fit"), stop);
      !fitted)
    return fitted.error();
  clock.lap("fit");
  if (options.dense) {
    if (auto dense = refine_poses(model, options, work, progress.stage(0.45, 0.75, "dense head"), stop);
        !dense)
      return dense.error();
    clock.lap("dense head");
    if (auto again = find_landmarks_again(options, work, progress.stage(0.75, 0.85, "landmarks again"), stop);
        !again)
      return again.error();
    clock.lap("landmarks again");
    if (auto checked = cross_check(work, progress.stage(0.85, 0.87, "landmarks followed"), stop); !checked)
      return checked.error();
    clock.lap("landmarks followed");
    if (auto brows = find_lost_brows(work, stop); !brows) return brows.error();
    clock.lap("brows");
    if (auto watched = watch_lids(model, work, stop); !watched) return watched.error();
    clock.lap("lids");
    if (auto fitted = fit_faces(work.prior, work, progress.stage(0.87, 0.89, "second fit"), stop); !fitted)
      return fitted.error();
    clock.lap("fit again");
    if (options.own_shape) {
      if (auto done = fit_shape(model, work, progress.stage(0.89, 0.9, "own shape"), stop); !done)
        return done.error();
      clock.lap("own shape");
    }
    auto settled = fit_from_rest(model, work.head, work.identity, work.prior, {}, work.faces,
                                 progress.stage(0.9, 0.91, "rest"), stop);
    if (!settled) return settled.error();
    work.prior = std::move(*settled);
    clock.lap("rest");
    if (options.photometric)
      if (auto done = refine_on_pictures(model, work, progress.stage(0.91, 0.96, "pictures"), stop); !done)
        return done.error();
    clock.lap("pictures");
  }
  if (options.gaze) measure_eyes(model, work);
  clock.lap("eyes");

  Track track;
  track.head_model_name = model.name;
  track.head_model_hash = model.hash;
  track.person = {work.full_identity(model), work.offsets};
  const std::optional<double> scale = find_scale(cameras, work);
  track.metre_known = scale.has_value();
  track.metres_per_unit = scale.value_or(1.0);
  track.frames = describe_frames(work, model, track.metres_per_unit);
  track.neutral = calibrate_neutral(model, track.frames, held_out);
  if (auto torso = add_torso(work, model, track, progress.stage(0.96, 1, "torso"), stop); !torso)
    return torso.error();
  clock.lap("torso");
  progress.report(1, "tracked");
  return track;
}

}  // namespace likeness
