// An oracle, not the product: the pose and expression of a held-out frame fitted to the frozen field. What it
// gains over the frame as tracked is what better tracking could still bring.
#pragma once

#include <cstdint>

#include "core/render/pose_avatar.h"

namespace likeness {

struct RefitOptions {
  int pixels = 4096;   // drawn on the head; the cost is proportional
  int iterations = 8;  // Gauss-Newton steps, 13 renderings of the pixels each
  int components = 6;  // of the condition; with the head's pose 12 numbers a frame
  std::uint64_t seed = 0;
};

struct Refit {
  Pose world_from_head = Pose::Identity();  // m
  Articulation articulation;
  double mse_before = 0, mse_after = 0;  // over the pixels drawn
  int free_numbers = 0;
};

// truth: (h, w, 3) the frame; plate: its background, or empty (then only the head's inside, by `region`, is
// compared). region: (h, w, 1) 255 where pixels may be drawn. The torso stays as tracked.
Refit refit_frame(const Avatar& avatar, const AvatarRig& rig, const Camera& camera, const Image& truth,
                  const Image8& plate, const Image8& region, const Pose& world_from_head,
                  const Pose& world_from_torso, const Articulation& articulation,
                  const RefitOptions& options = {});

}  // namespace likeness
