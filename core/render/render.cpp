// Rendering in bands of rays, shared among the threads. Each band evaluates the densities of all its samples,
// which lie where light is lost, so few are wasted, and colours only where they count.
#include "core/render/render.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/check.h"
#include "core/base/lending_pool.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/field/conditioned_field.h"
#include "core/field/evaluate.h"
#include "core/render/canonical_samples.h"
#include "core/render/pixel_bands.h"
#include "core/render/rays.h"
#include "core/render/stand_in.h"

namespace likeness {
namespace {

constexpr std::size_t kBandPixels = std::size_t(kTileSide) * kTileSide;

struct RayState {
  Vec3f colour = Vec3f::Zero();
  float transmittance = 1;
  float shaded = 0;  // light lost to samples whose colour was looked up
};

struct Scene {
  const Avatar& avatar;
  const RenderOptions& options;
  MarchVolumes volumes;
  std::array<UnitFromCamera, 2> maps;
  std::vector<ConditionedField> fields;  // of head and torso; none with a stand-in
  const StandInFields* stand_in = nullptr;
  std::span<const WarpLattice> warp;            // one or none
  std::span<const TorsoField> torso;            // one or none
  std::vector<NeckBend> neck;                   // one or none
  std::span<const AttributeRegion> attributes;  // none where all of them are at rest
};

// A band's scratch, kept for the next one: fresh memory is slow to touch.
struct BandScratch {
  std::vector<RayRequest> requests;  // of the pixels
  SampleBatch batch;
  std::vector<int> counts;  // samples of each pixel
  // Of the blocks of pixels that share their strata.
  std::vector<RayRequest> block_requests;
  SampleBatch block_batch;
  RayStrata strata;
  std::vector<float> weights;      // (strata)
  std::vector<RaySample> refined;  // (blocks, max_samples)
  std::vector<RayState> rays;
  struct OfField {
    std::vector<float> sigma;
    GeometryFeatures geometry;
    std::vector<std::uint32_t> shaded;       // samples whose colour counts,
    std::vector<std::uint32_t> shaded_rays;  // their rays,
    std::vector<float> weights;              // and their weights
    FieldOutputs colours;
  };
  std::array<OfField, 2> fields;
  std::vector<Vec3f> stand_in_colours;  // (rays)
};

// The share of light of every sample, and the list of those whose colour counts.
void weigh_samples(const Scene& scene, BandScratch& band) {
  const SampleBatch& batch = band.batch;
  for (std::uint32_t r = 0; r < band.rays.size(); ++r) {
    RayState& ray = band.rays[r];
    for (std::uint32_t i = batch.begin[r]; i < batch.begin[r + 1]; ++i) {
      BandScratch::OfField& own = band.fields[batch.field[i]];
      const std::uint32_t slot = batch.slot[i];
      const float after = ray.transmittance * std::exp(-own.sigma[slot] * batch.dt[i]);
      const float weight = ray.transmittance - after;
      ray.transmittance = after;
      if (weight >= scene.options.shade_weight) {
        own.shaded.push_back(slot);
        own.shaded_rays.push_back(r);
        own.weights.push_back(weight);
      }
      if (after < scene.options.stop_transmittance) break;
    }
  }
}

// Merges each ray's samples of a field into the heaviest, with their total weight and mean geometry features.
void merge_shaded(BandScratch::OfField& own) {
  const std::size_t stride = own.geometry.values.size() / std::max<std::size_t>(1, own.sigma.size());
  const auto features = [&](std::size_t k) { return own.geometry.values.data() + own.shaded[k] * stride; };
  std::size_t merged = 0;
  for (std::size_t first = 0, end = 0; first < own.shaded.size(); first = end) {
    std::size_t heaviest = first;
    float sum = 0;
    for (end = first; end < own.shaded.size() && own.shaded_rays[end] == own.shaded_rays[first]; ++end) {
      sum += own.weights[end];
      if (own.weights[end] > own.weights[heaviest]) heaviest = end;
    }
    float* mean = features(heaviest);
    for (std::size_t i = 0; i < stride; ++i) mean[i] *= own.weights[heaviest] / sum;
    for (std::size_t k = first; k < end; ++k) {
      if (k == heaviest) continue;
      const float* other = features(k);
      for (std::size_t i = 0; i < stride; ++i) mean[i] += own.weights[k] / sum * other[i];
    }
    own.shaded[merged] = own.shaded[heaviest];
    own.shaded_rays[merged] = own.shaded_rays[first];
    own.weights[merged] = sum;
    ++merged;
  }
  own.shaded.resize(merged), own.shaded_rays.resize(merged), own.weights.resize(merged);
}

// The same for a stand-in for the fields.
void march_stand_in(const Scene& scene, BandScratch& band) {
  std::array<WeightedSamples, 2> parts;
  for (int f = 0; f < 2; ++f) {
    BandScratch::OfField& own = band.fields[std::size_t(f)];
    own.shaded.clear(), own.shaded_rays.clear(), own.weights.clear();
    if (band.batch.fields[f].count() > 0) scene.stand_in->densities(f, band.batch.fields[f], own.sigma);
  }
  weigh_samples(scene, band);
  for (std::size_t f = 0; f < 2; ++f) {
    const BandScratch::OfField& own = band.fields[f];
    parts[f] = {&band.batch.fields[f], own.shaded, own.shaded_rays, own.weights};
    for (std::size_t k = 0; k < own.shaded.size(); ++k)
      band.rays[own.shaded_rays[k]].shaded += own.weights[k];
  }
  band.stand_in_colours.assign(band.rays.size(), Vec3f::Zero());
  scene.stand_in->colours(parts, band.stand_in_colours);
  for (std::size_t r = 0; r < band.rays.size(); ++r) band.rays[r].colour = band.stand_in_colours[r];
}

// The rays' colours and transmittances from their samples; returns the number of samples.
std::size_t march(const Scene& scene, BandScratch& band) {
  if (scene.stand_in != nullptr) {
    march_stand_in(scene, band);
    return band.batch.dt.size();
  }
  for (int f = 0; f < 2; ++f) {
    BandScratch::OfField& own = band.fields[std::size_t(f)];
    own.shaded.clear(), own.shaded_rays.clear(), own.weights.clear();
    if (band.batch.fields[f].count() > 0)
      evaluate_density(scene.fields[std::size_t(f)], band.batch.fields[f].inputs(nullptr, nullptr), own.sigma,
                       own.geometry);
  }
  weigh_samples(scene, band);
  for (int f = 0; f < 2; ++f) {
    BandScratch::OfField& own = band.fields[std::size_t(f)];
    if (own.shaded.empty()) continue;
    if (scene.options.deferred) merge_shaded(own);
    evaluate_colour(scene.fields[std::size_t(f)], band.batch.fields[f].inputs(nullptr, nullptr), own.geometry,
                    own.shaded, own.colours);
    const FieldOutputs& c = own.colours;
    for (std::size_t k = 0; k < own.shaded.size(); ++k) {
      RayState& ray = band.rays[own.shaded_rays[k]];
      ray.colour += own.weights[k] * Vec3f(c.red[k], c.green[k], c.blue[k]);
      ray.shaded += own.weights[k];
    }
  }
  return band.batch.dt.size();
}

struct BandCount {
  std::size_t rays = 0, samples = 0;
  void operator+=(const BandCount& other) { rays += other.rays, samples += other.samples; }
};

RayRequest request_of(const Scene& scene, const Vec3f& direction) {
  RayRequest request;
  for (int f = 0; f < 2; ++f)
    if (scene.volumes.fields[f].occupancy) request.fields[f] = field_ray(scene.maps[f], direction);
  return request;
}

// Maps samples to their fields' canonical space.
void to_canonical(const Scene& scene, SampleBatch& batch) {
  warp_samples(scene.warp, scene.avatar.head.cube, batch.fields[0]);
  straighten_samples(scene.neck, batch.fields[0]);
  weigh_attributes(scene.attributes, scene.avatar.head.cube, batch.fields[0]);
  if (scene.avatar.torso) warp_samples(scene.torso, scene.avatar.torso->cube, batch.fields[1]);
}

// The share of light of every stratum of the blocks, by the density in its middle; returns the number of
// look-ups.
std::size_t weigh_strata(const Scene& scene, BandScratch& band) {
  const SampleBatch& batch = band.block_batch;
  for (int f = 0; f < 2; ++f) {
    if (batch.fields[f].count() == 0) continue;
    std::vector<float>& sigma = band.fields[std::size_t(f)].sigma;
    if (scene.stand_in != nullptr)
      scene.stand_in->densities(f, batch.fields[f], sigma);
    else
      evaluate_density(scene.fields[std::size_t(f)], batch.fields[f].inputs(nullptr, nullptr), sigma);
  }
  band.weights.resize(band.strata.strata.size());
  for (std::size_t r = 0; r + 1 < batch.begin.size(); ++r) {
    float transmittance = 1;
    for (std::uint32_t i = batch.begin[r]; i < batch.begin[r + 1]; ++i) {
      const float sigma = band.fields[batch.field[i]].sigma[batch.slot[i]];
      const float after = transmittance * std::exp(-sigma * batch.dt[i]);
      band.weights[i] = transmittance - after;
      transmittance = after;
    }
  }
  return band.strata.strata.size();
}

// Pixels at the volume's edge whose block's ray met nothing, although theirs may, are walked separately.
void place_at_edges(const Scene& scene, const Band& pixels, std::span<const int> counts, BandScratch& band) {
  const int columns = pixels.block_columns, rows = columns > 0 ? int(counts.size()) / columns : 0;
  if (columns == 0 && !pixels.empty_blocks_walk) return;
  const auto near_volume = [&](int block) {
    if (pixels.empty_blocks_walk) return true;
    for (int y = std::max(0, block / columns - 1); y <= std::min(rows - 1, block / columns + 1); ++y)
      for (int x = std::max(0, block % columns - 1); x <= std::min(columns - 1, block % columns + 1); ++x)
        if (counts[std::size_t(y * columns + x)] > 0) return true;
    return false;
  };
  std::vector<std::size_t> alone;
  std::vector<RayRequest> requests;
  for (std::size_t i = 0; i < band.requests.size(); ++i)
    if (const std::uint32_t k = pixels.block_of[i]; counts[k] == 0 && near_volume(int(k))) {
      alone.push_back(i);
      requests.push_back(band.requests[i]);
    }
  if (alone.empty()) return;
  SampleBatch batch;
  sample_rays(requests, scene.volumes, batch);
  const auto most = std::size_t(scene.options.max_samples);
  for (std::size_t k = 0; k < alone.size(); ++k) {
    const std::size_t count = batch.begin[k + 1] - batch.begin[k];
    band.counts[alone[k]] = int(count);
    std::copy_n(batch.placed.begin() + std::ptrdiff_t(k * most), count,
                band.batch.placed.begin() + std::ptrdiff_t(alone[k] * most));
  }
}

// Places the pixels' samples at the distances found by their block's ray. Returns the number of densities
// evaluated.
std::size_t place_by_blocks(const Scene& scene, const Band& pixels, BandScratch& band) {
  band.block_requests.resize(pixels.blocks.size());
  for (std::size_t k = 0; k < pixels.blocks.size(); ++k)
    band.block_requests[k] = request_of(scene, pixels.blocks[k]);
  stratify_rays(band.block_requests, scene.volumes, scene.options.strata, band.block_batch, band.strata);
  to_canonical(scene, band.block_batch);
  const std::size_t looked_up = weigh_strata(scene, band);

  const auto most = std::size_t(scene.options.max_samples);
  band.refined.resize(pixels.blocks.size() * most);
  std::vector<int> counts(pixels.blocks.size());
  for (std::size_t k = 0; k < pixels.blocks.size(); ++k) {
    const std::size_t begin = band.block_batch.begin[k], count = band.block_batch.begin[k + 1] - begin;
    const auto strata = std::span<const RayStratum>(band.strata.strata).subspan(begin, count);
    const auto weights = std::span<const float>(band.weights).subspan(begin, count);
    counts[k] = refine_strata(band.strata.intervals_of(k, 0), band.strata.intervals_of(k, 1), strata, weights,
                              std::span(band.refined).subspan(k * most, most));
  }
  band.batch.placed.resize(band.requests.size() * most);
  band.counts.resize(band.requests.size());
  for (std::size_t i = 0; i < band.requests.size(); ++i) {
    const std::size_t k = pixels.block_of[i];
    const auto mine = band.batch.placed.begin() + std::ptrdiff_t(i * most);
    std::copy_n(band.refined.begin() + std::ptrdiff_t(k * most), counts[k], mine);
    band.counts[i] = keep_occupied(band.requests[i], scene.volumes, {&*mine, std::size_t(counts[k])});
  }
  place_at_edges(scene, pixels, counts, band);
  collect_samples(band.requests, scene.volumes, most, band.counts, band.batch);
  return looked_up;
}

// A band's pixels into out, 4 numbers each.
BandCount render_band(const Scene& scene, const Band& pixels, BandScratch& band, float* out) {
  const std::size_t count = pixels.directions.size();
  band.requests.resize(count);
  for (std::size_t i = 0; i < count; ++i) band.requests[i] = request_of(scene, pixels.directions[i]);
  BandCount sum;
  if (scene.options.strata > 0)
    sum.samples += place_by_blocks(scene, pixels, band);
  else
    sample_rays(band.requests, scene.volumes, band.batch);
  const SampleBatch& batch = band.batch;
  to_canonical(scene, band.batch);
  band.rays.assign(count, {});
  sum.samples += march(scene, band);
  for (std::size_t i = 0; i < count; ++i) {
    if (batch.begin[i + 1] > batch.begin[i]) ++sum.rays;
    const RayState& ray = band.rays[i];
    // A ray that was cut off would have met more; it counts as opaque.
    const float alpha = ray.transmittance < scene.options.stop_transmittance ? 1 : 1 - ray.transmittance;
    // Samples not looked up are given the mean colour of those that were.
    const float scale = ray.shaded > 0 ? alpha / ray.shaded : 0;
    float* to = out + 4 * std::size_t(pixels.place[i]);
    for (int c = 0; c < 3; ++c) to[c] = scale * ray.colour[c];
    to[3] = alpha;
  }
  return sum;
}

Scene make_scene(const Avatar& avatar, const Camera& camera, const RenderState& state,
                 const RenderOptions& options, const StandInFields* stand_in = nullptr) {
  LIKENESS_CHECK(options.max_samples > 0 && options.strata >= 0 && options.block > 0,
                 "max_samples %d, strata %d, block %d", options.max_samples, options.strata, options.block);
  LIKENESS_CHECK(avatar.warp_cell == 0 || !state.warp.empty(),
                 "an avatar with a warp needs pose_avatar's state (cell %g m)", double(avatar.warp_cell));
  Scene scene{avatar, options, {}, {}, {}, stand_in, {}, {}, {}, {}};
  scene.maps[0] = unit_from_camera(avatar.head.cube, camera.cam_from_world, state.pose.world_from_head);
  if (avatar.torso)
    scene.maps[1] = unit_from_camera(avatar.torso->cube, camera.cam_from_world, state.pose.world_from_torso);
  const Eigen::VectorXf psi =
      condition(avatar.condition, state.pose.articulation, avatar.attributes, state.pose.attributes);
  // Preparations for the rays, divided among the threads.
  std::array<std::optional<ConditionedField>, 2> fields;
  const std::size_t parts = avatar.torso ? 2 : 1;
  parallel_for(2 * parts, [&](std::size_t i) {
    const bool head = i % parts == 0;
    const FieldPart& part = head ? avatar.head : *avatar.torso;
    if (i >= parts)
      scene.volumes.fields[i % parts] = march_volume(part.occupancy, part.core, part.cube.side, part.opacity);
    else if (stand_in == nullptr)
      fields[i].emplace(part.field,
                        head ? std::span(psi.data(), std::size_t(psi.size())) : std::span<const float>{},
                        options.precision);
  });
  for (std::size_t i = 0; i < parts && stand_in == nullptr; ++i)
    scene.fields.push_back(std::move(*fields[i]));
  if (!scene.fields.empty() && scene.fields[0].needs_local()) scene.attributes = avatar.attributes;
  if (!state.warp.empty()) scene.warp = {&state.warp, 1};
  if (!state.torso.empty()) scene.torso = {&state.torso, 1};
  if (!avatar.neck.empty()) {
    scene.neck.push_back(make_neck_bend(avatar.neck,
                                        inverse(state.pose.world_from_head) * state.pose.world_from_torso,
                                        avatar.head.cube.origin, avatar.head.cube.side));
  }
  for (const NeckBend& neck : scene.neck)
    scene.volumes.necks.push_back(march_neck(neck, scene.volumes.fields[0]));
  for (MarchNeck& neck : scene.volumes.necks) look_up_neck(scene.volumes.fields[0], neck);
  scene.volumes.max_samples = options.max_samples;
  scene.volumes.min_step = options.min_step;
  return scene;
}

// make_band(k): the pixels of band k.
template <class MakeBand>
BandCount render_bands(const Scene& scene, std::size_t count, const MakeBand& make_band, float* out) {
  std::vector<BandCount> bands(count);
  LendingPool<BandScratch> pool;
  parallel_for(count, [&](std::size_t k) {
    auto scratch = pool.take();
    bands[k] = render_band(scene, make_band(k), *scratch, out);
    pool.give(std::move(scratch));
  });
  BandCount all;
  for (const BandCount& band : bands) all += band;
  return all;
}

// The whole picture, tile by tile.
BandCount render_tiles(const Scene& scene, const Intrinsics& k, Image& rgba) {
  const int columns = (k.width + kTileSide - 1) / kTileSide, rows = (k.height + kTileSide - 1) / kTileSide;
  const auto tile = [&](std::size_t i) {
    return tile_band(k, int(i) % columns * kTileSide, int(i) / columns * kTileSide, scene.options.block);
  };
  return render_bands(scene, std::size_t(columns) * std::size_t(rows), tile, rgba.data.data());
}

}  // namespace

RenderOptions render_options(RenderQuality quality) {
  RenderOptions options;
  options.precision = FieldPrecision::bf16;
  if (quality == RenderQuality::final) {
    options.max_samples = 20, options.strata = 8, options.block = 2;
    options.reduce = 2;
  } else {
    options.max_samples = 14, options.strata = 8, options.block = 3;
    options.max_rays = 39200, options.edge_contrast = 0.05f;
  }
  return options;
}

namespace {

RenderedFrame render_scene(const Scene& scene, const Camera& camera) {
  const RenderOptions& options = scene.options;
  LIKENESS_CHECK(options.reduce > 0 && options.max_rays >= 0, "reduce %d, max_rays %d", options.reduce,
                 options.max_rays);
  RenderedFrame frame;
  const Intrinsics& full = camera.intrinsics;
  const float size = float(full.width) * float(full.height) / float(kUsualPixels);
  const auto rays = std::size_t(float(options.max_rays) * std::max(size, 1.f));
  const int reduce = rays > 0 ? reduction(full, rays) : options.reduce;
  const Intrinsics fewer = reduced(full, reduce);
  frame.rgba = Image(fewer.width, fewer.height, 4);
  BandCount count = render_tiles(scene, fewer, frame.rgba);
  if (reduce > 1) {
    const std::size_t cost = std::size_t(reduce) * std::size_t(reduce);  // rays a cell
    const std::size_t most =
        rays > 0 ? (rays - frame.rgba.pixels()) / cost : std::numeric_limits<std::size_t>::max();
    const std::vector<Eigen::Vector2i> edges =
        edge_cells(frame.rgba, options.edge_contrast * std::min(size, 1.f), most);
    frame.rgba = enlarge(frame.rgba, full.width, full.height);
    const std::size_t cells_per_band = std::max<std::size_t>(1, kBandPixels / cost);
    const auto part = [&](std::size_t i) {
      const std::size_t first = i * cells_per_band;
      return edge_band(full, fewer,
                       std::span(edges).subspan(first, std::min(cells_per_band, edges.size() - first)));
    };
    count += render_bands(scene, (edges.size() + cells_per_band - 1) / cells_per_band, part,
                          frame.rgba.data.data());
  }
  frame.samples_per_ray = count.rays > 0 ? double(count.samples) / double(count.rays) : 0;
  return frame;
}

}  // namespace

RenderedFrame render_frame(const Avatar& avatar, const Camera& camera, const RenderState& state,
                           const RenderOptions& options) {
  return render_scene(make_scene(avatar, camera, state, options), camera);
}

RenderedFrame render_frame(const Avatar& avatar, const StandInFields& fields, const Camera& camera,
                           const RenderState& state, const RenderOptions& options) {
  return render_scene(make_scene(avatar, camera, state, options, &fields), camera);
}

std::vector<float> render_pixels(const Avatar& avatar, const Camera& camera, const RenderState& state,
                                 std::span<const std::uint32_t> pixels, const RenderOptions& options) {
  LIKENESS_CHECK(options.reduce == 1 && options.max_rays == 0,
                 "single pixels are rendered whole, not reduced by %d or to %d rays", options.reduce,
                 options.max_rays);
  const Scene scene = make_scene(avatar, camera, state, options);
  std::vector<float> rgba(4 * pixels.size());
  const auto part = [&](std::size_t i) {
    return listed_band(camera.intrinsics, pixels, i * kBandPixels,
                       std::min(pixels.size(), (i + 1) * kBandPixels));
  };
  render_bands(scene, (pixels.size() + kBandPixels - 1) / kBandPixels, part, rgba.data());
  return rgba;
}

Camera typical_camera(const Avatar& avatar) { return {-1, avatar.intrinsics, avatar.cam_from_world}; }

RenderState typical_state(const Avatar& avatar) {
  return {.pose = {.world_from_head = avatar.world_from_head,
                   .world_from_torso = avatar.world_from_torso,
                   .articulation = avatar.neutral}};
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
