// Rays of a row at a time through both fields, densities alone.
#include "core/render/ray_depth.h"

#include <array>
#include <cmath>
#include <span>

#include "core/base/rigid.h"
#include "core/field/conditioned_field.h"
#include "core/field/evaluate.h"
#include "core/render/canonical_samples.h"
#include "core/render/rays.h"

namespace likeness {
namespace {

constexpr int kDepthSamples = 64;  // of a ray, at most

// An avatar posed before a camera.
struct DepthScene {
  const Avatar& avatar;
  MarchVolumes volumes;
  std::array<UnitFromCamera, 2> maps;
  std::vector<ConditionedField> fields;
  std::span<const WarpLattice> warp;
  std::span<const TorsoField> torso;
  std::vector<NeckBend> neck;

  DepthScene(const Avatar& shown, const Camera& camera, const RenderState& state) : avatar(shown) {
    const AvatarPose& pose = state.pose;
    maps[0] = unit_from_camera(avatar.head.cube, camera.cam_from_world, pose.world_from_head);
    if (avatar.torso)
      maps[1] = unit_from_camera(avatar.torso->cube, camera.cam_from_world, pose.world_from_torso);
    const Eigen::VectorXf psi =
        condition(avatar.condition, pose.articulation, avatar.attributes, pose.attributes);
    fields.emplace_back(avatar.head.field, std::span(psi.data(), std::size_t(psi.size())),
                        FieldPrecision::exact);
    if (avatar.torso)
      fields.emplace_back(avatar.torso->field, std::span<const float>{}, FieldPrecision::exact);
    if (!state.warp.empty()) warp = {&state.warp, 1};
    if (!state.torso.empty()) torso = {&state.torso, 1};
    if (!avatar.neck.empty())
      neck.push_back(make_neck_bend(avatar.neck, inverse(pose.world_from_head) * pose.world_from_torso,
                                    avatar.head.cube.origin, avatar.head.cube.side));
    volumes = march_volumes(avatar.head, avatar.torso ? &*avatar.torso : nullptr, neck);
    volumes.max_samples = kDepthSamples;
  }

  void to_canonical(SampleBatch& batch) const {
    warp_samples(warp, avatar.head.cube, batch.fields[0]);
    straighten_samples(neck, batch.fields[0]);
    if (fields[0].needs_local()) weigh_attributes(avatar.attributes, avatar.head.cube, batch.fields[0]);
    if (avatar.torso) warp_samples(torso, avatar.torso->cube, batch.fields[1]);
  }
};

}  // namespace

RayDepths ray_depths(const Avatar& avatar, const Camera& camera, const RenderState& state) {
  const DepthScene scene(avatar, camera, state);
  const std::vector<Vec3f> directions = pixel_directions(camera.intrinsics);
  RayDepths depths{std::vector<float>(directions.size(), 0.f), std::vector<float>(directions.size(), 0.f)};
  const auto width = std::size_t(camera.intrinsics.width);
  std::vector<RayRequest> requests(width);
  SampleBatch batch;
  std::array<std::vector<float>, 2> sigma;
  for (std::size_t row = 0; row + width <= directions.size(); row += width) {
    for (std::size_t i = 0; i < width; ++i) {
      requests[i] = {};
      for (std::size_t f = 0; f < 2; ++f)
        if (scene.volumes.fields[f].occupancy)
          requests[i].fields[f] = field_ray(scene.maps[f], directions[row + i]);
    }
    sample_rays(requests, scene.volumes, batch);
    scene.to_canonical(batch);
    for (std::size_t f = 0; f < scene.fields.size(); ++f)
      if (batch.fields[f].count() > 0)
        evaluate_density(scene.fields[f], batch.fields[f].inputs(nullptr, nullptr), sigma[f]);
    for (std::size_t i = 0; i < width; ++i) {
      double transmittance = 1, sum = 0;
      const std::uint32_t begin = batch.begin[i];
      for (std::uint32_t s = begin; s < batch.begin[i + 1]; ++s) {
        const double after =
            transmittance * std::exp(-double(sigma[batch.field[s]][batch.slot[s]]) * batch.dt[s]);
        const RaySample& placed = batch.placed[i * kDepthSamples + (s - begin)];
        sum += (transmittance - after) * placed.t;
        transmittance = after;
      }
      if (transmittance >= 1) continue;
      depths.metres[row + i] = float(sum / (1 - transmittance));
      depths.alpha[row + i] = float(1 - transmittance);
    }
  }
  return depths;
}

}  // namespace likeness
