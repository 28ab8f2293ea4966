// See face_patch.h.
#include "core/face/face_patch.h"

#include <algorithm>
#include <cmath>

namespace likeness {
namespace {

constexpr LandmarkEffort kPatchEffort{4, 12};  // a patch is one of hundreds
constexpr double kSurroundings = 0.8;          // of the box's width, kept round it
constexpr int kMaxPatch = 640;                 // px a patch is reduced to: the face is then 250 px wide
constexpr double kMinAgreement = 0.45;         // share of the landmark runs

}  // namespace

FacePatch cut_face_patch(const Image8& picture, const FaceBox& face) {
  const int x = static_cast<int>(std::floor(face.x - kSurroundings * face.width)),
            y = static_cast<int>(std::floor(face.y - kSurroundings * face.height)),
            width = static_cast<int>(std::ceil((1 + 2 * kSurroundings) * face.width)),
            height = static_cast<int>(std::ceil((1 + 2 * kSurroundings) * face.height));
  FacePatch patch{crop(picture, x, y, width, height), double(x), double(y), 1, {}};
  if (const int longer = std::max(width, height); longer > kMaxPatch) {
    patch.scale = double(longer) / kMaxPatch;
    patch.luma = resize(patch.luma, std::max(1, int(std::lround(width / patch.scale))),
                        std::max(1, int(std::lround(height / patch.scale))));
  }
  patch.face = {(face.x - x) / patch.scale, (face.y - y) / patch.scale, face.width / patch.scale,
                face.height / patch.scale, face.score};
  return patch;
}

std::optional<Landmarks> patch_landmarks(const FaceDetector& detector, const FacePatch& patch) {
  Landmarks found = detector.landmarks(patch.luma, patch.face, 0, nullptr, kPatchEffort);
  if (found.cluster_share < kMinAgreement) return std::nullopt;
  for (int k = 0; k < kLandmarkCount; ++k) {
    found.points[k] = found.points[k] * patch.scale + Vec2d(patch.x, patch.y);
    found.spread[k] *= patch.scale;
  }
  return found;
}

}  // namespace likeness
