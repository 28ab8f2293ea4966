// The jaw line as a camera sees it on a turned head. On a frontal face the 17 contour landmarks lie on the
// jaw; turned, the side that faces away ends at a silhouette nearer to the nose. FLAME's landmark embeddings
// hold a table of where (flame_dynamic_embedding.npy, landmark_embedding.npy: one row a degree, 39 to each
// side).
#pragma once

#include <array>
#include <vector>

#include "core/base/linalg.h"

namespace likeness {

inline constexpr int kContourCount = 17;  // landmarks 0..16, subject's right first

struct SurfacePoint {
  int triangle = 0;
  Vec3f barycentric = Vec3f::Zero();
};
using ContourRow = std::array<SurfacePoint, kContourCount>;

struct DynamicContour {
  std::vector<ContourRow> rows;  // (2L + 1): yaw -L .. L degrees; the middle one is the frontal face

  int limit_deg() const { return (int(rows.size()) - 1) / 2; }
};

// The contour for a yaw relative to the camera, rad, positive where the subject turns to its own left: the
// row of the nearest degree; beyond the table its last row. Precondition: the table is not empty.
const ContourRow& contour_at(const DynamicContour& contour, double yaw);

}  // namespace likeness
