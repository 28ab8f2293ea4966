// Small planar patches of the head, found again in any picture: the reference picture around a point is
// warped as the plane through the point would look under a predicted pose, then shifted until it fits
// (inverse compositional Gauss-Newton, Baker & Matthews, IJCV 2004, on values normalised for mean and
// contrast). Unlike points tracked from picture to picture, errors do not accumulate: a view seen again is
// found where it was, so loops close.
#pragma once

#include <optional>

#include "core/base/linalg.h"
#include "core/camera/camera.h"
#include "core/image/image.h"

namespace likeness {

// A working picture, one channel, and the same at half the size.
struct PatchPicture {
  const Image8* whole = nullptr;
  Image8 half;
};
PatchPicture patch_picture(const Image8& grey);

// A piece of the head's surface, head frame, m, and where it is in its reference picture.
struct HeadPatch {
  Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ();  // normal: unit, outwards
  int reference = -1;                                    // picture
  Vec2d pixel = Vec2d::Zero();                           // in it, px
};

struct PatchView {
  const PatchPicture* picture = nullptr;
  Intrinsics intrinsics;  // of the whole picture
  Pose cam_from_head = Pose::Identity();
};

struct PatchMatch {
  Vec2d pixel;             // px
  double correlation = 0;  // normalised, of the patch with the picture there
};

// Cosine of the angle between the patch's normal and the direction to the camera; <= 0: seen from behind.
double patch_facing(const HeadPatch& patch, const Pose& cam_from_head);

// nullopt if the patch is too slanted, lies at the border, has no texture, moves further than `reach` px from
// the prediction or does not look alike.
std::optional<PatchMatch> find_patch(const HeadPatch& patch, const PatchView& reference,
                                     const PatchView& view, double reach);

}  // namespace likeness
