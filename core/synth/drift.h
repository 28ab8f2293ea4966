// What a phone's automatic does while it films: exposure and white balance wander, and the focus breathes
// between the face and the room.
#pragma once

#include <vector>

#include "core/base/linalg.h"
#include "core/synth/demo_options.h"

namespace likeness {

inline constexpr float kExposureDrift = 0.20f, kWhiteDrift = 0.06f;  // at most, of 1
inline constexpr float kFocusDrift_px = 1.5f;                        // at most

struct Drift {
  Vec3f gain = Vec3f::Ones();                // on linear radiance: exposure times white balance
  float face_blur_px = 0, room_blur_px = 0;  // standard deviation of a Gaussian
};
// Without DemoOptions::drift, none. frame: of the film; cuts do not interrupt it. Over any clip each wanders
// over most of its range.
Drift drift_of(const DemoOptions& options, int frame);

// A picture in linear light whose person and room were rendered apart.
struct FilmLayers {
  int width = 0, height = 0;
  std::vector<Vec3f> person;  // (height, width) times its alpha
  std::vector<float> alpha;   // share of the pixel that the person covers
  std::vector<Vec3f> room;    // behind the person, too
};
// Convolves with a Gaussian, the border continued. sigma_px <= 0 changes nothing.
void blur_layer(std::vector<Vec3f>& layer, int width, int height, float sigma_px);
void blur_layer(std::vector<float>& layer, int width, int height, float sigma_px);

}  // namespace likeness
