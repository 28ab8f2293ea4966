// Everything happens in the head frame: short hair does not move there, so its tree is built once; lights and
// rays are moved into it. The neck, and hair that long, are blended between the head's pose and the torso's
// by height; a beard goes with the skin it grows on.
#include "core/synth/person.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/scene/mesh_scene.h"
#include "core/synth/garment.h"
#include "core/synth/glasses.h"
#include "core/synth/hair.h"
#include "core/synth/noise.h"
#include "core/synth/skin.h"

namespace likeness {
namespace {

bool is_skin(HeadPart part) {
  return part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::unknown ||
         part == HeadPart::torso;
}
bool is_eyeball(HeadPart part) { return part == HeadPart::left_eyeball || part == HeadPart::right_eyeball; }

template <class T>
T blend(const std::vector<T>& values, const Triangle& t, const Vec3f& b) {
  return values[std::size_t(t[0])] * b[0] + values[std::size_t(t[1])] * b[1] +
         values[std::size_t(t[2])] * b[2];
}

// Share of the head's motion a rest vertex takes: all of it on the face and the skull, none below the collar.
float head_share(const Vec3f& p, const Vec3f& chin) {
  const float height = (p.y() - chin.y()) + 0.4f * (p.z() - 0.02f);
  return smoothstep(-0.066f, 0.012f, height);
}

}  // namespace

struct Person::Impl {
  const HeadModel& model;
  const HeadShape& shape;
  const PersonalPlay& play;
  LightRig world_rig, rig;
  PersonOptions options;
  std::array<Vec3f, kLandmarkCount> landmarks;
  Skin skin;
  Garment garment;
  std::vector<Triangle> scalp_triangles;  // the triangles on which hair grows
  HairMesh hair, beard;
  Glasses glasses;
  std::vector<Triangle> triangles;                      // head model's, then the garment's, then the glasses'
  std::vector<HeadPart> parts;                          // per triangle of the head
  std::size_t head_triangles = 0, frame_triangles = 0;  // where the garment's and the glasses' begin
  int head_vertices = 0;
  std::vector<Vec3f> rest;                     // head vertices, then garment's
  std::vector<float> shares;                   // head_share per head vertex
  std::vector<std::vector<int>> neighbours;    // of skin vertices
  std::vector<float> hair_shares;              // head_share per vertex of long hair
  std::vector<Eigen::Isometry3f> rest_anchor;  // per vertex triangle of the scalp that holds beard
  MeshScene body, hair_scene;
  std::optional<MeshScene> beard_scene, lens_scene;

  // Of the current pose:
  std::vector<Vec3f> posed, normals;
  std::vector<Received> received;
  std::vector<std::uint8_t> lit;
  Pose head_from_world = Pose::Identity(), world_from_torso = Pose::Identity();
  Vec3f up = Vec3f::UnitY();
  std::array<Eigen::Matrix3f, 2> eye_turn;

  Impl(const HeadModel& m, const HeadShape& s, const PersonalPlay& y, const LightRig& r,
       const PersonOptions& o)
      : model(m),
        shape(s),
        play(y),
        world_rig(r),
        rig(r),
        options(o),
        landmarks(landmark_positions(m, s.vertices)),
        skin(landmarks, {s.joints[kLeftEye], s.joints[kRightEye]}, eye_radius(m, s), o.look.skin, o.pixel_m,
             o.seed),
        garment(make_garment(skin_vertices(m, s), landmarks)),
        scalp_triangles(scalp_of(m)),
        hair(grow_hair(scalp(), {garment.vertices, garment.triangles}, hair_options(o))),
        beard(shave(o)),
        glasses(make_glasses(scalp(), {s.joints[kLeftEye], s.joints[kRightEye]}, o.look.glasses)),
        body(make_body()),
        hair_scene(hair.vertices, hair.triangles,
                   is_long_hair(o) ? MeshUse::many_moves : MeshUse::many_queries) {
    if (!hair.follow.empty()) {
      hair_shares = hair.follow;
    } else if (is_long_hair(o)) {
      for (const Vec3f& p : hair.vertices) hair_shares.push_back(head_share(p, landmarks[8]));
    }
    if (!beard.triangles.empty()) {
      beard_scene.emplace(beard.vertices, beard.triangles, MeshUse::many_moves);
      rest_anchor.resize(scalp_triangles.size());
      for (std::size_t t = 0; t < rest_anchor.size(); ++t) rest_anchor[t] = frame_of(int(t), shape.vertices);
    }
    if (!glasses.lens_triangles.empty()) lens_scene.emplace(glasses.lens_vertices, glasses.lens_triangles);
  }

  static bool is_long_hair(const PersonOptions& o) { return hangs(o.look.hair.cut); }
  Scalp scalp() const { return {shape.vertices, scalp_triangles, landmarks}; }
  // The frame of a triangle of the scalp: its middle and three axes.
  Eigen::Isometry3f frame_of(int triangle, const std::vector<Vec3f>& at) const {
    const Triangle& t = scalp_triangles[std::size_t(triangle)];
    const Vec3f &a = at[std::size_t(t[0])], &b = at[std::size_t(t[1])], &c = at[std::size_t(t[2])];
    const Vec3f n = (b - a).cross(c - a).normalized(), x = (b - a).normalized();
    Eigen::Isometry3f frame = Eigen::Isometry3f::Identity();
    frame.linear().col(0) = x;
    frame.linear().col(1) = n.cross(x);
    frame.linear().col(2) = n;
    frame.translation() = (a + b + c) / 3;
    return frame;
  }

  static float eye_radius(const HeadModel& m, const HeadShape& s) {
    double sum = 0;
    int count = 0;
    for (int v = 0; v < m.vertex_count(); ++v) {
      if (m.parts[std::size_t(v)] != HeadPart::left_eyeball) continue;
      sum += (s.vertices[std::size_t(v)] - s.joints[kLeftEye]).norm();
      ++count;
    }
    return count > 0 ? float(sum / count) : 0.012f;
  }
  static std::vector<Vec3f> skin_vertices(const HeadModel& m, const HeadShape& s) {
    std::vector<Vec3f> result;
    for (int v = 0; v < m.vertex_count(); ++v) {
      if (is_skin(m.parts[std::size_t(v)])) result.push_back(s.vertices[std::size_t(v)]);
    }
    return result;
  }
  static std::vector<Triangle> scalp_of(const HeadModel& m) {
    std::vector<Triangle> skull;
    for (const Triangle& t : m.triangles) {
      if (is_skin(m.parts[std::size_t(t[0])]) && m.parts[std::size_t(t[0])] != HeadPart::torso)
        skull.push_back(t);
    }
    return skull;
  }
  static HairOptions hair_options(const PersonOptions& o) {
    HairOptions h;
    h.look = o.look.hair;
    h.seed = o.seed;
    h.width_m = std::clamp(0.8f * o.pixel_m, 0.0006f, 0.0018f);
    h.strands_per_lock = std::clamp(int(22 * 0.0008f / h.width_m), 9, 24);
    if (is_long_hair(o)) h.locks = 1700;
    return h;
  }
  HairMesh shave(const PersonOptions& o) const {
    if (o.look.hair.beard <= 0) return {};
    HairOptions h = hair_options(o);
    h.locks = 2200;
    h.width_m *= 0.6f;
    h.strands_per_lock = std::max(7, 2 * h.strands_per_lock / 3);
    return grow_beard(
        scalp(), [this](const Vec3f& p) { return beard_share(p); }, h);
  }
  // How thickly the beard grows: not on the lips.
  // The throat below the jaw is shaved.
  float beard_share(const Vec3f& p) const {
    const float jaw = landmarks[8].y() - 0.006f + 0.42f * std::max(0.0f, landmarks[8].z() - p.z() - 0.010f);
    return skin.stubble(p) * (1 - skin.lip(p)) * smoothstep(jaw - 0.030f, jaw - 0.006f, p.y());
  }
  std::vector<Vec3f> all_vertices() {
    rest = shape.vertices;
    head_vertices = int(rest.size());
    rest.insert(rest.end(), garment.vertices.begin(), garment.vertices.end());
    rest.insert(rest.end(), glasses.frame_vertices.begin(), glasses.frame_vertices.end());
    shares.resize(std::size_t(head_vertices));
    for (std::size_t v = 0; v < shares.size(); ++v) shares[v] = head_share(rest[v], landmarks[8]);
    return rest;
  }
  std::vector<Triangle> all_triangles() {
    neighbours.resize(std::size_t(head_vertices));
    const float hem = landmarks[8].y() - 0.095f;  // the skin ends inside the collar
    for (const Triangle& t : model.triangles) {
      const HeadPart part = model.parts[std::size_t(t[0])];
      if (part == HeadPart::torso) continue;
      const float top =
          std::max({rest[std::size_t(t[0])].y(), rest[std::size_t(t[1])].y(), rest[std::size_t(t[2])].y()});
      if (is_skin(part) && top < hem) continue;
      triangles.push_back(t);
      parts.push_back(part);
      if (!is_skin(part)) continue;
      for (int k = 0; k < 3; ++k) {
        for (const int other : {t[(k + 1) % 3], t[(k + 2) % 3]}) {
          std::vector<int>& list = neighbours[std::size_t(t[k])];
          if (std::find(list.begin(), list.end(), other) == list.end()) list.push_back(other);
        }
      }
    }
    head_triangles = triangles.size();
    for (const Triangle& t : garment.triangles) triangles.push_back(t + Triangle::Constant(head_vertices));
    frame_triangles = triangles.size();
    const int first = head_vertices + int(garment.vertices.size());
    for (const Triangle& t : glasses.frame_triangles) triangles.push_back(t + Triangle::Constant(first));
    return triangles;
  }

  MeshScene make_body() {
    std::vector<Vec3f> vertices = all_vertices();  // first: the triangles are chosen by them
    return MeshScene(std::move(vertices), all_triangles());
  }

  bool is_garment(std::size_t v) const {
    return v >= std::size_t(head_vertices) && v < std::size_t(head_vertices) + garment.vertices.size();
  }
  HeadPart part_of_vertex(int v) const {
    return v < head_vertices ? model.parts[std::size_t(v)] : HeadPart::torso;
  }

  struct TorsoLight;
  void place(const Shot& shot);
  void place_hair(const Eigen::Quaternionf& turn, const Vec3f& pivot, const Vec3f& shift,
                  const Eigen::Isometry3f& late);
  HairPoint hair_point(const HairMesh& mesh, const RayHit& hit, const Vec3f& position,
                       const Vec3f& colour) const;
  void gather(const Vec3f& lens, std::stop_token stop);
  void scatter();
  Vec3f shade_body(int triangle, const Vec3f& bary, const Vec3f& to_eye) const;
  Vec3f shade_eye(const Surface& s, HeadPart part, const Vec3f& rest_point, const Vec3f& position,
                  const Received& light, const Vec3f& to_eye) const;
  Received received_at(const Triangle& t, const Vec3f& b) const;
};

void Person::Impl::place(const Shot& shot) {
  head_from_world = inverse(shot.world_from_head);
  world_from_torso = shot.world_from_torso;
  up = (head_from_world.linear() * Vec3d::UnitY()).cast<float>();
  rig = transform_rig(world_rig, head_from_world);
  posed = play.pose(shot.articulation, shot.habit);
  LIKENESS_CHECK(int(posed.size()) == head_vertices, "%zu posed vertices for %d", posed.size(),
                 head_vertices);
  const Vec3f pivot = shape.joints[kNeck];
  const Eigen::Isometry3f torso = (head_from_world * shot.world_from_torso).cast<float>();
  const Eigen::Quaternionf turn(torso.linear()), none = Eigen::Quaternionf::Identity();
  const Vec3f shift = torso * pivot - pivot;
  for (std::size_t v = 0; v < shares.size(); ++v) {
    const float follow = 1 - shares[v];
    if (follow <= 0) continue;
    posed[v] = pivot + none.slerp(follow, turn) * (posed[v] - pivot) + follow * shift;
  }
  place_hair(turn, pivot, shift, (head_from_world * shot.world_from_late_head).cast<float>());
  for (const Vec3f& p : garment.vertices) posed.push_back(torso * p);
  posed.insert(posed.end(), glasses.frame_vertices.begin(), glasses.frame_vertices.end());
  normals = vertex_normals(posed, triangles);
  body.move_vertices(posed);
  const auto turned = [](const Vec3f& r) {
    const float angle = r.norm();
    return angle < 1e-6f ? Eigen::Matrix3f(Eigen::Matrix3f::Identity())
                         : Eigen::AngleAxisf(angle, r / angle).toRotationMatrix();
  };
  eye_turn = {turned(shot.articulation.left_eye), turned(shot.articulation.right_eye)};
}

// Long hair hangs between head and torso, and loose hair swings there: it is where the head was a moment ago.
// A beard moves with its skin.
void Person::Impl::place_hair(const Eigen::Quaternionf& turn, const Vec3f& pivot, const Vec3f& shift,
                              const Eigen::Isometry3f& late) {
  constexpr float kSwing = 0.8f;  // share of the lateness halfway between head and torso
  const Eigen::Quaternionf none = Eigen::Quaternionf::Identity();
  const bool loose = !hair.follow.empty();
  if (!hair_shares.empty()) {
    std::vector<Vec3f> moved = hair.vertices;
    parallel_ranges(moved.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        const float follow = 1 - hair_shares[v];
        if (follow > 0) moved[v] = pivot + none.slerp(follow, turn) * (moved[v] - pivot) + follow * shift;
        if (loose && follow > 0)
          moved[v] += 4 * kSwing * follow * (1 - follow) * (late * moved[v] - moved[v]);
      }
    });
    hair_scene.move_vertices(moved);
  }
  if (!beard_scene) return;
  std::vector<Eigen::Isometry3f> moves(rest_anchor.size());
  for (std::size_t t = 0; t < moves.size(); ++t)
    moves[t] = frame_of(int(t), posed) * rest_anchor[t].inverse();
  std::vector<Vec3f> moved(beard.vertices.size());
  for (std::size_t v = 0; v < moved.size(); ++v)
    moved[v] = moves[std::size_t(beard.anchor[v])] * beard.vertices[v];
  beard_scene->move_vertices(moved);
}

// Light on a torso at rest is sampled in the torso's own frame: in the head's, which turns, every sample
// would fall elsewhere in every picture, and the cloth would flicker.
struct Person::Impl::TorsoLight {
  const Impl& person;
  Eigen::Isometry3f head_from_torso;
  LightRig rig;
  Vec3f up;
  Visible visible;

  TorsoLight(const Impl& p, const Visible& in_head)
      : person(p),
        head_from_torso((p.head_from_world * p.world_from_torso).cast<float>()),
        rig(transform_rig(p.world_rig, inverse(p.world_from_torso))),
        up((inverse(p.world_from_torso).linear() * Vec3d::UnitY()).cast<float>()),
        visible([this, &in_head](const Vec3f& from, const Vec3f& d, float distance) {
          return in_head(head_from_torso * from, head_from_torso.linear() * d, distance);
        }) {}
  TorsoLight(const TorsoLight&) = delete;

  Received received(std::size_t v, const GatherOptions& how) const {
    const Vec3f normal = head_from_torso.linear().transpose() * person.normals[v];
    return gather_light(rig, up, person.rest[v], normal, visible, how, std::uint32_t(v) * 5);
  }
};

void Person::Impl::gather(const Vec3f& lens, std::stop_token stop) {
  const Visible visible = [this](const Vec3f& from, const Vec3f& d, float distance) {
    return !body.occluded(from, d, 0.0004f, distance) && !hair_scene.occluded(from, d, 0.002f, distance);
  };
  GatherOptions skin_light, plain, mouth;
  skin_light.light_grid = 3;
  skin_light.sky_rays = 16;
  skin_light.wrap = Vec3f(0.32f, 0.17f, 0.12f);
  skin_light.bounce = 0.30f;
  const Vec3f& complexion = options.look.skin.complexion;
  skin_light.bounce_colour = complexion.cwiseProduct(Vec3f(0.97f, 0.75f, 0.77f));
  skin_light.wrap *=
      std::clamp(0.35f + 1.15f * complexion.x(), 0.0f, 1.0f);  // dark skin lets less light through
  plain = skin_light;
  plain.wrap = Vec3f::Zero();
  plain.bounce = 0.12f;
  mouth = plain;  // the region in the lips' shadow is lit through them and by its own wet walls
  mouth.bounce = 0.55f;
  mouth.wrap = Vec3f::Constant(0.3f);
  received.assign(posed.size(), Received());
  lit.assign(posed.size(), 0);
  std::vector<std::uint8_t> used(posed.size(), 0);
  for (const Triangle& t : triangles)
    used[std::size_t(t[0])] = used[std::size_t(t[1])] = used[std::size_t(t[2])] = 1;
  const TorsoLight on_torso(*this, visible);
  parallel_ranges(posed.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end && !stop.stop_requested(); ++v) {
      const Vec3f to_lens = lens - posed[v];
      if (!used[v] || normals[v].dot(to_lens) < -0.3f * to_lens.norm()) continue;
      const HeadPart part = part_of_vertex(int(v));
      const bool oral = part == HeadPart::teeth || part == HeadPart::gums_tongue;
      const GatherOptions& how = is_skin(part) ? skin_light : oral ? mouth : plain;
      received[v] = options.still_torso && is_garment(v)
                        ? on_torso.received(v, how)
                        : gather_light(rig, up, posed[v], normals[v], visible, how, std::uint32_t(v) * 5);
      lit[v] = 1;
    }
  });
}

// Light under the skin: averaged over neighbours, red furthest.
void Person::Impl::scatter() {
  const Eigen::Array3f far(0.75f, 0.5f, 0.4f);
  std::vector<Vec3f> next(static_cast<std::size_t>(head_vertices));
  for (int round = 0; round < 2; ++round) {
    for (std::size_t v = 0; v < next.size(); ++v) {
      next[v] = received[v].diffuse;
      if (!lit[v] || neighbours[v].empty()) continue;
      Vec3f sum = Vec3f::Zero();
      int count = 0;
      for (const int n : neighbours[v]) {
        if (!lit[std::size_t(n)]) continue;
        sum += received[std::size_t(n)].diffuse;
        ++count;
      }
      if (count > 0) next[v] = (next[v].array() * (1 - far) + sum.array() / float(count) * far).matrix();
    }
    for (std::size_t v = 0; v < next.size(); ++v) received[v].diffuse = next[v];
  }
}

Received Person::Impl::received_at(const Triangle& t, const Vec3f& b) const {
  Received light;
  float total = 0;
  for (int k = 0; k < 3; ++k) {
    const std::size_t v = std::size_t(t[k]);
    if (!lit[v]) continue;
    const Received& r = received[v];
    light.diffuse += b[k] * r.diffuse;
    light.key_open += b[k] * r.key_open;
    light.rim_open += b[k] * r.rim_open;
    light.sky_open += b[k] * r.sky_open;
    total += b[k];
  }
  if (total > 0.02f && total < 0.999f) {
    light.diffuse /= total;
    light.key_open /= total;
    light.rim_open /= total;
    light.sky_open /= total;
  }
  return light;
}

Vec3f Person::Impl::shade_eye(const Surface& s, HeadPart part, const Vec3f& rest_point, const Vec3f& position,
                              const Received& light, const Vec3f& to_eye) const {
  const int side = part == HeadPart::left_eyeball ? 0 : 1;
  const Vec3f centre = shape.joints[side == 0 ? kLeftEye : kRightEye];
  const Vec3f local = (rest_point - centre).normalized();
  // The cornea bulges: over the iris its normals spread half as fast again as the globe's.
  const float lateral = local.head<2>().norm();
  Vec3f bulged = local;
  const float bulge = 1 + 0.5f * (1 - smoothstep(0.40f, 0.58f, lateral));
  bulged.head<2>() *= bulge;
  bulged.z() = std::sqrt(std::max(0.05f, 1 - bulged.head<2>().squaredNorm()));
  const Vec3f normal = (eye_turn[std::size_t(side)] * bulged).normalized();
  Vec3f radiance = s.albedo.cwiseProduct(light.diffuse);
  const float rim = fresnel(s.f0, normal.dot(to_eye));
  const Vec3f mirror = 2 * normal.dot(to_eye) * normal - to_eye;
  radiance += 0.7f * rim * light.sky_open * rig.glow(Vec3f(0, mirror.dot(up), 0));
  // The wet eye reflects only the bright core of a large soft light, or the reflection would hide the iris.
  const auto core = [](AreaLight light, float share) {
    light.half_u *= share;
    light.half_v *= share;
    return light;
  };
  const float key = std::clamp(1.4f * light.key_open, 0.0f, 1.0f);
  const float fill = std::clamp(1.5f * light.sky_open, 0.0f, 1.0f);
  radiance += 2.2f * key * glossy(core(rig.key, 0.4f), position, normal, to_eye, 0.10f, s.f0);
  radiance += fill * glossy(core(rig.fill, 0.4f), position, normal, to_eye, 0.10f, s.f0);
  return radiance;
}

Vec3f Person::Impl::shade_body(int triangle, const Vec3f& b, const Vec3f& to_eye) const {
  const Triangle& t = triangles[std::size_t(triangle)];
  const Vec3f position = blend(posed, t, b), rest_point = blend(rest, t, b);
  Vec3f normal = blend(normals, t, b).normalized();
  const Received light = received_at(t, b);
  Surface s;
  const bool frame = std::size_t(triangle) >= frame_triangles;
  const bool cloth = !frame && std::size_t(triangle) >= head_triangles;
  const HeadPart part = cloth || frame ? HeadPart::torso : parts[std::size_t(triangle)];
  if (frame) {
    s.albedo = options.look.glasses.colour;
    s.roughness = 0.28f;
    s.f0 = 0.07f;
  } else if (cloth) {
    // Around the back the coordinate wraps; take the triangle's own continuous one.
    Vec2f at = Vec2f::Zero();
    const Vec2f first = garment.cloth[std::size_t(t[0] - head_vertices)];
    for (int k = 0; k < 3; ++k) {
      Vec2f c = garment.cloth[std::size_t(t[k] - head_vertices)];
      const float turn = 6.2831853f * 0.115f;
      if (c.x() - first.x() > 0.5f * turn) c.x() -= turn;
      if (first.x() - c.x() > 0.5f * turn) c.x() += turn;
      at += b[k] * c;
    }
    s = knitted(at, options.look.cloth, options.pixel_m, options.seed);
  } else {
    s = skin.at(rest_point, part);
    if (is_eyeball(part)) return shade_eye(s, part, rest_point, position, light, to_eye);
    if (is_skin(part)) {
      const HairLook& look = options.look.hair;
      const float hairy = smoothstep(-0.003f, 0.006f, inside_hairline(landmarks, look.cut, rest_point)) *
                          (std::abs(rest_point.x()) > 0.078f ? 0.0f : 1.0f);
      s.albedo = mix(s.albedo, Vec3f(0.35f * look.colour), 0.88f * hairy);
      if (look.beard > 0 && part == HeadPart::face)
        s.albedo = mix(s.albedo, Vec3f(0.6f * look.beard_colour), 0.72f * beard_share(rest_point));
      s.roughness = mix(s.roughness, 0.9f, hairy);
      s.f0 = mix(s.f0, 0.004f, hairy);
    }
  }
  if (normal.dot(to_eye) < 0.03f) normal = (normal + (0.05f - normal.dot(to_eye)) * to_eye).normalized();
  const Vec3f bumped = (normal - s.slope + s.slope.dot(normal) * normal).normalized();
  const Vec3f to_key = (rig.key.centre - position).normalized();
  const float relief =
      std::clamp((bumped.dot(to_key) + 0.5f) / (std::max(0.0f, normal.dot(to_key)) + 0.5f), 0.6f, 1.4f);
  Vec3f radiance = s.albedo.cwiseProduct(light.diffuse) * relief;
  if (light.key_open > 0)
    radiance += light.key_open * glossy(rig.key, position, bumped, to_eye, s.roughness, s.f0);
  if (light.rim_open > 0)
    radiance += light.rim_open * glossy(rig.rim, position, bumped, to_eye, s.roughness, s.f0);
  radiance += light.sky_open * glossy(rig.fill, position, bumped, to_eye, s.roughness, s.f0);
  radiance += 0.5f * fresnel(s.f0, bumped.dot(to_eye)) * (1 - s.roughness) * light.sky_open *
              rig.glow(Vec3f(0, normal.dot(up), 0));
  return radiance;
}

HairPoint Person::Impl::hair_point(const HairMesh& mesh, const RayHit& hit, const Vec3f& position,
                                   const Vec3f& colour) const {
  const Triangle& t = mesh.triangles[std::size_t(hit.triangle)];
  const Vec3f b(1 - hit.barycentric.sum(), hit.barycentric.x(), hit.barycentric.y());
  HairPoint point;
  point.position = position;
  point.tangent = blend(mesh.tangents, t, b).normalized();
  point.outward = blend(mesh.outward, t, b).normalized();
  point.colour =
      mix(Vec3f(colour * blend(mesh.tone, t, b)), Vec3f(0.50f, 0.48f, 0.45f), blend(mesh.white, t, b));
  point.depth_light = blend(mesh.depth_light, t, b);
  point.open = blend(mesh.open, t, b);
  return point;
}

Person::Person(const HeadModel& model, const HeadShape& shape, const PersonalPlay& play, const LightRig& rig,
               const PersonOptions& options)
    : impl_(std::make_unique<Impl>(model, shape, play, rig, options)) {}
Person::~Person() = default;
Person::Person(Person&&) noexcept = default;
Person& Person::operator=(Person&&) noexcept = default;

void Person::pose(const Shot& shot, std::stop_token stop) {
  impl_->place(shot);
  const Vec3f lens =
      (impl_->head_from_world * inverse(shot.camera.cam_from_world).translation()).cast<float>();
  impl_->gather(lens, stop);
  impl_->scatter();
}

std::optional<Vec3f> Person::look(const Vec3f& origin, const Vec3f& direction) const {
  const Impl& me = *impl_;
  const Eigen::Isometry3f m = me.head_from_world.cast<float>();
  const Vec3f from = m * origin, d = (m.linear() * direction).normalized();
  const auto body = me.body.intersect(from, d, 0.02f);
  float nearest = body ? body->distance : 1e30f;
  const auto hair = me.hair_scene.intersect(from, d, 0.02f, nearest);
  if (hair) nearest = hair->distance;
  std::optional<RayHit> beard;
  if (me.beard_scene) beard = me.beard_scene->intersect(from, d, 0.02f, nearest);
  if (!body && !hair && !beard) return std::nullopt;
  Vec3f seen;
  const HairLook& look = me.options.look.hair;
  if (beard) {
    nearest = beard->distance;
    const HairPoint point = me.hair_point(me.beard, *beard, from + nearest * d, look.beard_colour);
    seen = shade_hair(me.rig, me.up, point, -d);
  } else if (hair) {
    seen = shade_hair(me.rig, me.up, me.hair_point(me.hair, *hair, from + nearest * d, look.colour), -d);
  } else {
    const Vec3f b(1 - body->barycentric.sum(), body->barycentric.x(), body->barycentric.y());
    seen = me.shade_body(body->triangle, b, -d);
  }
  if (!me.lens_scene) return seen;
  const auto lens = me.lens_scene->intersect(from, d, 0.02f, nearest);
  if (lens) seen = 0.93f * seen + shade_lens(me.glasses, me.rig, me.up, from + lens->distance * d, -d);
  return seen;
}

}  // namespace likeness
