// Point tracks withheld from the dense adjustment to judge its poses: poses cannot have been fitted to them.
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/linalg.h"
#include "core/camera/camera.h"
#include "core/scene/track.h"

namespace likeness {

struct WithheldObservation {
  int frame = 0;        // number in the source video
  Vec2d ray;            // x/z, y/z
  double focal_px = 0;  // rays times this are working px
};

struct WithheldTrack {
  Vec3d start = Vec3d::Zero();            // first guess of the point, head frame, m
  std::vector<WithheldObservation> seen;  // ascending frame
};

struct WithheldPoints {
  double share = 0.15;                // in: of the point tracks
  std::vector<WithheldTrack> tracks;  // out
};

// Whether the index-th of the tracks found is held back: the same for every run.
bool is_withheld(std::size_t index, double share);

struct WithheldScore {
  int tracks = 0, on_head = 0;  // on_head: moved with the head, judged by the even observations only
  int observations = 0;         // scored
  double median_px = 0, p90_px = 0;
};

// Each point is solved from its even observations with the track's poses fixed; the odd ones are scored.
WithheldScore score_withheld(const WithheldPoints& points, const Track& track, const CameraSet& cameras);

}  // namespace likeness
