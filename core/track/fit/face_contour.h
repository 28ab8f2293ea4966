// The outline of a posed face in a picture: where the surface turns away from the camera in front of
// something further away, and the picture's edge found near it.
//
// A contour point lies where n . (p - eye) changes sign over a triangle (Hertzmann and Zorin, SIGGRAPH 2000);
// there the normal is at right angles to the line of sight, so that an edge found `shift` pixels further out
// requires n . displacement = shift / px_per_m of the surface.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/image/image.h"

namespace likeness {

struct ContourPoint {
  int triangle = 0;
  Vec3d barycentric = Vec3d::Zero();
  Vec3d normal = Vec3d::UnitZ();  // head frame, unit, outward
  Vec2d pixel = Vec2d::Zero();    // working px
  Vec2d outward = Vec2d::Zero();  // unit, in the picture
  double px_per_m = 0;            // of a displacement along the normal
};

// 1 for triangles (F) whose outline can be found in a picture: skin of cheeks, jaw, chin and nose, from the
// brows down and in front of the ears, where neither hair nor collar is the outline.
std::vector<std::uint8_t> contour_triangles(const HeadModel& model, const std::vector<Vec3f>& rest);

// posed: (V) head frame, m. A surface less than 12 mm behind it rules an outline out.
std::vector<ContourPoint> face_contour(const HeadModel& model, const std::vector<std::uint8_t>& candidates,
                                       const std::vector<Vec3f>& posed, const Intrinsics& intrinsics,
                                       const Pose& cam_from_head);

// How far outwards (px) along `outward` the picture has the one clear edge within `reach_px`, or nullopt if
// it has none or several. usual_px: the expected distance of edges; nearer ones are preferred.
std::optional<double> find_edge(const Image8& grey, const Vec2d& pixel, const Vec2d& outward, double reach_px,
                                double usual_px);

}  // namespace likeness
