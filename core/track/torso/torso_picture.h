// Pictures as used by the torso's alignment: pyramids of local contrast (relief), and a template of the torso
// in its own frame on which many training frames agree.
#pragma once

#include <vector>

#include "core/camera/camera.h"
#include "core/image/image.h"
#include "core/track/torso/convex_outline.h"
#include "core/track/torso/torso_frame.h"

namespace likeness {

// A float picture of one pyramid level.
struct GreyLevel {
  int width = 0, height = 0;
  double scale = 1;         // of the working picture
  std::vector<float> data;  // (height, width), grey levels

  float at(int x, int y) const { return data[static_cast<std::size_t>(y) * width + x]; }
  // Value and slope at a place in this level's pixels (centres at +0.5); false outside.
  bool sample(double px, double py, float* value, Vec2d* slope) const;
};

// Halves of the picture: 1/2, 1/4, 1/8. The finest suffices for a hundredth of a pixel over this many pixels.
// The mean of its surroundings is subtracted from every pixel, which gives the relief: in plain grey levels
// the edge of the head's shadow would attract the torso's edges. Near the outline of a moving head those
// surroundings include some of it.
std::vector<GreyLevel> relief_pyramid(const Image8& grey);

struct TorsoPixel {
  Vec3d place;      // on the canonical torso, torso frame, m
  float value = 0;  // grey levels, beside its surroundings
  float weight = 1;
};

struct TorsoTemplate {
  std::vector<std::vector<TorsoPixel>> levels;  // finest first; of the finest only what lies near edges
  Vec2d pivot = Vec2d::Zero();                  // torso frame, m: the neck's base
  double picture_share = 0;                     // of the picture where it may be
};

inline constexpr double kLeastTorsoShare = 0.02;  // of the picture: less is not followed

// From one frame, whose head frame is the torso frame. chin: head frame, m. A picture that hardly reaches
// below the chin may still show the shoulders beside it: there, too, it is looked for then.
TorsoTemplate make_torso_template(const TorsoFrame& frame, const Vec3d& chin);

// The convex outline of a head without its neck, for TorsoFrame. vertices, chin: head frame, m.
ConvexOutline head_outline(const std::vector<Vec3f>& vertices, const Vec3d& chin, const Pose& cam_from_head,
                           const Intrinsics& intrinsics);

}  // namespace likeness
