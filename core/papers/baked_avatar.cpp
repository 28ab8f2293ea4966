// Storing an avatar's fields and training the network that adds to each ray: see baked_avatar.h.
#include "core/papers/baked_avatar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/base/work_clock.h"
#include "core/field/adam.h"
#include "core/field/conditioned_field.h"
#include "core/field/evaluate.h"
#include "core/render/canonical_samples.h"
#include "core/train/check_set.h"
#include "core/train/random_stream.h"
#include "core/train/ray_batch.h"
#include "core/train/refine_track.h"

namespace likeness {
namespace {

constexpr std::size_t kRaysAtOnce = 4096;
constexpr int kStrata = 16;          // of a training ray, whose densities place its samples
constexpr float kMinLight = 0.001f;  // of the head's, for a ray on which R is evaluated
constexpr int kHeadValues = 3 + kBakedFeatures;

// Directions of the training cameras' middles, in the head's frame.
std::vector<Vec3f> seen_directions(const TrainingSet& set, int count) {
  const auto views = own_views(set);
  std::vector<Vec3f> directions;
  const std::size_t n = std::min<std::size_t>(views.size(), std::size_t(std::max(1, count)));
  for (std::size_t k = 0; k < n; ++k) {
    const TrainingView& view = views[k * views.size() / n];
    const Vec3d eye = inverse(view.camera.cam_from_world * view.pose.world_from_head).translation();
    directions.push_back((-eye).normalized().cast<float>());
  }
  return directions;
}

void set_direction(FieldSamples& samples, const Vec3f& d) {
  std::ranges::fill(samples.dx, d.x());
  std::ranges::fill(samples.dy, d.y());
  std::ranges::fill(samples.dz, d.z());
}

// A field in one condition: density, and the mean colour over the directions.
VoxelSource source_of(const ConditionedField& field, std::vector<Vec3f> directions) {
  VoxelSource source;
  source.densities = [&field](const FieldSamples& places, std::vector<float>& sigma) {
    evaluate_density(field, places.inputs(nullptr, nullptr), sigma);
  };
  source.values = [&field, directions = std::move(directions)](const FieldSamples& places,
                                                               std::span<float> values) {
    std::vector<float> sigma;
    GeometryFeatures geometry;
    FieldSamples seen = places;
    evaluate_density(field, seen.inputs(nullptr, nullptr), sigma, geometry);
    std::vector<std::uint32_t> all(places.count());
    std::iota(all.begin(), all.end(), 0u);
    std::ranges::fill(values, 0.f);
    const float share = 1.f / float(directions.size());
    FieldOutputs colours;
    for (const Vec3f& direction : directions) {
      set_direction(seen, direction);
      evaluate_colour(field, seen.inputs(nullptr, nullptr), geometry, all, colours);
      for (std::size_t i = 0; i < all.size(); ++i) {
        values[3 * i] += share * colours.red[i];
        values[3 * i + 1] += share * colours.green[i];
        values[3 * i + 2] += share * colours.blue[i];
      }
    }
  };
  return source;
}

void look_up_densities(const SparseVoxels& voxels, const FieldSamples& samples, std::vector<float>& sigma) {
  sigma.resize(samples.count());
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    const VoxelPlace place = find_place(voxels, samples.x[i], samples.y[i], samples.z[i]);
    sigma[i] = 0;
    if (place.node != nullptr) interpolate(voxels, place, 1, &sigma[i]);
  }
}

// What the gathering of training rays needs.
struct Gathering {
  const RaySource& source;
  const Avatar& avatar;
  const ConditionedField& head;               // for the inputs of its colour network
  std::array<const SparseVoxels*, 2> voxels;  // density and colour; the torso's may be absent
  MarchVolumes volumes;

  void to_canonical(SampleBatch& batch) const {
    warp_samples(source.warps, avatar.head.cube, batch.fields[0]);
    straighten_samples(source.necks, batch.fields[0]);
    if (avatar.torso) warp_samples(source.torsos, avatar.torso->cube, batch.fields[1]);
  }
};

// Samples where the voxels lose the light.
void place_rays(const Gathering& g, const RayBatch& rays, int samples, SampleBatch& batch) {
  RayStrata strata;
  stratify_rays(rays.requests, g.volumes, kStrata, batch, strata);
  const std::vector<std::uint32_t> begin = batch.begin;
  g.to_canonical(batch);
  std::array<std::vector<float>, 2> sigma;
  for (std::size_t f = 0; f < 2; ++f)
    if (batch.fields[f].count() > 0) look_up_densities(*g.voxels[f], batch.fields[f], sigma[f]);
  const auto most = std::size_t(samples);
  std::vector<RaySample> placed(rays.requests.size() * most);
  std::vector<int> counts(rays.requests.size());
  std::vector<float> weights;
  for (std::size_t r = 0; r < rays.requests.size(); ++r) {
    weights.clear();
    float transmittance = 1;
    for (std::uint32_t i = begin[r]; i < begin[r + 1]; ++i) {
      const float after = transmittance * std::exp(-sigma[batch.field[i]][batch.slot[i]] * batch.dt[i]);
      weights.push_back(transmittance - after);
      transmittance = after;
    }
    counts[r] = refine_strata(strata.intervals_of(r, 0), strata.intervals_of(r, 1),
                              std::span<const RayStratum>(strata.strata).subspan(begin[r], weights.size()),
                              weights, std::span(placed).subspan(r * most, most));
  }
  batch.placed = std::move(placed);
  collect_samples(rays.requests, g.volumes, most, counts, batch);
  g.to_canonical(batch);
}

void gather(const Gathering& g, const RayBatch& rays, int samples, BakedRays& out) {
  SampleBatch batch;
  place_rays(g, rays, samples, batch);
  const auto given = std::size_t(out.features);
  std::array<std::vector<float>, 2> values;  // (N, density, colour (3) and, of the head, what is given)
  const std::array<std::size_t, 2> widths{4 + given, 4};
  for (std::size_t f = 0; f < 2; ++f) {
    const FieldSamples& own = batch.fields[f];
    if (own.count() == 0) continue;
    values[f].assign(own.count() * widths[f], 0.f);
    std::vector<float> sigma;
    GeometryFeatures geometry;
    if (f == 0) evaluate_density(g.head, own.inputs(nullptr, nullptr), sigma, geometry);
    const std::size_t stride = geometry.values.size() / own.count();
    parallel_ranges(own.count(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const VoxelPlace place = find_place(*g.voxels[f], own.x[i], own.y[i], own.z[i]);
        if (place.node == nullptr) continue;
        float* to = values[f].data() + i * widths[f];
        interpolate(*g.voxels[f], place, 4, to);
        if (f == 0) std::copy_n(geometry.values.data() + i * stride, given, to + 4);
      }
    });
  }
  std::vector<BakedSample> ray;
  for (std::size_t r = 0; r < rays.requests.size(); ++r) {
    ray.clear();
    Vec3f direction = Vec3f::Zero();
    for (std::uint32_t i = batch.begin[r]; i < batch.begin[r + 1]; ++i) {
      const std::size_t f = batch.field[i], slot = batch.slot[i];
      const float* own = values[f].data() + slot * widths[f];
      ray.push_back({int(f), own[0] * batch.dt[i], own + 1});
      const FieldSamples& of = batch.fields[f];
      if (f == 0 && direction.isZero()) direction = Vec3f(of.dx[slot], of.dy[slot], of.dz[slot]);
    }
    add_ray(ray, direction, rays.requests[r].view, rays.background[r], rays.target[r], out);
  }
}

// Its picture's colour of each chosen ray as the network's inputs; rays are columns.
template <class Real>
DenseNodes<Real> nodes_of(const DenseNetworkSpec& network, const BakedRays& rays,
                          std::span<const std::uint32_t> chosen, const std::vector<float>& conditions) {
  DenseNodes<Real> nodes(network.inputs.size() + network.layers.size());
  const auto fill = [&](std::size_t node, const std::vector<float>& values, const auto& row) {
    const int rows = network.inputs[node];
    nodes[node].resize(rows, Eigen::Index(chosen.size()));
    for (std::size_t k = 0; k < chosen.size(); ++k)
      for (int i = 0; i < rows; ++i)
        nodes[node](i, Eigen::Index(k)) = Real(values[row(chosen[k]) * std::size_t(rows) + std::size_t(i)]);
  };
  const auto own = [](std::uint32_t r) { return std::size_t(r); };
  fill(0, rays.given, own), fill(1, rays.diffuse, own), fill(2, rays.view, own);
  fill(3, conditions, [&](std::uint32_t r) { return std::size_t(rays.condition[r]); });
  return nodes;
}

// R without the map to features, as used for pictures: there the features are stored.
DenseNetworkSpec picture_network(int conditions) {
  DenseNetworkSpec spec{{kBakedFeatures, 3, kViewTerms, conditions}, {}};
  for (int l = 0; l < kRayNetworkLayers; ++l)
    spec.layers.push_back({l == 0 ? std::vector<int>{0, 1, 2, 3} : std::vector<int>{3 + l}, kRayNetworkWidth,
                           Activation::relu});
  spec.layers.push_back({{3 + kRayNetworkLayers}, 3, Activation::none});
  return spec;
}

}  // namespace

std::size_t stored_bytes(const BakedAvatar& avatar) {
  return avatar.head.bytes() + (avatar.torso ? avatar.torso->bytes() : 0) +
         avatar.parameters.size() * sizeof(float);
}

void view_terms(float x, float y, float z, float* out) {
  const float terms[kViewTerms] = {x, y, z, x * y, y * z, z * x, x * x - y * y, 3 * z * z - 1};
  std::copy_n(terms, kViewTerms, out);
}

void add_ray(std::span<const BakedSample> samples, const Vec3f& direction, std::int32_t condition,
             const Vec3f& background, const Vec3f& target, BakedRays& rays) {
  const auto features = std::size_t(rays.features);
  std::vector<float> mean(3 + features, 0.f);
  Vec3f rest = Vec3f::Zero();
  float transmittance = 1, light = 0;
  for (const BakedSample& s : samples) {
    const float after = transmittance * std::exp(-s.depth), weight = transmittance - after;
    transmittance = after;
    if (s.part == 0) {
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += weight * s.values[i];
      light += weight;
    } else {
      for (int c = 0; c < 3; ++c) rest[c] += weight * s.values[c];
    }
  }
  if (light < kMinLight) return;
  rest += transmittance * background;
  for (std::size_t i = 0; i < 3; ++i) rays.diffuse.push_back(mean[i] / light);
  for (std::size_t i = 0; i < features; ++i) rays.given.push_back(mean[3 + i] / light);
  rays.light.push_back(light);
  rays.view.resize(rays.view.size() + kViewTerms);
  view_terms(direction.x(), direction.y(), direction.z(), rays.view.data() + rays.view.size() - kViewTerms);
  rays.condition.push_back(condition);
  rays.rest.insert(rays.rest.end(), rest.begin(), rest.end());
  rays.target.insert(rays.target.end(), target.begin(), target.end());
}

DenseNetworkSpec ray_network(int given, int conditions) {
  DenseNetworkSpec spec{{given, 3, kViewTerms, conditions}, {}};
  spec.layers.push_back({{0}, kBakedFeatures, Activation::none});
  for (int l = 0; l < kRayNetworkLayers; ++l)
    spec.layers.push_back({l == 0 ? std::vector<int>{4, 1, 2, 3} : std::vector<int>{4 + l}, kRayNetworkWidth,
                           Activation::relu});
  spec.layers.push_back({{4 + kRayNetworkLayers}, 3, Activation::none});
  return spec;
}

template <class Real>
Real ray_loss(const DenseNetworkSpec& network, const Real* parameters, const BakedRays& rays,
              std::span<const std::uint32_t> chosen, const std::vector<float>& conditions, Real* gradients) {
  DenseNodes<Real> nodes = nodes_of<Real>(network, rays, chosen, conditions);
  network_forward(network, parameters, nodes);
  const DenseMatrix<Real>& remainder = nodes.back();
  DenseNodes<Real> slopes(nodes.size());
  DenseMatrix<Real>& slope = slopes.back();
  slope.resize(3, remainder.cols());
  const Real scale = Real(1) / Real(3 * std::max<std::size_t>(1, chosen.size()));
  Real loss = 0;
  for (std::size_t k = 0; k < chosen.size(); ++k)
    for (int c = 0; c < 3; ++c) {
      const std::size_t at = 3 * std::size_t(chosen[k]) + std::size_t(c);
      const Real light = Real(rays.light[chosen[k]]);
      const Real error = light * (Real(rays.diffuse[at]) + remainder(c, Eigen::Index(k))) +
                         Real(rays.rest[at]) - Real(rays.target[at]);
      loss += scale * error * error;
      slope(c, Eigen::Index(k)) = 2 * scale * error * light;
    }
  if (gradients != nullptr) network_backward(network, parameters, nodes, {}, slopes, gradients);
  return loss;
}
template float ray_loss(const DenseNetworkSpec&, const float*, const BakedRays&,
                        std::span<const std::uint32_t>, const std::vector<float>&, float*);
template double ray_loss(const DenseNetworkSpec&, const double*, const BakedRays&,
                         std::span<const std::uint32_t>, const std::vector<float>&, double*);

namespace {

// Rays of the training pictures, until there are as many as asked for that meet the head.
Result<BakedRays> gather_rays(const Gathering& g, const BakeOptions& options, int features,
                              const Progress& progress, std::stop_token stop) {
  BakedRays rays;
  rays.features = features;
  const std::size_t wanted = std::size_t(options.rays),
                    tries = 8 * (wanted / kRaysAtOnce + 1);  // where hardly any ray meets the head
  RayBatch batch;
  for (std::size_t k = 0; k < tries && rays.count() < wanted; ++k) {
    if (stop.stop_requested()) return cancelled_error();
    choose_rays(g.source, g.volumes, false, options.seed, k, int(std::min(wanted, kRaysAtOnce)), batch);
    gather(g, batch, options.samples, rays);
    progress.report(std::min(1.0, double(rays.count()) / double(wanted)), "rays of the training pictures");
  }
  if (rays.count() == 0)
    return Error{ErrorCode::failed, "No ray of the training pictures meets the head.",
                 "Train the avatar longer, then try again.", "storing an avatar's fields"};
  return rays;
}

// R and its map to features, by Adam.
Result<std::vector<float>> teach(const DenseNetworkSpec& network, const BakedRays& rays,
                                 const std::vector<float>& conditions, const BakeOptions& options,
                                 const Progress& progress, std::stop_token stop) {
  std::vector<float> parameters(parameter_count(network)), gradients(parameters.size(), 0.f);
  initialise(network, options.seed, parameters);
  // At first nothing is added to the diffuse colours.
  std::fill(parameters.end() - 3 * (kRayNetworkWidth + 1), parameters.end(), 0.f);
  ArrayAdamState state;
  AdamOptions adam;
  adam.beta2 = 0.999f, adam.network_epsilon = 1e-8f;
  std::vector<std::uint32_t> chosen(std::min<std::size_t>(std::size_t(options.rays_per_step), rays.count()));
  for (std::uint64_t step = 0; step < options.steps; ++step) {
    if (stop.stop_requested()) return cancelled_error();
    RandomStream random(options.seed, step, 0x62616b65);
    for (std::uint32_t& r : chosen) r = std::uint32_t(random.bits() % rays.count());
    const float loss = ray_loss(network, parameters.data(), rays, chosen, conditions, gradients.data());
    if (!std::isfinite(loss))
      return Error{ErrorCode::failed, fmt::format("The network a ray diverged at step {}.", step),
                   "Try another --seed.", "storing an avatar's fields"};
    const float done = float(step) / float(options.steps);
    adam_step(parameters, gradients, state, options.rate * std::pow(0.1f, done), adam);
    progress.report(double(done), fmt::format("{:.1f} dB on training rays", -10 * std::log10(loss)));
  }
  return parameters;
}

double loss_of_all(const DenseNetworkSpec& network, const std::vector<float>& parameters,
                   const BakedRays& rays, const std::vector<float>& conditions) {
  double sum = 0;
  std::vector<std::uint32_t> chosen;
  for (std::size_t first = 0; first < rays.count(); first += kRaysAtOnce) {
    chosen.resize(std::min(kRaysAtOnce, rays.count() - first));
    std::iota(chosen.begin(), chosen.end(), std::uint32_t(first));
    sum += double(ray_loss<float>(network, parameters.data(), rays, chosen, conditions, nullptr)) *
           double(chosen.size());
  }
  return sum / double(rays.count());
}

constexpr std::size_t kMaxLooks = 64;
std::size_t looks_of(std::size_t poses) { return std::min(poses, kMaxLooks); }

FieldPart without_parameters(const FieldPart& part) {
  return {{part.field.config, {}}, part.cube, part.occupancy, part.core, part.opacity};
}

}  // namespace

Result<BakedAvatar> bake_avatar(const Avatar& avatar, const TrainingSet& set, const BakeOptions& options,
                                const Progress& progress, std::stop_token stop, BakeReport* report) {
  LIKENESS_CHECK(options.views > 0 && options.rays > 0 && options.samples > 0 && options.rays_per_step > 0,
                 "views %d, rays %d, samples %d", options.views, options.rays, options.samples);
  LIKENESS_CHECK(avatar.attributes.empty(), "%zu attributes, of which voxels know none",
                 avatar.attributes.size());
  if (stop.stop_requested()) return cancelled_error();
  if (auto checked = check_training_set(set); !checked) return checked.error();
  const double start = clock_seconds(WorkClock::processor);
  const auto conditions_count = std::size_t(avatar.condition.rows.rows());

  // -- Occupancy
  const auto made = make_rig(avatar, set.model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  const std::vector<AvatarPose> poses = corrected_poses(set, avatar.condition, {});
  const RaySource source =
      make_ray_source(set, poses, rig.shape, avatar.head.cube, avatar.torso ? &avatar.torso->cube : nullptr,
                      rig.warps ? &rig.warp : nullptr, avatar.neck);
  // From training poses spread over the clip.
  const auto spread = [&](FieldSamples& samples) {
    for (std::int32_t& view : samples.view)
      view = std::int32_t(std::size_t(view) * poses.size() / looks_of(poses.size()));
  };
  const OccupancyGrid head_cells =
      moved_occupancy(avatar.head.occupancy, looks_of(poses.size()), [&](FieldSamples& samples) {
        spread(samples);
        warp_samples(source.warps, avatar.head.cube, samples);
        straighten_samples(source.necks, samples);
      });
  if (stop.stop_requested()) return cancelled_error();

  // -- Density and colour
  const int given = avatar.head.field.config.geometry_features;
  const std::vector<float> middle(conditions_count, 0.f);  // psi of the training frames' mean
  progress.report(0, "storing the head");
  const ConditionedField head_field(avatar.head.field, middle, FieldPrecision::exact);
  const SparseVoxels head = bake_voxels(options.head_resolution, 4, head_cells,
                                        source_of(head_field, seen_directions(set, options.views)));
  if (stop.stop_requested()) return cancelled_error();
  BakedAvatar baked;
  if (avatar.torso) {
    progress.report(0.3, "storing the torso");
    const ConditionedField torso_field(avatar.torso->field, {}, FieldPrecision::exact);
    const OccupancyGrid cells =
        moved_occupancy(avatar.torso->occupancy, looks_of(poses.size()), [&](FieldSamples& samples) {
          spread(samples);
          warp_samples(source.torsos, avatar.torso->cube, samples);
        });
    baked.torso = bake_voxels(options.torso_resolution, 4, cells, source_of(torso_field, {Vec3f(0, 0, 1)}));
  }

  // -- Training rays through them
  Gathering gathering{source, avatar, head_field, {&head, baked.torso ? &*baked.torso : nullptr}, {}};
  gathering.volumes = march_volumes(avatar.head, avatar.torso ? &*avatar.torso : nullptr, source.necks);
  gathering.volumes.max_samples = options.samples;
  const auto rays = gather_rays(gathering, options, given, progress.stage(0.4, 0.6, "rays"), stop);
  if (!rays) return rays.error();
  std::vector<float> conditions;
  for (const AvatarPose& pose : poses) {
    const Eigen::VectorXf psi = condition(avatar.condition, pose.articulation);
    conditions.insert(conditions.end(), psi.begin(), psi.end());
  }

  // -- The network that adds to them, and the features it needs
  const DenseNetworkSpec network = ray_network(given, int(conditions_count));
  const auto parameters = teach(network, *rays, conditions, options, progress.stage(0.6, 1, "network"), stop);
  if (!parameters) return parameters.error();
  if (report != nullptr) {
    const std::vector<float> nothing(parameters->size(), 0.f);
    *report = {loss_of_all(network, nothing, *rays, conditions),
               loss_of_all(network, *parameters, *rays, conditions), rays->count(), 0};
  }
  using Map = Eigen::Map<const DenseMatrix<float>>;
  const Map to_features(parameters->data(), kBakedFeatures, given);
  const std::size_t map_size = std::size_t(kBakedFeatures) * std::size_t(given);
  const Eigen::Map<const Eigen::Vector<float, kBakedFeatures>> bias(parameters->data() + map_size);
  baked.head = with_channels(head, kBakedFeatures, [&](const FieldSamples& places, std::span<float> values) {
    std::vector<float> sigma;
    GeometryFeatures geometry;
    evaluate_density(head_field, places.inputs(nullptr, nullptr), sigma, geometry);
    const std::size_t stride = geometry.values.size() / places.count();
    for (std::size_t i = 0; i < places.count(); ++i)
      Eigen::Map<Eigen::Vector<float, kBakedFeatures>>(values.data() + i * kBakedFeatures) =
          to_features * Eigen::Map<const Eigen::VectorXf>(geometry.values.data() + i * stride, given) + bias;
  });
  baked.network = picture_network(int(conditions_count));
  baked.parameters.assign(parameters->begin() + std::ptrdiff_t(map_size) + kBakedFeatures, parameters->end());
  baked.scene = avatar;
  baked.scene.head = without_parameters(avatar.head);
  if (avatar.torso) baked.scene.torso = without_parameters(*avatar.torso);
  if (report != nullptr) report->seconds = clock_seconds(WorkClock::processor) - start;
  progress.report(1);
  return baked;
}

BakedFields::BakedFields(const BakedAvatar& avatar, const Articulation& articulation)
    : avatar_(avatar), condition_(condition(avatar.scene.condition, articulation)) {}

void BakedFields::densities(int part, const FieldSamples& samples, std::vector<float>& sigma) const {
  look_up_densities(part == 0 ? avatar_.head : *avatar_.torso, samples, sigma);
}

void BakedFields::colours(const std::array<WeightedSamples, 2>& parts, std::span<Vec3f> rays) const {
  const WeightedSamples& torso = parts[1];
  float values[1 + kHeadValues];
  for (std::size_t k = 0; k < torso.slots.size(); ++k) {
    const std::size_t slot = torso.slots[k];
    const VoxelPlace place =
        find_place(*avatar_.torso, torso.samples->x[slot], torso.samples->y[slot], torso.samples->z[slot]);
    if (place.node == nullptr) continue;
    interpolate(*avatar_.torso, place, 4, values);
    rays[torso.rays[k]] += torso.weights[k] * Vec3f(values[1], values[2], values[3]);
  }

  // Sums of the head's samples, a column for each ray that meets it.
  const WeightedSamples& head = parts[0];
  std::vector<std::uint32_t> met;
  std::vector<float> light;
  for (std::size_t k = 0; k < head.rays.size(); ++k)
    if (k == 0 || head.rays[k] != head.rays[k - 1]) met.push_back(head.rays[k]);
  if (met.empty()) return;
  DenseNodes<float> nodes(4);
  const auto columns = Eigen::Index(met.size());
  nodes[0].setZero(kBakedFeatures, columns), nodes[1].setZero(3, columns);
  nodes[2].resize(kViewTerms, columns);
  light.assign(met.size(), 0.f);
  Eigen::Index column = -1;
  for (std::size_t k = 0; k < head.slots.size(); ++k) {
    const std::size_t slot = head.slots[k];
    const FieldSamples& s = *head.samples;
    if (k == 0 || head.rays[k] != head.rays[k - 1])
      view_terms(s.dx[slot], s.dy[slot], s.dz[slot], nodes[2].col(++column).data());
    const VoxelPlace place = find_place(avatar_.head, s.x[slot], s.y[slot], s.z[slot]);
    if (place.node == nullptr) continue;
    interpolate(avatar_.head, place, 1 + kHeadValues, values);
    const float weight = head.weights[k];
    light[std::size_t(column)] += weight;
    nodes[1].col(column) += weight * Eigen::Map<const Vec3f>(values + 1);
    nodes[0].col(column) += weight * Eigen::Map<const Eigen::Vector<float, kBakedFeatures>>(values + 4);
  }
  for (Eigen::Index i = 0; i < columns; ++i) {
    const float scale = 1 / std::max(light[std::size_t(i)], 1e-9f);
    nodes[0].col(i) *= scale, nodes[1].col(i) *= scale;
  }
  nodes[3] = condition_.replicate(1, columns);
  network_forward(avatar_.network, avatar_.parameters.data(), nodes);
  for (Eigen::Index i = 0; i < columns; ++i)
    rays[met[std::size_t(i)]] +=
        light[std::size_t(i)] * Vec3f(nodes[1].col(i) + nodes.back().col(i)).cwiseMax(0.f).cwiseMin(1.f);
}

RenderedFrame render_baked(const BakedAvatar& avatar, const Camera& camera, const RenderState& state,
                           const RenderOptions& options) {
  return render_frame(avatar.scene, BakedFields(avatar, state.pose.articulation), camera, state, options);
}

}  // namespace likeness
