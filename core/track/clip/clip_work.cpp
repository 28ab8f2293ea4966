// Evidence from the pictures for the fits of a clip: see clip_work.h.
#include "core/track/clip/clip_work.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/parallel_batches.h"
#include "core/base/quantile.h"
#include "core/face/observe_face.h"
#include "core/track/fit/choose_rest.h"
#include "core/track/frame_spacing.h"
#include "core/track/photo/brow_line.h"
#include "core/track/photo/face_look.h"

namespace likeness {
namespace {

bool eyes_shut(const ClipWork& work, std::size_t i) {
  constexpr double kShut = 0.3;  // of the usual opening: there is no iris to look for
  if (work.lids.empty()) return false;
  const LidOpenings& lids = work.lids[i];
  return (lids[0].known || lids[1].known) && (!lids[0].known || lids[0].opening < kShut) &&
         (!lids[1].known || lids[1].opening < kShut);
}

}  // namespace

void prepare(const CameraSet& cameras, const HeadModel& model, ClipWork& work) {
  const std::size_t n = work.clip.frames.size();
  work.spacing = frame_spacing(work.clip.frames);
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
    face.shot = source.shot;
    face.state.expression = Eigen::VectorXd::Zero(work.head.expression_count());
    if (!work.cameras[i]) continue;
    work.intrinsics[i] = working_intrinsics(work.cameras[i]->intrinsics, work.clip);
    face.seen = source.landmarks.has_value();
    if (face.seen)
      face.observation = observe_face(*source.landmarks, work.cameras[i]->intrinsics, work.clip.scale,
                                      work.intrinsics[i].fx, face.observation);
  }
}

Result<void> find_landmarks_again(const TrackOptions& options, ClipWork& work, const Progress& progress,
                                  std::stop_token stop) {
  auto detector = FaceDetector::load(options.predictor);
  if (!detector) return detector.error();
  detector->keep_in(options.kept_work);
  const ReducedPerson person = reduced_person(work.head, work.identity);
  const Vec2d corner(work.clip.region.x, work.clip.region.y);
  const auto find = [&](std::size_t i) {
    FaceFrame& face = work.faces[i];
    if (!face.pose_given || stop.stop_requested()) return;
    const ExpectedFace expected =
        expect_face(work.head, person, work.intrinsics[i], face.state.cam_from_head);
    Landmarks found = detector->landmarks(work.clip.frames[i].grey, expected.box, 0, &expected.hint, {8, 32});
    for (int p = 0; p < kLandmarkCount; ++p) {
      found.points[p] = found.points[p] / work.clip.scale + corner;
      found.spread[p] /= work.clip.scale;
    }
    face.observation = observe_face(found, work.cameras[i]->intrinsics, work.clip.scale,
                                    work.intrinsics[i].fx, face.observation);
    work.clip.frames[i].landmarks = found;
  };
  return parallel_batches(work.faces.size(), 16, find, progress, stop);
}

Result<void> cross_check(ClipWork& work, const Progress& progress, std::stop_token stop) {
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
    FaceObservation& own = work.faces[i].observation;
    own = observe_face(*source.landmarks, work.cameras[i]->intrinsics, work.clip.scale, work.intrinsics[i].fx,
                       own);
  });
  std::vector<int> training, references;
  for (std::size_t i = 0; i < n; ++i)
    if (!looks[i].values.empty() && !work.faces[i].held_out) training.push_back(static_cast<int>(i));
  const std::size_t step = std::max<std::size_t>(1, training.size() / 48);
  for (std::size_t k = 0; k < training.size(); k += step) references.push_back(training[k]);
  work.look = agreement_of_looks(looks, references);
  return {};
}

Result<void> find_lost_brows(ClipWork& work, std::stop_token stop) {
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

Result<void> watch_lids(const HeadModel& model, ClipWork& work, std::stop_token stop) {
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
  const HeadShape person = work.shape(model);
  auto read = read_lids(eye_balls(model, person), views, stop);
  if (!read) return read.error();
  for (std::size_t i = 0; i < views.size(); ++i)
    observe_lids(read->frames[i], read->usual_gap_m, &work.faces[i].observation);
  work.lids = std::move(read->frames);
  return {};
}

void find_rest(const TrackOptions& options, ClipWork& work) {
  constexpr double kAgrees =
      0.4;  // of the face's look (frame_verdict.cpp): what covers a face is no expression
  const ReducedPerson person = reduced_person(work.head, work.identity);
  std::vector<RestFrame> frames(work.faces.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FaceFrame& face = work.faces[i];
    frames[i].frame = face.frame;
    frames[i].time_s = work.clip.frames[i].time_s;
    if (!face.seen || face.held_out) continue;
    frames[i].usable = work.look.empty() || work.look[i] >= kAgrees;
    frames[i].face = measure_face(work.head, person, face.observation, face.state.cam_from_head);
    if (work.lids.empty()) continue;
    for (const LidOpening& lid : work.lids[i]) {
      if (!lid.known || (frames[i].lids_known && lid.opening > frames[i].lids)) continue;
      frames[i].lids_known = true;
      frames[i].lids = lid.opening;
    }
  }
  work.rest = choose_rest(frames, usual_mouth(work.head), options.rest_frames);
  for (FaceFrame& face : work.faces) face.rest = std::ranges::binary_search(work.rest.frames, face.frame);
}

void leave_out_parted(ClipWork& work) {
  constexpr double kApart = 0.0015;  // m beyond the rest's own: the error of a reading of closed lips
  if (work.rest.asked) return;
  std::vector<double> gaps;
  std::vector<int> parted;
  const auto for_each_read = [&](auto&& use) {
    for (const FaceFrame& face : work.faces)
      if (face.rest && face.observation.lips.known) use(face, face.observation.lips);
  };
  for_each_read([&](const FaceFrame&, const LipEvidence& lips) { gaps.push_back(lips.gap_m); });
  const double usual = median(gaps);
  for_each_read([&](const FaceFrame& face, const LipEvidence& lips) {
    if (lips.gap_m > usual + kApart + 2 * lips.sigma_m) parted.push_back(face.frame);
  });
  std::erase_if(work.rest.frames, [&](int frame) { return std::ranges::binary_search(parted, frame); });
  for (FaceFrame& face : work.faces) face.rest = std::ranges::binary_search(work.rest.frames, face.frame);
}

Result<void> measure_eyes(const HeadModel& model, ClipWork& work, const Progress& progress,
                          std::stop_token stop) {
  const HeadShape person = work.shape(model);
  const EyeBalls eyes = eye_balls(model, person);
  const Vec2d corner(work.clip.region.x, work.clip.region.y);
  std::vector<std::optional<Gaze>> raw(work.faces.size());
  const auto measure = [&](std::size_t i) {
    if (!work.faces[i].seen || eyes_shut(work, i)) return;
    std::array<Vec2d, kLandmarkCount> px;
    for (int k = 0; k < kLandmarkCount; ++k)
      px[k] = (work.clip.frames[i].landmarks->points[k] - corner) * work.clip.scale;
    raw[i] = measure_gaze(work.clip.frames[i].grey, work.intrinsics[i], work.faces[i].state.cam_from_head,
                          eyes, px);
  };
  if (auto measured = parallel_batches(raw.size(), 16, measure, progress, stop); !measured) return measured;
  // Through a blink the last gaze holds; single frames are steadied by their neighbours, held-out ones by
  // none.
  std::optional<Gaze> last, last_training;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const bool held_out = work.faces[i].held_out;
    const int shot = work.faces[i].shot;
    if (i > 0 && work.faces[i - 1].shot != shot) last.reset(), last_training.reset();
    Gaze sum;
    double weight = 0;
    const int reach = held_out || work.spacing == 0 ? 0 : 1;
    for (int k = -reach; k <= reach; ++k) {
      const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + k;
      if (j < 0 || j >= static_cast<std::ptrdiff_t>(raw.size()) || !raw[j] ||
          (!held_out && work.faces[j].held_out) || work.faces[j].shot != shot)
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
  return {};
}

}  // namespace likeness
