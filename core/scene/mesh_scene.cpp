// Ray and closest-point queries through Embree 3 or 4; only this file depends on which.
#include "core/scene/mesh_scene.h"

#if LIKENESS_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace likeness {
namespace {

// One device for the process: it holds Embree's thread arena, and making one costs milliseconds.
RTCDevice shared_device() {
  static const RTCDevice device = [] {
    const RTCDevice made = rtcNewDevice(nullptr);
    LIKENESS_CHECK(made != nullptr, "Embree gave no device, error %d", int(rtcGetDeviceError(nullptr)));
    return made;
  }();
  return device;
}

RTCRay make_ray(const Vec3f& origin, const Vec3f& direction, float near, float far) {
  RTCRay ray{};
  ray.org_x = origin.x(), ray.org_y = origin.y(), ray.org_z = origin.z();
  ray.dir_x = direction.x(), ray.dir_y = direction.y(), ray.dir_z = direction.z();
  ray.tnear = near;
  ray.tfar = far;
  ray.mask = ~0u;
  return ray;
}

// Weights at the nearest point of the nearest edge: for triangles without area, which have no plane.
Vec3f closest_on_edges(const Vec3f& p, const std::array<Vec3f, 3>& corners) {
  Vec3f best = Vec3f::UnitX();
  float least = std::numeric_limits<float>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vec3f &from = corners[k], edge = corners[(k + 1) % 3] - from;
    const float squared = edge.squaredNorm();
    const float t = squared > 0 ? std::clamp(edge.dot(p - from) / squared, 0.0f, 1.0f) : 0.0f;
    const float distance = (from + t * edge - p).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    best = (1 - t) * Vec3f::Unit(k) + t * Vec3f::Unit((k + 1) % 3);
  }
  return best;
}

// Weights of the triangle's corners at its point nearest to p (Ericson, Real-Time Collision Detection, 5.1.5,
// by the regions of the plane).
Vec3f closest_on_triangle(const Vec3f& p, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const auto share = [](float part, float whole) {
    return whole > 0 ? std::clamp(part / whole, 0.0f, 1.0f) : 0.0f;
  };
  const Vec3f ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  // Squared sine of the corner at a; below this, single precision cannot resolve the plane.
  if (ab.cross(ac).squaredNorm() <= 1e-8f * ab.squaredNorm() * ac.squaredNorm())
    return closest_on_edges(p, {a, b, c});
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const float d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const float t = share(d1, d1 - d3);
    return {1 - t, t, 0};
  }
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const float t = share(d2, d2 - d6);
    return {1 - t, 0, t};
  }
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const float t = share(d4 - d3, (d4 - d3) + (d5 - d6));
    return {0, 1 - t, t};
  }
  const float sum = va + vb + vc;
  if (!(sum > 0)) return closest_on_edges(p, {a, b, c});
  return {va / sum, vb / sum, vc / sum};
}

struct ClosestSearch {
  const std::vector<Vec3f>* vertices;
  const std::vector<Triangle>* triangles;
  Vec3f point;
  ClosestPoint best;
};

bool visit_triangle(RTCPointQueryFunctionArguments* arguments) {
  ClosestSearch& search = *static_cast<ClosestSearch*>(arguments->userPtr);
  const Triangle& triangle = (*search.triangles)[arguments->primID];
  const Vec3f &a = (*search.vertices)[triangle[0]], &b = (*search.vertices)[triangle[1]],
              &c = (*search.vertices)[triangle[2]];
  const Vec3f weights = closest_on_triangle(search.point, a, b, c);
  const Vec3f position = weights[0] * a + weights[1] * b + weights[2] * c;
  const float distance = (position - search.point).norm();
  // Ties go to the lower triangle, so that the answer does not depend on the tree.
  const int index = int(arguments->primID);
  const bool nearer =
      distance < search.best.distance ||
      (distance == search.best.distance && (search.best.triangle < 0 || index < search.best.triangle));
  if (!nearer || distance > arguments->query->radius) return false;
  search.best = {position, distance, index, weights};
  arguments->query->radius = distance;
  return true;
}

}  // namespace

struct MeshScene::Impl {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
  RTCScene scene = nullptr;
  RTCGeometry geometry = nullptr;
  float* embree_vertices = nullptr;  // (V, 3) Embree's own copy, padded as it requires

  void copy_vertices() {
    for (std::size_t v = 0; v < vertices.size(); ++v)
      for (int axis = 0; axis < 3; ++axis) embree_vertices[3 * v + axis] = vertices[v][axis];
  }
  ~Impl() {
    if (geometry) rtcReleaseGeometry(geometry);
    if (scene) rtcReleaseScene(scene);
  }
};

MeshScene::MeshScene(std::vector<Vec3f> vertices, std::vector<Triangle> triangles, MeshUse use)
    : impl_(std::make_unique<Impl>()) {
  impl_->vertices = std::move(vertices);
  impl_->triangles = std::move(triangles);
  const int count = int(impl_->vertices.size());
  for (const Triangle& triangle : impl_->triangles)
    LIKENESS_CHECK(triangle.minCoeff() >= 0 && triangle.maxCoeff() < count,
                   "triangle (%d, %d, %d) of %d vertices", triangle[0], triangle[1], triangle[2], count);
  impl_->scene = rtcNewScene(shared_device());
  LIKENESS_CHECK(impl_->scene != nullptr, "Embree gave no scene");
  // Robust: no ray slips through the edge between two triangles.
  rtcSetSceneFlags(impl_->scene, RTCSceneFlags(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC));
  // Low quality of the scene means a tree per geometry, without which Embree rebuilds where it is asked to
  // refit; the one geometry's own tree is built by surface area all the same.
  const bool refit = use == MeshUse::many_moves;
  rtcSetSceneBuildQuality(impl_->scene, refit ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
  if (!impl_->triangles.empty()) {
    impl_->geometry = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(impl_->geometry, refit ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_MEDIUM);
    impl_->embree_vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(impl_->geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), impl_->vertices.size()));
    auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(impl_->geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                                   RTC_FORMAT_UINT3, 3 * sizeof(unsigned),
                                                                   impl_->triangles.size()));
    LIKENESS_CHECK(impl_->embree_vertices && corners, "Embree gave no buffer for %d vertices", count);
    impl_->copy_vertices();
    for (std::size_t t = 0; t < impl_->triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) corners[3 * t + k] = unsigned(impl_->triangles[t][k]);
    rtcCommitGeometry(impl_->geometry);
    rtcAttachGeometry(impl_->scene, impl_->geometry);
  }
  rtcCommitScene(impl_->scene);
}

MeshScene::~MeshScene() = default;
MeshScene::MeshScene(MeshScene&&) noexcept = default;
MeshScene& MeshScene::operator=(MeshScene&&) noexcept = default;

std::optional<RayHit> MeshScene::intersect(const Vec3f& origin, const Vec3f& direction, float near,
                                           float far) const {
  RTCRayHit query{};
  query.ray = make_ray(origin, direction, near, far);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(impl_->scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return RayHit{query.ray.tfar, int(query.hit.primID), Vec2f(query.hit.u, query.hit.v)};
}

bool MeshScene::occluded(const Vec3f& origin, const Vec3f& direction, float near, float far) const {
  RTCRay ray = make_ray(origin, direction, near, far);
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(impl_->scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->scene, &context, &ray);
#endif
  return ray.tfar < 0;  // Embree writes -infinity on a hit
}

std::optional<ClosestPoint> MeshScene::closest(const Vec3f& point, float radius) const {
  ClosestSearch search{&impl_->vertices, &impl_->triangles, point, {}};
  search.best.distance = std::numeric_limits<float>::infinity();
  RTCPointQuery query{};
  query.x = point.x(), query.y = point.y(), query.z = point.z();
  query.radius = radius;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(impl_->scene, &query, &context, visit_triangle, &search);
  if (search.best.triangle < 0) return std::nullopt;
  return search.best;
}

const std::vector<Vec3f>& MeshScene::vertices() const { return impl_->vertices; }
const std::vector<Triangle>& MeshScene::triangles() const { return impl_->triangles; }

void MeshScene::move_vertices(std::span<const Vec3f> vertices) {
  LIKENESS_CHECK(vertices.size() == impl_->vertices.size(), "%d positions for %d vertices",
                 int(vertices.size()), int(impl_->vertices.size()));
  std::copy(vertices.begin(), vertices.end(), impl_->vertices.begin());
  if (!impl_->geometry) return;
  impl_->copy_vertices();
  rtcUpdateGeometryBuffer(impl_->geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(impl_->geometry);
  rtcCommitScene(impl_->scene);
}

}  // namespace likeness
