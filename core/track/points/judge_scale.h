// Whether a camera path of unknown scale can be true, by the size of the head in its pictures. A solve that
// explains the background need not be: a lens that is far too long puts the head far away, and what the
// features' noise feigns is the path of a camera that hardly moved. Pictures of the background alone do not
// tell; a head, whose size is known, does.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera/camera.h"
#include "core/scene/track.h"
#include "core/track/points/camera_scale.h"

namespace likeness {

// m. Generous: what lies outside them nobody films.
struct ScaleLimits {
  double nearest = 0.12, farthest = 8;         // from the camera to the head
  double least_reach = 0.02, most_reach = 30;  // of the camera's places
};

struct ScaleJudgement {
  double distance_m = 0;             // from the camera to the head, median
  double reach_m = 0;                // across the camera's places but the outermost; 0: scale not known
  std::vector<std::string> reasons;  // why the path cannot be true, a plain sentence each
};

// metres_per_unit: as steady_metres_per_unit found it. Without sightings there is nothing to say.
ScaleJudgement judge_scale(const std::vector<HeadSighting>& sightings, std::optional<double> metres_per_unit,
                           const ScaleLimits& limits = {});

// The frames of a track that were followed, before the cameras it was made with.
std::vector<HeadSighting> sightings_of(const Track& track, const CameraSet& cameras);

// A warning for whoever made the clip, with what to do; empty where the path can be true, and for cameras
// whose scale was never in doubt.
std::string scale_warning(const Track& track, const CameraSet& cameras);

}  // namespace likeness
