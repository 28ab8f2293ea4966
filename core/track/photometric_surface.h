// The face as a fine set of skin points with derivatives: what carries albedo and is compared with pictures.
#pragma once

#include <cstdint>
#include <vector>

#include "core/head/pose_head.h"
#include "core/track/reduced_head.h"

namespace likeness {

enum class FaceZone : std::uint8_t { skin, lid, lip };

struct FaceSurface {
  ReducedHead points;               // (N) skin points of the face, the person applied; no identity columns
  ReducedPerson person;             // matches `points`
  std::vector<Triangle> triangles;  // (F) of points
  std::vector<FaceZone> zone;       // (N)
  std::vector<Triangle> interior;   // the mouth's inside, vertices of the model
  std::vector<int> mouth;           // triangles (numbers) around the mouth
  // Points to fit with, thinned evenly: coarse ones for small pictures; lids and lips always denser.
  std::vector<int> coarse, fine;
};

// Triangles are split until half of their edges are shorter than spacing_m; halving it costs four times the
// memory and nothing in the fit.
FaceSurface face_surface(const HeadModel& model, const HeadShape& person, double spacing_m = 0.0016);

struct PosedSurface {
  std::vector<Vec3f> points;   // (N) head frame, m
  std::vector<Vec3f> normals;  // (N) unit
};
PosedSurface posed_surface(const FaceSurface& surface, const Eigen::VectorXd& expression, double jaw);

}  // namespace likeness
