// Where the eyes look, from the dark iris in the eye's opening. One direction for both eyes: vergence is
// below what this can see.
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

struct Gaze {
  double yaw = 0, pitch = 0;  // rad in the head frame: to the subject's left, upwards
  double openness = 0;        // height over width of the eyes' openings in the picture
};

// grey: working picture; landmarks: its pixels. nullopt where the eyes are (nearly) closed or too small to
// tell.
std::optional<Gaze> measure_gaze(const Image8& grey, const Intrinsics& intrinsics, const Pose& cam_from_head,
                                 const EyeBalls& eyes, const std::array<Vec2d, kLandmarkCount>& landmarks);

// Rotation vector of an eye joint that looks there.
Vec3f eye_rotation(const Gaze& gaze);

}  // namespace likeness
