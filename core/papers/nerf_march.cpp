// Coarse and fine passes, and pictures.
#include "core/papers/nerf_march.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/render/canonical_samples.h"
#include "core/train/random_stream.h"

namespace likeness {
namespace {

constexpr std::size_t kPictureRays = 1024;  // at once

// Moves each sample to a random place in its stretch.
void jitter(std::span<RaySample> samples, std::uint64_t seed, std::uint64_t pass, std::uint64_t ray) {
  if (seed == 0) return;
  RandomStream random(seed, pass, ray);
  for (RaySample& s : samples) s.t += (random.uniform() - 0.5f) * s.dt;
  std::ranges::sort(samples, {}, &RaySample::t);
}

void evaluate_pass(const NerfScene& scene, int index, bool keep_tapes, NerfPass& pass) {
  const NerfWanted wanted = index == 0 && !keep_tapes ? NerfWanted::density : NerfWanted::all;
  for (int f = 0; f < 2; ++f) {
    const auto part = std::size_t(f);
    const FieldSamples& samples = pass.batch.fields[part];
    const std::size_t n = samples.count();
    pass.sigma[part].resize(n), pass.colour[part].assign(3 * n, 0.f);
    if (n == 0) {
      pass.tapes[part].clear();
      continue;
    }
    const NerfField<float>& field = scene.field(f, index);
    pass.tapes[part].resize(keep_tapes ? (n + kNerfChunk - 1) / kNerfChunk : 0);
    parallel_ranges(n, kNerfChunk, [&](std::size_t begin, std::size_t end) {
      NerfTape<float> passing;
      NerfTape<float>& tape = keep_tapes ? pass.tapes[part][begin / kNerfChunk] : passing;
      const NerfOutputs<float> out =
          nerf_forward(field, nerf_inputs(field.config, samples, begin, end, scene.conditions), tape, wanted);
      std::copy_n(out.sigma.data(), end - begin, pass.sigma[part].data() + begin);
      if (wanted == NerfWanted::all)
        std::copy_n(out.colour.data(), 3 * (end - begin), pass.colour[part].data() + 3 * begin);
    });
  }
  const std::size_t rays = pass.batch.begin.size() - 1;
  pass.rays.resize(rays);
  parallel_ranges(rays, 64, [&](std::size_t begin, std::size_t end) {
    std::vector<float> sigma, colour;
    for (std::size_t r = begin; r < end; ++r) {
      sigma.clear(), colour.clear();
      for (std::uint32_t i = pass.batch.begin[r]; i < pass.batch.begin[r + 1]; ++i) {
        const std::size_t part = pass.batch.field[i], at = pass.batch.slot[i];
        sigma.push_back(pass.sigma[part][at]);
        colour.insert(colour.end(), pass.colour[part].begin() + std::ptrdiff_t(3 * at),
                      pass.colour[part].begin() + std::ptrdiff_t(3 * at + 3));
      }
      pass.rays[r] = composite_ray(int(sigma.size()), sigma.data(),
                                   pass.batch.dt.data() + pass.batch.begin[r], colour.data());
    }
  });
}

}  // namespace

std::size_t parameter_count(const NerfAvatar& avatar) {
  std::size_t count = 0;
  for (const NerfPair* pair : {&avatar.head, avatar.torso ? &*avatar.torso : nullptr})
    if (pair != nullptr)
      for (const NerfField<float>& field : *pair) count += field.parameters.size();
  return count;
}

void ray_weights(const NerfPass& pass, std::size_t ray, std::vector<float>& weights) {
  weights.clear();
  float transmittance = 1;
  for (std::uint32_t i = pass.batch.begin[ray]; i < pass.batch.begin[ray + 1]; ++i) {
    const float sigma = pass.sigma[pass.batch.field[i]][pass.batch.slot[i]];
    const float after = transmittance * std::exp(-sigma * pass.batch.dt[i]);
    weights.push_back(transmittance - after);
    transmittance = after;
  }
}

void march_nerf(const NerfScene& scene, std::span<const RayRequest> rays, const NerfMarchOptions& options,
                bool keep_tapes, std::array<NerfPass, 2>& passes) {
  NerfPass &coarse = passes[0], &fine = passes[1];
  RayStrata strata;
  MarchVolumes volumes = scene.volumes;
  volumes.min_step = options.min_step;
  stratify_rays(rays, volumes, options.coarse, coarse.batch, strata);
  const auto most = std::size_t(options.coarse);
  std::vector<int> counts(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r) {
    counts[r] = int(coarse.batch.begin[r + 1] - coarse.batch.begin[r]);
    jitter({coarse.batch.placed.data() + r * most, std::size_t(counts[r])}, options.seed, 0, r);
  }
  if (options.seed != 0) collect_samples(rays, volumes, most, counts, coarse.batch);
  const std::vector<std::uint32_t> begin = coarse.batch.begin;
  scene.to_canonical(coarse.batch);
  evaluate_pass(scene, 0, keep_tapes, coarse);

  const auto more = std::size_t(options.fine);
  fine.batch.placed.resize(rays.size() * more);
  std::vector<float> weights;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    ray_weights(coarse, r, weights);
    const std::span<RaySample> mine(fine.batch.placed.data() + r * more, more);
    counts[r] = refine_strata(strata.intervals_of(r, 0), strata.intervals_of(r, 1),
                              std::span<const RayStratum>(strata.strata).subspan(begin[r], weights.size()),
                              weights, mine);
    jitter(mine.first(std::size_t(counts[r])), options.seed, 1, r);
  }
  collect_samples(rays, volumes, more, counts, fine.batch);
  scene.to_canonical(fine.batch);
  evaluate_pass(scene, 1, keep_tapes, fine);
}

Image render_nerf(const NerfAvatar& avatar, const Camera& camera, const RenderState& state,
                  const NerfMarchOptions& options) {
  const Avatar& a = avatar.scene;
  std::vector<NeckBend> neck;
  if (!a.neck.empty())
    neck.push_back(make_neck_bend(a.neck, inverse(state.pose.world_from_head) * state.pose.world_from_torso,
                                  a.head.cube.origin, a.head.cube.side));
  const std::span<const WarpLattice> warp(&state.warp, state.warp.empty() ? 0 : 1);
  const std::span<const TorsoField> torso(&state.torso, state.torso.empty() ? 0 : 1);
  const Eigen::VectorXf psi = condition(a.condition, state.pose.articulation);
  NerfScene scene{&avatar.head, avatar.torso ? &*avatar.torso : nullptr, {}, psi.data(), {}};
  scene.volumes = march_volumes(a.head, a.torso ? &*a.torso : nullptr, neck);
  for (MarchNeck& m : scene.volumes.necks) look_up_neck(scene.volumes.fields[0], m);
  scene.to_canonical = [&](SampleBatch& batch) {
    warp_samples(warp, a.head.cube, batch.fields[0]);
    straighten_samples(neck, batch.fields[0]);
    if (a.torso) warp_samples(torso, a.torso->cube, batch.fields[1]);
  };
  std::array<UnitFromCamera, 2> maps;
  maps[0] = unit_from_camera(a.head.cube, camera.cam_from_world, state.pose.world_from_head);
  if (a.torso) maps[1] = unit_from_camera(a.torso->cube, camera.cam_from_world, state.pose.world_from_torso);

  Image rgba(camera.intrinsics.width, camera.intrinsics.height, 4);
  const std::vector<Vec3f> directions = pixel_directions(camera.intrinsics);
  std::array<NerfPass, 2> passes;
  for (std::size_t first = 0; first < directions.size(); first += kPictureRays) {
    std::vector<RayRequest> rays(std::min(kPictureRays, directions.size() - first));
    for (std::size_t i = 0; i < rays.size(); ++i)
      for (std::size_t f = 0; f < (a.torso ? 2u : 1u); ++f)
        rays[i].fields[f] = field_ray(maps[f], directions[first + i]);
    march_nerf(scene, rays, options, false, passes);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Composited<float>& seen = passes[1].rays[i];
      float* pixel = rgba.data.data() + 4 * (first + i);
      std::copy_n(seen.colour, 3, pixel);
      pixel[3] = 1 - seen.transmittance;
    }
  }
  return rgba;
}

}  // namespace likeness
