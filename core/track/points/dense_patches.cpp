#include "core/track/points/dense_patches.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace likeness {
namespace {

constexpr std::size_t kFewestSightings = 8;

// Index into the track's observations, or -1.
int best_reference(const BundleTrack& track, const HeadPatch& patch, const std::vector<BundleFrame>& frames) {
  int best = -1;
  double most = -1e9;
  for (std::size_t i = 0; i < track.seen.size(); ++i) {
    const BundleFrame& f = frames[track.seen[i].frame];
    const Vec3d p = f.cam_from_head * track.point;
    if (p.z() < 0.05) continue;
    const double off = (p.hnormalized() - track.seen[i].ray).norm() * f.focal_px;
    const double worth = patch_facing(patch, f.cam_from_head) - 0.1 * off;
    if (worth > most) most = worth, best = static_cast<int>(i);
  }
  return best;
}

PatchView view_of(const PatchCloud& cloud, int frame, const Pose& pose) {
  return {&cloud.pictures[frame], cloud.intrinsics[frame], pose};
}

}  // namespace

void choose_patches(const std::vector<BundleTrack>& tracks, const std::vector<Vec3d>& normals,
                    const std::vector<BundleFrame>& frames, int most, PatchCloud* cloud) {
  cloud->patches.clear(), cloud->track.clear();
  std::vector<int> order;
  for (std::size_t t = 0; t < tracks.size(); ++t)
    if (tracks[t].kept) order.push_back(static_cast<int>(t));
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return tracks[a].seen.size() > tracks[b].seen.size(); });
  for (int t : order) {
    if (static_cast<int>(cloud->patches.size()) == most) break;
    HeadPatch patch{tracks[t].point, normals[t]};
    const int best = best_reference(tracks[t], patch, frames);
    if (best < 0) continue;
    const BundleObservation& o = tracks[t].seen[best];
    patch.reference = o.frame;
    patch.pixel = project<double>(cloud->intrinsics[o.frame], Vec3d(o.ray.x(), o.ray.y(), 1));
    cloud->patches.push_back(patch);
    cloud->track.push_back(t);
  }
}

std::vector<FoundPatch> find_patches(const PatchCloud& cloud, const std::vector<BundleFrame>& reference_poses,
                                     int frame, const Pose& cam_from_head, double reach) {
  std::vector<FoundPatch> found;
  const PatchView view = view_of(cloud, frame, cam_from_head);
  for (std::size_t i = 0; i < cloud.patches.size(); ++i) {
    const HeadPatch& patch = cloud.patches[i];
    Vec2d pixel = patch.pixel;
    if (patch.reference != frame) {
      const auto match =
          find_patch(patch, view_of(cloud, patch.reference, reference_poses[patch.reference].cam_from_head),
                     view, reach);
      if (!match) continue;
      pixel = match->pixel;
    }
    found.push_back({cloud.track[i], {frame, ray_direction(view.intrinsics, pixel).head<2>()}});
  }
  return found;
}

void observe_again(const PatchCloud& cloud, const std::vector<BundleFrame>& frames,
                   const std::vector<int>& where, double reach, std::vector<BundleTrack>* tracks,
                   const std::stop_token& stop) {
  std::vector<std::vector<FoundPatch>> found(where.size());
  parallel_for(where.size(), [&](std::size_t k) {
    if (!stop.stop_requested())
      found[k] = find_patches(cloud, frames, where[k], frames[where[k]].cam_from_head, reach);
  });
  for (BundleTrack& t : *tracks) t.seen.clear(), t.kept = false;
  for (const auto& frame : found)  // ascending frames
    for (const FoundPatch& f : frame) (*tracks)[f.track].seen.push_back(f.seen);
  for (BundleTrack& t : *tracks) t.kept = t.seen.size() >= kFewestSightings;
}

}  // namespace likeness
