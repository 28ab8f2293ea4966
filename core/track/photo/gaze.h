// Where the eyes look: the circle of the iris on the eyeball that best fits the picture's edge between iris
// and white. A single picture decides; nothing is shared between frames.
#pragma once

#include <array>
#include <optional>

#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/head/pose_head.h"
#include "core/image/image.h"

namespace likeness {

struct EyeBalls {
  std::array<Vec3d, 2> centre;  // subject's right (landmarks 36..41), left (42..47); head frame, m
  double radius = 0.012;        // m
};
EyeBalls eye_balls(const HeadModel& model, const HeadShape& person);

// One eye's own measurement. Iris radius: 5.9 mm of a 12 mm eyeball, the same share in every adult.
struct EyeGaze {
  double yaw = 0, pitch = 0;  // rad in the head frame: to the subject's left, upwards
  double confidence = 0;      // 0 nothing seen .. 1 a clear edge all round
};

// One direction for both eyes: vergence is too small to be measured here.
struct Gaze {
  double yaw = 0, pitch = 0;     // rad, of the eyes together, by their confidence
  double openness = 0;           // height over width of the eyes' openings in the picture
  std::array<EyeGaze, 2> eye{};  // subject's right, left; confidence 0 if an eye gives no reading
};

// grey: working picture; landmarks: its pixels. nullopt if the eyes are (nearly) closed or too small.
std::optional<Gaze> measure_gaze(const Image8& grey, const Intrinsics& intrinsics, const Pose& cam_from_head,
                                 const EyeBalls& eyes, const std::array<Vec2d, kLandmarkCount>& landmarks);

// Rotation vector of an eye joint that looks there.
Vec3f eye_rotation(const Gaze& gaze);

}  // namespace likeness
