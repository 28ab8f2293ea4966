// The visual hull of a rigid part of the person: what the mattes of many views agree on in that part's own
// frame. Background that looks like the person in one view is elsewhere in the next.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/linalg.h"
#include "core/camera/camera.h"

namespace likeness {

// The part as one picture sees it.
struct HullView {
  Pose cam_from_part = Pose::Identity();  // m
  Intrinsics picture;
  cv::Mat person;  // 8U, 255 = person
};

// Voxels of `step` m from `low` on in the part's frame, x fastest.
struct Hull {
  Vec3d low = Vec3d::Zero();
  double step = 0;
  std::array<int, 3> count{0, 0, 0};
  std::vector<float> share;  // 0..1: in how large a share of the views the voxel falls on the person, in the
                             // direction of view that contradicts it most

  bool empty() const { return share.empty(); }
};

// Needs views in which the part differs in its surroundings; without any the hull is empty.
Hull carve_hull(const Vec3d& low, const Vec3d& high, double step, const std::vector<HullView>& views);

// 32F, 0..1: the largest share along each pixel's ray.
cv::Mat hull_share(const Hull& hull, const Pose& cam_from_part, const Intrinsics& picture);

}  // namespace likeness
