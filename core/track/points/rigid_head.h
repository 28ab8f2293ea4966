// The rigid part of a person's head as dense tracking needs it: surfaces to start 3-D points on, and where in
// the picture points may be detected. Everything in the head frame, neutral expression.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/base/linalg.h"
#include "core/camera/camera.h"
#include "core/head/pose_head.h"
#include "core/image/image.h"
#include "core/scene/mesh_scene.h"

namespace likeness {

struct RigidHead {
  std::vector<Vec3f> vertices;  // (V) neutral person, m
  std::vector<Triangle> upper;  // outer surface above the base of the nose
  std::vector<Vec3f> hull;      // (V) the same 1.13 times larger about the skull's centre: hair
  std::vector<Triangle> hair;   // hull triangles above the brows
  std::vector<Vec3f> eyes[2];   // outlines, from the landmarks
  std::shared_ptr<const MeshScene> surface, hair_surface;
};

// person: the neutral head, including the person's offsets.
RigidHead rigid_head(const HeadModel& model, const HeadShape& person);

struct HeadSurfacePoint {
  Vec3d point, normal;  // head frame; normal: unit, outwards
  bool hair = false;    // on the larger hull: not on the skin
};
// Where the ray through the camera's origin (ray: x/z, y/z, 1 in the camera frame) meets the head.
std::optional<HeadSurfacePoint> point_on_head(const RigidHead& head, const Pose& cam_from_head,
                                              const Vec2d& ray);

// 255 where corners may be taken: on the upper head and hair, off the eyes and off the outline. One channel.
Image8 corner_mask(const RigidHead& head, const Intrinsics& intrinsics, const Pose& cam_from_head);

}  // namespace likeness
