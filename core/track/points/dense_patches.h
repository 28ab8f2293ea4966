// Second half of the dense head tracking: the points of the adjusted tracks become patches with one reference
// picture each, which are searched for in every picture from its predicted pose.
#pragma once

#include <stop_token>
#include <vector>

#include "core/track/points/bundle.h"
#include "core/track/points/patch_search.h"

namespace likeness {

struct PatchCloud {
  std::vector<HeadPatch> patches;
  std::vector<int> track;              // of the bundle, one per patch
  std::vector<PatchPicture> pictures;  // of every frame
  std::vector<Intrinsics> intrinsics;  // of every frame's working picture
};

// One patch for each kept track, up to `most`, longest tracks first. normals: of the tracks. Its reference is
// the frame that sees it most squarely among those whose pose explains it best.
void choose_patches(const std::vector<BundleTrack>& tracks, const std::vector<Vec3d>& normals,
                    const std::vector<BundleFrame>& frames, int most, PatchCloud* cloud);

// The patches found in one frame under `cam_from_head`. reference_poses: of all frames.
struct FoundPatch {
  int track = 0;
  BundleObservation seen;
};
std::vector<FoundPatch> find_patches(const PatchCloud& cloud, const std::vector<BundleFrame>& reference_poses,
                                     int frame, const Pose& cam_from_head, double reach);

// Replaces the tracks' observations by the places of their patches in the frames of `where`; tracks without a
// patch, or found in fewer than 8 frames, are dropped. Parallel; same result on any number of threads.
void observe_again(const PatchCloud& cloud, const std::vector<BundleFrame>& frames,
                   const std::vector<int>& where, double reach, std::vector<BundleTrack>* tracks,
                   const std::stop_token& stop);

}  // namespace likeness
