// What is asked of hand-held cameras besides solving them: see handheld.h.
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/camera/align_view.h"
#include "core/camera/assumed_lens.h"
#include "core/camera/handheld.h"

namespace likeness {

double share_with_texture(std::span<const HandheldFrame> frames) {
  constexpr std::size_t kLooks = 12;
  const std::size_t looks = std::min(kLooks, frames.size());
  std::vector<char> told(looks, 0);
  parallel_for(looks, [&](std::size_t i) {
    const HandheldFrame& frame = frames[(2 * i + 1) * frames.size() / (2 * looks)];
    const auto pyramid = grey_pyramid(grey_picture(*frame.grey, frame.person, kSpoiltRim),
                                      pyramid_levels(frame.grey->width, frame.grey->height));
    const Intrinsics lens = assumed_intrinsics(frame.grey->width, frame.grey->height, 0);
    AlignedView at;
    measure_view(pyramid, lens, {lens, pyramid}, {}, at);  // over itself
    told[i] = at.parts >= kPartsToTell;
  });
  return looks ? double(std::ranges::count(told, char(1))) / double(looks) : 0;
}

HandheldView handheld_view(const HandheldCamera& camera) {
  return {turn_from_vector(camera.rotation), std::log(camera.zoom), camera.shift_px};
}

Camera handheld_camera(const HandheldSolve& solve, int frame, int width, int height) {
  const auto nearest = std::min_element(solve.cameras.begin(), solve.cameras.end(),
                                        [&](const HandheldCamera& a, const HandheldCamera& b) {
                                          return std::abs(a.frame - frame) < std::abs(b.frame - frame);
                                        });
  const HandheldView view = handheld_view(*nearest);
  Camera camera{frame, view_intrinsics(solve.reference, view), Pose::Identity()};
  camera.cam_from_world.linear() = view.turn;
  Intrinsics& k = camera.intrinsics;
  const double sx = double(width) / k.width, sy = double(height) / k.height;
  k.fx *= sx, k.cx *= sx, k.fy *= sy, k.cy *= sy;
  k.width = width, k.height = height;
  return camera;
}

}  // namespace likeness
