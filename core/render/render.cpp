// Rendering in bands of pixels, large enough for the field's full speed. Each band evaluates its rays'
// samples front to back in rounds, so that rays which have become opaque cost nothing more.
#include "core/render/render.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/field/evaluate.h"
#include "core/render/pose_avatar.h"
#include "core/render/rays.h"

namespace likeness {
namespace {

constexpr std::size_t kBandRays = 32768;
constexpr int kRoundSamples = 6;  // of each ray per round: most opaque rays end in the first or second

struct RayState {
  Vec3f colour = Vec3f::Zero();
  float transmittance = 1;
};

struct Scene {
  const Avatar& avatar;
  const RenderOptions& options;
  MarchVolumes volumes;
  std::array<UnitFromCamera, 2> maps;
  std::vector<Vec3f> directions;
  Eigen::VectorXf psi;
  std::span<const WarpLattice> warp;  // one or none
  std::span<const TorsoField> torso;  // one or none
  std::vector<NeckBend> neck;         // one or none
};

const Field& field_of(const Scene& scene, int f) {
  return f == 0 ? scene.avatar.head.field : scene.avatar.torso->field;
}

// One sample of one ray waiting in a round: where its result goes.
struct Pending {
  std::uint32_t ray, sample;
};

void copy_sample(const FieldSamples& from, std::size_t i, FieldSamples& to) {
  to.x.push_back(from.x[i]), to.y.push_back(from.y[i]), to.z.push_back(from.z[i]);
  to.dx.push_back(from.dx[i]), to.dy.push_back(from.dy[i]), to.dz.push_back(from.dz[i]);
  to.view.push_back(from.view[i]);
}

// Evaluates samples [round * kRoundSamples, ...) of every ray still transparent; returns how many were
// evaluated.
std::size_t march_round(const Scene& scene, const SampleBatch& batch, std::uint32_t round,
                        std::vector<RayState>& rays) {
  std::array<FieldSamples, 2> samples;
  std::array<FieldOutputs, 2> outputs;
  std::vector<Pending> pending;
  std::vector<std::uint32_t> place;  // of each pending sample within its field's outputs
  for (std::uint32_t r = 0; r < rays.size(); ++r) {
    if (rays[r].transmittance < scene.options.stop_transmittance) continue;
    const std::uint32_t first = batch.begin[r] + round * kRoundSamples;
    const std::uint32_t last = std::min(first + kRoundSamples, batch.begin[r + 1]);
    for (std::uint32_t i = first; i < last; ++i) {
      const int f = batch.field[i];
      pending.push_back({r, i});
      place.push_back(std::uint32_t(samples[f].count()));
      copy_sample(batch.fields[f], batch.slot[i], samples[f]);
    }
  }
  if (pending.empty()) return 0;
  for (int f = 0; f < 2; ++f)
    if (samples[f].count() > 0)
      evaluate_field(field_of(scene, f), samples[f].inputs(scene.psi.data(), nullptr), outputs[f]);
  for (std::size_t k = 0; k < pending.size(); ++k) {
    RayState& ray = rays[pending[k].ray];
    const std::uint32_t i = pending[k].sample;
    const FieldOutputs& out = outputs[batch.field[i]];
    const std::uint32_t at = place[k];
    const float after = ray.transmittance * std::exp(-out.sigma[at] * batch.dt[i]);
    ray.colour += (ray.transmittance - after) * Vec3f(out.red[at], out.green[at], out.blue[at]);
    ray.transmittance = after;
  }
  return pending.size();
}

struct BandCount {
  std::size_t rays = 0, samples = 0;
};

// Pixels first..last of the scene's list into out, 4 numbers each.
BandCount render_band(const Scene& scene, std::size_t first, std::size_t last, float* out) {
  const std::size_t count = last - first;
  std::vector<RayRequest> requests(count);
  for (std::size_t i = 0; i < count; ++i)
    for (int f = 0; f < 2; ++f)
      if (scene.volumes.fields[f].occupancy)
        requests[i].fields[f] = field_ray(scene.maps[f], scene.directions[first + i]);
  SampleBatch batch;
  sample_rays(requests, scene.volumes, batch);
  warp_samples(scene.warp, scene.avatar.head.cube, batch.fields[0]);
  straighten_samples(scene.neck, batch.fields[0]);
  if (scene.avatar.torso) warp_samples(scene.torso, scene.avatar.torso->cube, batch.fields[1]);
  std::vector<RayState> rays(count);
  BandCount band;
  for (std::uint32_t round = 0;; ++round) {
    const std::size_t evaluated = march_round(scene, batch, round, rays);
    if (evaluated == 0) break;
    band.samples += evaluated;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (batch.begin[i + 1] > batch.begin[i]) ++band.rays;
    for (int c = 0; c < 3; ++c) out[4 * i + std::size_t(c)] = rays[i].colour[c];
    out[4 * i + 3] = 1 - rays[i].transmittance;
  }
  return band;
}

Scene make_scene(const Avatar& avatar, const Camera& camera, const RenderState& state,
                 const RenderOptions& options) {
  LIKENESS_CHECK(options.max_samples > 0, "max_samples %d", options.max_samples);
  LIKENESS_CHECK(avatar.warp_cell == 0 || !state.warp.empty(),
                 "an avatar with a warp needs pose_avatar's state (cell %g m)", double(avatar.warp_cell));
  Scene scene{avatar, options, {}, {}, {}, {}, {}, {}, {}};
  scene.maps[0] = unit_from_camera(avatar.head.cube, camera.cam_from_world, state.world_from_head);
  if (avatar.torso)
    scene.maps[1] = unit_from_camera(avatar.torso->cube, camera.cam_from_world, state.world_from_torso);
  scene.psi = condition(avatar.condition, state.articulation);
  if (!state.warp.empty()) scene.warp = {&state.warp, 1};
  if (!state.torso.empty()) scene.torso = {&state.torso, 1};
  if (!avatar.neck.empty()) {
    scene.neck.push_back(make_neck_bend(avatar.neck, state.world_from_head.inverse() * state.world_from_torso,
                                        avatar.head.cube.origin, avatar.head.cube.side));
  }
  scene.volumes = march_volumes(avatar.head, avatar.torso ? &*avatar.torso : nullptr, scene.neck);
  scene.volumes.max_samples = options.max_samples;
  scene.volumes.min_step = options.min_step;
  return scene;
}

BandCount render_all(const Scene& scene, float* out) {
  BandCount all;
  for (std::size_t first = 0; first < scene.directions.size(); first += kBandRays) {
    const std::size_t last = std::min(first + kBandRays, scene.directions.size());
    const BandCount band = render_band(scene, first, last, out + 4 * first);
    all.rays += band.rays, all.samples += band.samples;
  }
  return all;
}

}  // namespace

RenderOptions render_options(RenderQuality quality) {
  RenderOptions options;
  if (quality == RenderQuality::preview) {
    options.max_samples = 8;
    options.stop_transmittance = 0.02f;
    options.reduce = 2;
  }
  return options;
}

RenderedFrame render_frame(const Avatar& avatar, const Camera& camera, const RenderState& state,
                           const RenderOptions& options) {
  if (options.reduce > 1) {
    Camera fewer = camera;
    Intrinsics& k = fewer.intrinsics;
    const int width = (k.width + options.reduce - 1) / options.reduce,
              height = (k.height + options.reduce - 1) / options.reduce;
    const double sx = double(width) / k.width, sy = double(height) / k.height;
    k.width = width, k.height = height;
    k.fx *= sx, k.cx *= sx, k.fy *= sy, k.cy *= sy;
    RenderOptions whole = options;
    whole.reduce = 1;
    RenderedFrame frame = render_frame(avatar, fewer, state, whole);
    frame.rgba = enlarge(frame.rgba, camera.intrinsics.width, camera.intrinsics.height);
    return frame;
  }
  Scene scene = make_scene(avatar, camera, state, options);
  scene.directions = pixel_directions(camera.intrinsics);
  RenderedFrame frame;
  frame.rgba = Image(camera.intrinsics.width, camera.intrinsics.height, 4);
  const BandCount count = render_all(scene, frame.rgba.data.data());
  frame.samples_per_ray = count.rays > 0 ? double(count.samples) / double(count.rays) : 0;
  return frame;
}

std::vector<float> render_pixels(const Avatar& avatar, const Camera& camera, const RenderState& state,
                                 std::span<const std::uint32_t> pixels, const RenderOptions& options) {
  LIKENESS_CHECK(options.reduce == 1, "single pixels are rendered whole, not reduced by %d", options.reduce);
  Scene scene = make_scene(avatar, camera, state, options);
  const auto width = std::uint32_t(camera.intrinsics.width);
  for (const std::uint32_t pixel : pixels)
    scene.directions.push_back(
        ray_direction(camera.intrinsics, Vec2d(pixel % width + 0.5, pixel / width + 0.5))
            .normalized()
            .cast<float>());
  std::vector<float> rgba(4 * pixels.size());
  render_all(scene, rgba.data());
  return rgba;
}

Camera typical_camera(const Avatar& avatar) { return {-1, avatar.intrinsics, avatar.cam_from_world}; }

RenderState typical_state(const Avatar& avatar) {
  return {avatar.world_from_head, avatar.world_from_torso, avatar.neutral};
}

Image composite(const Image& rgba, const Image8& plate, const Vec3f& colour) {
  LIKENESS_CHECK(rgba.channels == 4, "composite of %d channels", rgba.channels);
  LIKENESS_CHECK(
      plate.empty() || (plate.width == rgba.width && plate.height == rgba.height && plate.channels == 3),
      "plate %dx%dx%d for a picture of %dx%d", plate.width, plate.height, plate.channels, rgba.width,
      rgba.height);
  Image out(rgba.width, rgba.height, 3);
  for (std::size_t i = 0; i < rgba.pixels(); ++i)
    for (int c = 0; c < 3; ++c) {
      const float behind = plate.empty() ? colour[c] : float(plate.data[i * 3 + c]) / 255.f;
      out.data[i * 3 + c] = rgba.data[i * 4 + c] + (1 - rgba.data[i * 4 + 3]) * behind;
    }
  return out;
}

}  // namespace likeness
