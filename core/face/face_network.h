// Faces by three small networks (core/network/installed_networks.h): face_detector finds them, face468 draws
// 468 points on one, and iris draws the margins of its lids, which face468 leaves open when they close. The
// points need a region of the picture that fits the face with its eyes level; those of the picture before, or
// of a first look, give the next, so that the detector is asked only where nothing is known. RGB; a picture
// of one channel counts as grey. Pixels of the picture given.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

inline constexpr int kMeshCount = 468;

// The square that the points are drawn in.
struct MeshRegion {
  Vec2d centre = Vec2d::Zero();  // px
  double side = 0;               // px
  double roll = 0;               // rad by which the eyes' line turns from x towards y in the picture
};

struct FaceMesh {
  std::array<Vec2d, kMeshCount> points;  // px
  double presence = 0;                   // 0..1, how sure a face is there
  MeshRegion region;                     // that they were drawn in
};

// What the points of a face ask for: their box, with the eyes level, and half as much again.
MeshRegion region_round(const std::array<Vec2d, kMeshCount>& points);

// Whether points drawn in one region would hardly change in the other.
bool is_same_region(const MeshRegion& a, const MeshRegion& b);

// The margins of an eye's lids, px: 0..8 the lower one from the inner corner to the outer, 9..15 the upper
// one between them. Both are those of the subject's right eye, then of the left.
inline constexpr int kLidCount = 16;
using LidMargins = std::array<std::array<Vec2d, kLidCount>, 2>;

// A face that the detector sees, before any points are drawn.
struct FaceCandidate {
  MeshRegion region;
  double score = 0;  // 0..1
};

class FaceNetwork {
 public:
  // missing_dependency: one of the three is not installed. 15 ms.
  static Result<FaceNetwork> installed();
  ~FaceNetwork();
  FaceNetwork(FaceNetwork&&) noexcept;
  FaceNetwork& operator=(FaceNetwork&&) noexcept;

  // The const members may run on many threads at once.

  // One look, 4 ms. The network draws a face into anything: see `presence`. nullopt: the region is empty.
  std::optional<FaceMesh> look(const Image8& picture, const MeshRegion& region) const;
  // Looks again in the region that the points ask for, until it stays, three times at most. nullopt: no face
  // there.
  std::optional<FaceMesh> settle(const Image8& picture, const MeshRegion& start) const;
  // The lids of a face with these points, 8 ms. nullopt: an eye is not in the picture.
  std::optional<LidMargins> lids(const Image8& picture, const std::array<Vec2d, kMeshCount>& points) const;
  // The detector on one square of the picture, 3 ms; what lies outside the picture is black.
  std::vector<FaceCandidate> candidates(const Image8& picture, double x, double y, double side) const;
  // Faces with their points, the surest first. The whole picture is searched; where there is nothing, squares
  // of it, in which a face is larger. 7 ms a face if the whole picture shows it, 80 ms if there is none.
  std::vector<FaceMesh> find(const Image8& picture) const;

 private:
  struct Impl;
  explicit FaceNetwork(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
