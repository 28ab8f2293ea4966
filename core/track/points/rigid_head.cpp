#include "core/track/points/rigid_head.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/rigid.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

constexpr float kHairGrowth = 1.13f;

bool outer(const HeadModel& model, int vertex) {
  const HeadPart part = model.parts.empty() ? HeadPart::unknown : model.parts[vertex];
  return part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::unknown;
}

}  // namespace

RigidHead rigid_head(const HeadModel& model, const HeadShape& person) {
  RigidHead head;
  head.vertices = person.vertices;
  const auto landmarks = landmark_positions(model, head.vertices);
  const float nose_base = landmarks[33].y();
  float brow = -1e9f;
  for (int i = 17; i <= 26; ++i) brow = std::max(brow, landmarks[i].y());
  // The skull's centre: between the ears' level and the crown, midway in depth.
  Vec3f low = Vec3f::Constant(1e9f), high = Vec3f::Constant(-1e9f);
  for (int v = 0; v < model.vertex_count(); ++v)
    if (outer(model, v) && head.vertices[v].y() > nose_base) {
      low = low.cwiseMin(head.vertices[v]);
      high = high.cwiseMax(head.vertices[v]);
    }
  const Vec3f centre = 0.5f * (low + high);
  head.hull = head.vertices;
  for (Vec3f& v : head.hull) v = centre + kHairGrowth * (v - centre);
  for (const Triangle& t : model.triangles) {
    if (!outer(model, t[0]) || !outer(model, t[1]) || !outer(model, t[2])) continue;
    float lowest = 1e9f, foremost = -1e9f;
    for (int k = 0; k < 3; ++k) {
      lowest = std::min(lowest, head.vertices[t[k]].y());
      foremost = std::max(foremost, head.vertices[t[k]].z());
    }
    if (lowest > nose_base) head.upper.push_back(t);
    // Hair: above the brows, and from the temples backwards.
    if (lowest > brow + 0.01f || (lowest > nose_base && foremost < centre.z())) head.hair.push_back(t);
  }
  for (int side = 0; side < 2; ++side)
    for (int i = 36 + 6 * side; i < 42 + 6 * side; ++i) head.eyes[side].push_back(landmarks[i]);
  if (!head.upper.empty()) head.surface = std::make_shared<MeshScene>(head.vertices, head.upper);
  if (!head.hair.empty()) head.hair_surface = std::make_shared<MeshScene>(head.hull, head.hair);
  return head;
}

std::optional<HeadSurfacePoint> point_on_head(const RigidHead& head, const Pose& cam_from_head,
                                              const Vec2d& ray) {
  const Pose head_from_cam = inverse(cam_from_head);
  const Vec3f origin = head_from_cam.translation().cast<float>();
  const Vec3f direction = (head_from_cam.linear() * ray.homogeneous()).cast<float>();
  for (const auto& scene : {head.surface, head.hair_surface}) {
    if (!scene) continue;
    const auto hit = scene->intersect(origin, direction);
    if (!hit) continue;
    const Triangle& t = scene->triangles()[hit->triangle];
    const std::vector<Vec3f>& v = scene->vertices();
    Vec3d normal = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).cast<double>();
    if (normal.norm() < 1e-12) return std::nullopt;
    normal.normalize();
    if (normal.dot(direction.cast<double>()) > 0) normal = -normal;  // the side that is seen
    return HeadSurfacePoint{(origin + hit->distance * direction).cast<double>(), normal,
                            scene == head.hair_surface};
  }
  return std::nullopt;
}

Image8 corner_mask(const RigidHead& head, const Intrinsics& intrinsics, const Pose& cam_from_head) {
  Image8 mask(intrinsics.width, intrinsics.height, 1);
  for (const auto& [vertices, triangles] :
       {std::pair(&head.vertices, &head.upper), {&head.hull, &head.hair}}) {
    const std::vector<int> seen = rasterise_triangles(*vertices, *triangles, intrinsics, cam_from_head);
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (seen[i] >= 0) mask.data[i] = 255;
  }
  cv::Mat view(mask.height, mask.width, CV_8UC1, mask.data.data());
  const double px_per_m = intrinsics.fx / std::max(0.05, cam_from_head.translation().z());
  const int margin = std::max(1, static_cast<int>(0.006 * px_per_m));
  cv::erode(view, view, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * margin + 1, 2 * margin + 1}));
  const int around_eyes = std::max(1, static_cast<int>(0.010 * px_per_m));
  cv::Mat eyes = cv::Mat::zeros(view.size(), CV_8UC1);
  for (const auto& outline : head.eyes) {
    std::vector<cv::Point> polygon;
    for (const Vec3f& p : outline) {
      const Vec3d in_cam = cam_from_head * p.cast<double>();
      if (in_cam.z() < 0.05) return mask;
      const Vec2d px = project<double>(intrinsics, in_cam);
      polygon.emplace_back(static_cast<int>(px.x()), static_cast<int>(px.y()));
    }
    std::vector<cv::Point> hull;
    cv::convexHull(polygon, hull);
    cv::fillConvexPoly(eyes, hull, 255);
  }
  cv::dilate(eyes, eyes,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * around_eyes + 1, 2 * around_eyes + 1}));
  view.setTo(0, eyes);
  return mask;
}

}  // namespace likeness
