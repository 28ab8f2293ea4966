#include "core/track/points/dense_head.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/track/points/dense_patches.h"
#include "core/track/points/point_tracks.h"

namespace likeness {
namespace {

constexpr int kAnchors = 3;             // training frames a held-out frame is compared with
constexpr std::size_t kLoneBatch = 64;  // frames whose pyramids are in memory at once
constexpr int kFewestTracks = 20, kMaxPatches = 3000;
constexpr double kNeckRest = 60;           // per m; five times as much pulls the face away from its landmarks
constexpr double kPatchReach[] = {12, 5};  // px; the first poses have drifted, the second hardly

Vec2d ray_of(const Intrinsics& k, const Vec2d& pixel) { return ray_direction(k, pixel).head<2>(); }

double pose_distance(const Pose& a, const Pose& b) {
  return vector_from_turn(a.linear() * b.linear().transpose()).norm() +
         2.0 * (a.translation() - b.translation()).norm();
}

// The training frames nearest in pose, at least a few frames apart from each other.
std::vector<int> anchors_of(const std::vector<DenseFrame>& frames, const std::vector<int>& training,
                            int frame) {
  std::vector<std::pair<double, int>> order;
  for (int t : training)
    if (frames[t].solved)
      order.push_back({pose_distance(frames[t].cam_from_head, frames[frame].cam_from_head), t});
  std::sort(order.begin(), order.end());
  std::vector<int> chosen;
  for (const auto& next : order) {
    const int t = next.second;
    if (std::any_of(chosen.begin(), chosen.end(), [&](int c) { return std::abs(c - t) < 5; })) continue;
    chosen.push_back(t);
    if (static_cast<int>(chosen.size()) == kAnchors) break;
  }
  return chosen;
}

struct FrozenPoint {
  int track;
  Vec2d pixel;  // in the anchor's picture
};

class FrameAlone {
 public:
  FrameAlone(const ClipFrames& clip, const std::vector<BundleTrack>& tracks, std::vector<DenseFrame>& frames,
             const std::vector<std::vector<FrozenPoint>>& frozen, const PatchCloud& cloud,
             const std::vector<BundleFrame>& poses)
      : clip_(clip), tracks_(tracks), frames_(frames), frozen_(frozen), cloud_(cloud), poses_(poses) {}

  void solve(int frame, const std::vector<int>& training) const {
    DenseFrame& f = frames_[frame];
    const BundleOptions options;
    const TrackPicture picture(clip_.frames[frame].grey);
    const Pose prior = f.cam_from_head;
    const std::vector<int> anchors = anchors_of(frames_, training, frame);
    for (int pass = 0; pass < 2; ++pass) {  // the second pass starts from a better guess of where points are
      std::vector<PoseObservation> seen;
      for (int anchor : anchors) observe(picture, frame, anchor, &seen);
      const auto pose = solve_pose(seen, f.intrinsics.fx, f.cam_from_head, options);
      if (!pose || pose->inliers < 12 || pose_distance(pose->cam_from_head, prior) > 0.5) continue;
      f.cam_from_head = pose->cam_from_head;
      f.solved = true;
      f.points = pose->inliers;
      f.median_px = pose->median_px;
    }
    if (f.solved) settle_on_patches(frame);
  }

 private:
  void settle_on_patches(int frame) const {
    DenseFrame& f = frames_[frame];
    for (double reach : kPatchReach) {
      std::vector<PoseObservation> seen;
      for (const FoundPatch& p : find_patches(cloud_, poses_, frame, f.cam_from_head, reach))
        seen.push_back({tracks_[p.track].point, p.seen.ray});
      const auto pose = solve_pose(seen, f.intrinsics.fx, f.cam_from_head, {});
      if (!pose || pose->inliers < 12) return;
      f.cam_from_head = pose->cam_from_head;
      f.points = pose->inliers;
      f.median_px = pose->median_px;
    }
  }

  void observe(const TrackPicture& picture, int frame, int anchor, std::vector<PoseObservation>* seen) const {
    const DenseFrame& f = frames_[frame];
    const TrackPicture from(clip_.frames[anchor].grey);
    std::vector<Vec2d> points, guesses;
    std::vector<Vec3d> places;
    for (const FrozenPoint& p : frozen_[anchor]) {
      const Vec3d in_cam = f.cam_from_head * tracks_[p.track].point;
      if (in_cam.z() < 0.05) continue;
      points.push_back(p.pixel);
      guesses.push_back(project<double>(f.intrinsics, in_cam));
      places.push_back(tracks_[p.track].point);
    }
    const auto found = follow_points(from, picture, points, guesses, 0.5);
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i]) seen->push_back({places[i], ray_of(f.intrinsics, *found[i])});
  }

  const ClipFrames& clip_;
  const std::vector<BundleTrack>& tracks_;
  std::vector<DenseFrame>& frames_;
  const std::vector<std::vector<FrozenPoint>>& frozen_;
  const PatchCloud& cloud_;
  const std::vector<BundleFrame>& poses_;
};

}  // namespace

Intrinsics working_intrinsics(const Intrinsics& source, const ClipFrames& clip) {
  Intrinsics k = source;
  const Image8& grey = clip.frames.front().grey;
  const double sx = static_cast<double>(grey.width) / clip.region.width,
               sy = static_cast<double>(grey.height) / clip.region.height;
  k.width = grey.width;
  k.height = grey.height;
  k.fx *= sx, k.fy *= sy;
  k.cx = (k.cx - clip.region.x) * sx;
  k.cy = (k.cy - clip.region.y) * sy;
  return k;
}

Result<DenseSummary> track_dense_head(const ClipFrames& clip, const RigidHead& head, bool resting_camera,
                                      std::vector<DenseFrame>& frames, const Progress& progress,
                                      std::stop_token stop, WithheldPoints* withheld) {
  DenseSummary summary;
  std::vector<int> training;
  std::vector<const Image8*> grey;
  std::vector<int> shots;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    grey.push_back(&clip.frames[i].grey);
    shots.push_back(clip.frames[i].shot);
    if (frames[i].known && !clip.frames[i].held_out) training.push_back(static_cast<int>(i));
  }
  // -- Tracks through the training frames.
  const auto mask = [&](int i) { return corner_mask(head, frames[i].intrinsics, frames[i].cam_from_head); };
  auto found = track_points(grey, training, mask, {}, progress.stage(0, 0.5, "points"), stop, shots);
  if (!found) return found.error();
  std::vector<BundleTrack> tracks;
  std::vector<Vec3d> normals;
  std::vector<std::uint8_t> on_skin;
  double length = 0;
  std::size_t index = 0;
  for (const PointTrack& t : *found) {
    // A point is initialised from the middle of its track, where the view is least slanted and the landmark
    // pose as good as anywhere.
    const PointObservation& middle = t.seen[t.seen.size() / 2];
    const DenseFrame& f = frames[middle.picture];
    const auto place = point_on_head(head, f.cam_from_head, ray_of(f.intrinsics, middle.pixel));
    if (!place) continue;
    if (withheld && is_withheld(index++, withheld->share)) {
      withheld->tracks.push_back({place->point, {}});
      for (const PointObservation& o : t.seen) {
        const Intrinsics& k = frames[o.picture].intrinsics;
        withheld->tracks.back().seen.push_back({clip.frames[o.picture].frame, ray_of(k, o.pixel), k.fx});
      }
      continue;
    }
    BundleTrack track;
    track.point = place->point;
    for (const PointObservation& o : t.seen)
      track.seen.push_back({o.picture, ray_of(frames[o.picture].intrinsics, o.pixel)});
    tracks.push_back(std::move(track));
    normals.push_back(place->normal);
    on_skin.push_back(!place->hair);
    length += static_cast<double>(t.seen.size());
  }
  summary.found_tracks = static_cast<int>(tracks.size());
  summary.mean_track_length = tracks.empty() ? 0 : length / static_cast<double>(tracks.size());
  if (static_cast<int>(tracks.size()) < kFewestTracks) {
    progress.report(1);
    return summary;  // a smooth, blurred or tiny head: the landmark poses are kept
  }
  // -- Bundle adjustment.
  std::vector<BundleFrame> poses(frames.size());
  for (int t : training) poses[t] = {true, frames[t].intrinsics.fx, frames[t].cam_from_head, shots[t]};
  BundleOptions options;
  if (resting_camera) options.neck_rest = kNeckRest;
  auto bundle = bundle_adjust(poses, tracks, options, progress.stage(0.5, 0.6, "bundle"), stop);
  if (!bundle) return bundle.error();
  std::vector<int> followed(frames.size(), 0);  // observations behind each first pose
  for (const BundleTrack& t : tracks)
    if (t.kept)
      for (const BundleObservation& o : t.seen) ++followed[o.frame];
  // -- Points followed from picture to picture have drifted with the light; so they are searched for again as
  // patches.
  PatchCloud cloud;
  cloud.pictures.resize(frames.size());
  for (const DenseFrame& f : frames) cloud.intrinsics.push_back(f.intrinsics);
  parallel_for(frames.size(), [&](std::size_t i) {
    if (frames[i].known) cloud.pictures[i] = patch_picture(clip.frames[i].grey);
  });
  const std::vector<BundleFrame> first_poses = poses;
  const std::vector<BundleTrack> first_tracks = tracks;
  double from = 0.6;
  for (double reach : kPatchReach) {
    choose_patches(tracks, normals, poses, kMaxPatches, &cloud);
    observe_again(cloud, poses, training, reach, &tracks, stop);
    const auto known_again =
        std::count_if(tracks.begin(), tracks.end(), [](const BundleTrack& t) { return t.kept; });
    if (known_again < kFewestTracks && !stop.stop_requested()) {  // blurred: the tracked points are kept
      poses = first_poses, tracks = first_tracks;
      break;
    }
    options.rounds = 2;
    bundle = bundle_adjust(poses, tracks, options, progress.stage(from, from + 0.12, "bundle"), stop);
    if (!bundle) return bundle.error();
    from += 0.12;
  }
  summary.bundle = *bundle;
  std::vector<std::vector<FrozenPoint>> frozen(frames.size());
  std::vector<std::vector<double>> residuals(frames.size());
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (!tracks[t].kept) continue;
    for (const BundleObservation& o : tracks[t].seen) {
      const Vec3d ray(o.ray.x(), o.ray.y(), 1);
      frozen[o.frame].push_back({static_cast<int>(t), project<double>(frames[o.frame].intrinsics, ray)});
      const Vec3d p = poses[o.frame].cam_from_head * tracks[t].point;
      residuals[o.frame].push_back((p.hnormalized() - o.ray).norm() * poses[o.frame].focal_px);
    }
  }
  double turn = 0, shift = 0;
  for (int t : training) {
    const Pose &was = frames[t].cam_from_head, &is = poses[t].cam_from_head;
    turn += vector_from_turn(is.linear() * was.linear().transpose()).squaredNorm();
    shift += (is.translation() - was.translation()).squaredNorm();
    auto& r = residuals[t];
    frames[t].points = static_cast<int>(r.size());
    if (r.size() < 12) {  // no patch is found again here: the tracked points' pose, or none
      frames[t].solved = followed[t] >= 12;
      if (frames[t].solved) frames[t].cam_from_head = first_poses[t].cam_from_head;
      continue;
    }
    frames[t].median_px = median(r);
    frames[t].cam_from_head = is;
    frames[t].solved = true;
  }
  summary.turn_change_deg = std::sqrt(turn / static_cast<double>(training.size())) * 180 / std::numbers::pi;
  summary.shift_change_m = std::sqrt(shift / static_cast<double>(training.size()));
  // -- Held-out frames, each alone.
  std::vector<int> alone;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].known && clip.frames[i].held_out) alone.push_back(static_cast<int>(i));
  const FrameAlone solver(clip, tracks, frames, frozen, cloud, poses);
  for (std::size_t k = 0; k < alone.size(); k += kLoneBatch) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(0.85 + 0.15 * static_cast<double>(k) / alone.size(),
                    "tracking held-out frames by themselves");
    try {
      parallel_for(std::min(kLoneBatch, alone.size() - k), [&](std::size_t j) {
        if (!stop.stop_requested()) solver.solve(alone[k + j], training);
      });
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& e) {
      return Error{ErrorCode::failed, "Tracking a held-out frame failed: " + std::string(e.what()),
                   "Run the fit again; if it fails again, report this message.", "dense tracks"};
    }
  }
  if (stop.stop_requested()) return cancelled_error();
  for (std::size_t t = 0; t < tracks.size(); ++t)
    if (tracks[t].kept) summary.points.push_back({std::move(tracks[t]), on_skin[t] != 0});
  progress.report(1);
  return summary;
}

}  // namespace likeness
