// The face as a fine set of skin points with derivatives: it carries the albedo and is compared with
// pictures.
#pragma once

#include <cstdint>
#include <vector>

#include "core/face/reduced_head.h"
#include "core/head/pose_head.h"

namespace likeness {

enum class FaceZone : std::uint8_t { skin, lid, lip };

// Points that follow expression and jaw, and their triangles.
struct MovingSurface {
  ReducedHead points;    // (N) the person applied; no identity columns
  ReducedPerson person;  // matches `points`
  std::vector<Triangle> triangles;
};

// The mouth and its surroundings: evaluated for many openings per picture, it is posed separately.
struct MouthSurface : MovingSurface {
  std::vector<int> skin;           // (S) the face's points that the first S points are; then the inside's
  std::size_t skin_triangles = 0;  // the first ones; then the inside's
};

// The skin of the face.
struct FaceSurface : MovingSurface {
  std::vector<FaceZone> zone;  // (N)
  MouthSurface mouth;
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
PosedSurface posed_surface(const MovingSurface& surface, const Eigen::VectorXd& expression, double jaw);

}  // namespace likeness
