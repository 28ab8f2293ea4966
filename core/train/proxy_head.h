// A head that can be looked at from anywhere, made of what a clip and the head model know together: the
// fitted surface, its scalp raised to the hair's hull, coloured by the clip's own pictures and, where none
// shows a place, by the places around it.
#pragma once

#include <vector>

#include "core/head/pose_head.h"
#include "core/train/proxy_picture.h"

namespace likeness {

struct ProxyHead {
  HeadShape shape;
  std::vector<Triangle> triangles;  // of the model, but for what belongs to a bust
  std::vector<float> hair;          // (V) m outwards along the normal
  std::vector<Vec3f> colours;       // (V) sRGB-encoded, [0, 1]
  float base = 0, brow = 0;         // m, head frame: heights of the neck's base and of the brows
  float axis_z = 0;                 // m, head frame: depth of the neck's axis
  // Shares of the mattes' pixels above the chin and above the brows that lie outside its silhouette: hair
  // that hangs, hats, hands.
  double unexplained = 1, crown_unexplained = 1;
};

// From own views; they need mattes.
ProxyHead make_proxy_head(const TrainingSet& set, const HeadShape& shape);

// (V) vertices in the head frame, m.
std::vector<Vec3f> pose_proxy(const HeadModel& model, const ProxyHead& proxy,
                              const Articulation& articulation);

// To be drawn; refers to both.
ProxyPart head_part(const HeadModel& model, const ProxyHead& proxy);

}  // namespace likeness
