// Rays beside the person -> samples in the room's cube -> field -> compositing over a random colour, so that
// only an opaque room explains the pictures -> Adam.
#include "core/train/room.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/field/adam.h"
#include "core/field/evaluate.h"
#include "core/field/train_fields.h"
#include "core/image/metrics.h"
#include "core/render/composite.h"
#include "core/render/rays.h"
#include "core/train/occupancy_refresh.h"
#include "core/train/random_stream.h"
#include "core/train/schedule.h"

namespace likeness {
namespace {

constexpr std::size_t kMinPoints = 50;
constexpr double kOutliers = 0.02, kMargin = 0.1;  // of the points at either end; of their extent
constexpr float kUsualReach = 3.0f;                // m about the head, without points
constexpr float kLargestSide = 30.0f;              // m
constexpr int kRoomCells = 96, kMaxSamples = 24, kBackgroundTries = 12;
constexpr int kBesidePerson = 2;          // px beside the person whose colours may be mixed
constexpr double kFreeWay = 0.6;          // of the way from a camera to the head, which is assumed free
constexpr float kPersonsPlace = 0.3f;     // m about the head's origin and the body below it
constexpr float kBody = 0.6f;             // m
constexpr float kRoomInitialDensity = 4;  // per cube side
constexpr float kRoomTableRate = 1e-2f, kRoomNetworkRate = 3e-3f;
constexpr std::uint64_t kRoomFirstRefresh = 64, kRoomRefreshEvery = 32;

FieldConfig room_config() {
  FieldConfig config;
  config.initial_density = kRoomInitialDensity;
  config.position = {3, 8, 4, 17, 16, 2048};
  config.density_width = 32, config.density_layers = 1;
  config.colour_width = 32, config.colour_layers = 1;
  config.view_direction = false;
  return config;
}

// Cells that may hold something: neither between a camera and the person, nor where the person is, whose
// edges are as still as the room while the camera goes round.
OccupancyGrid free_cells(std::span<const TrainingView> views, const FieldCube& cube) {
  std::vector<Vec3f> eyes, heads, downs;
  for (std::size_t i = 0; i < views.size(); i += std::max<std::size_t>(1, views.size() / 32)) {
    eyes.push_back(inverse(views[i].camera.cam_from_world).translation().cast<float>());
    heads.push_back(views[i].pose.world_from_head.translation().cast<float>());
    downs.push_back(-views[i].pose.world_from_torso.linear().col(1).cast<float>());
  }
  OccupancyGrid grid = make_occupancy(kRoomCells, false);
  for (int z = 0; z < kRoomCells; ++z)
    for (int y = 0; y < kRoomCells; ++y)
      for (int x = 0; x < kRoomCells; ++x) {
        const Vec3f at = cube.origin + (Vec3f(float(x), float(y), float(z)) + Vec3f::Constant(0.5f)) *
                                           (cube.side / float(kRoomCells));
        bool free = true;
        for (std::size_t i = 0; i < eyes.size() && free; ++i) {
          const Vec3f from_head = at - heads[i];
          const Vec3f beside = from_head - std::clamp(from_head.dot(downs[i]), 0.f, kBody) * downs[i];
          free = (at - eyes[i]).norm() > float(kFreeWay) * (heads[i] - eyes[i]).norm() &&
                 beside.norm() > kPersonsPlace;
        }
        if (free) set_occupied(grid, x, y, z, true);
      }
  return grid;
}

// Whether a pixel and its neighbours hold nothing of the person.
bool is_background(const TiledMask& alpha, int x, int y) {
  for (const auto& [dx, dy] : {std::array{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    const int u = std::clamp(x + dx * kBesidePerson, 0, alpha.width - 1),
              v = std::clamp(y + dy * kBesidePerson, 0, alpha.height - 1);
    if (alpha.at(u, v) > 2) return false;
  }
  return true;
}

bool shows_background(const TrainingView& view) {
  constexpr int kStep = 4;  // px
  for (int y = 0; y < view.alpha.height; y += kStep)
    for (int x = 0; x < view.alpha.width; x += kStep)
      if (is_background(view.alpha, x, y)) return true;
  return false;
}

struct RoomRays {
  std::vector<RayRequest> requests;
  std::vector<Vec3f> target, behind;  // sRGB-encoded
  std::vector<float> weight;          // 0: no background pixel was found
};

// Views in turn, any pixel beside the person. Random numbers depend only on seed, step and the ray's index.
void choose_room_rays(std::span<const TrainingView> views, const std::vector<UnitFromCamera>& maps,
                      std::uint64_t seed, std::uint64_t step, int count, RoomRays& rays) {
  rays.requests.resize(std::size_t(count)), rays.weight.resize(std::size_t(count));
  rays.target.resize(std::size_t(count)), rays.behind.resize(std::size_t(count));
  parallel_ranges(std::size_t(count), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      RandomStream random(seed ^ 0x400full, step, i);
      const auto v = std::min(views.size() - 1,
                              std::size_t((double(i) + random.uniform()) * double(views.size()) / count));
      const TrainingView& view = views[v];
      int x = 0, y = 0;
      rays.weight[i] = 0;
      for (int attempt = 0; attempt < kBackgroundTries && rays.weight[i] == 0; ++attempt) {
        x = int(random.below(std::uint32_t(view.rgb.width)));
        y = int(random.below(std::uint32_t(view.rgb.height)));
        rays.weight[i] = is_background(view.alpha, x, y) ? 1.f : 0.f;
      }
      const Vec3f direction =
          ray_direction(view.camera.intrinsics, Vec2d(x + 0.5, y + 0.5)).normalized().cast<float>();
      rays.requests[i].fields[0] = field_ray(maps[v], direction);
      rays.requests[i].view = 0;
      rays.requests[i].jitter = random.bits() | 1;
      const std::uint8_t* rgb = view.rgb.at(x, y);
      rays.target[i] = Vec3f(float(rgb[0]), float(rgb[1]), float(rgb[2])) / 255.f;
      const float blue = random.uniform(), green = random.uniform(), red = random.uniform();
      rays.behind[i] = Vec3f(red, green, blue);
    }
  });
}

// The room in training, and what a step needs of memory.
struct RoomTraining {
  Volume volume;
  FieldPart part;
  AdamState adam;
  OccupancyState learnt;
  std::shared_ptr<FieldTape> tape = make_tape();
  FieldGradients gradients;
  FieldOutputs outputs;
  std::vector<float> d_sigma, d_red, d_green, d_blue;
  RoomRays rays;
  SampleBatch samples;
};

// Gradients of the field; returns the mean squared error over rays and channels.
double train_on_rays(RoomTraining& room, const FieldInputs& inputs) {
  constexpr std::size_t kBlockRays = 16;  // evaluated and backpropagated together
  const std::size_t rays = room.rays.requests.size(), count = inputs.count;
  for (auto* slopes : {&room.d_sigma, &room.d_red, &room.d_green, &room.d_blue}) slopes->resize(count);
  std::vector<double> errors((rays + kBlockRays - 1) / kBlockRays), weights(errors.size());
  const auto composite_block = [&](std::size_t block) {
    const std::size_t begin = block * kBlockRays, end = std::min(rays, begin + kBlockRays);
    std::array<float, kMaxSamples> sigma, d_sigma;
    std::array<float, 3 * kMaxSamples> colour, d_colour;
    for (std::size_t r = begin; r < end; ++r) {
      const std::uint32_t first = room.samples.begin[r];
      const int n = int(room.samples.begin[r + 1] - first);
      const float* dt = room.samples.dt.data() + first;
      for (int i = 0; i < n; ++i) {
        const std::size_t at = room.samples.slot[first + std::uint32_t(i)], k = std::size_t(i);
        sigma[k] = room.outputs.sigma[at];
        colour[3 * k] = room.outputs.red[at], colour[3 * k + 1] = room.outputs.green[at];
        colour[3 * k + 2] = room.outputs.blue[at];
      }
      const Composited<float> seen = composite_ray(n, sigma.data(), dt, colour.data());
      float d_pixel[3];
      for (int c = 0; c < 3; ++c) {
        const float difference =
            seen.colour[c] + seen.transmittance * room.rays.behind[r][c] - room.rays.target[r][c];
        errors[block] += double(room.rays.weight[r]) * difference * difference;
        d_pixel[c] = 2 * room.rays.weight[r] * difference / (3 * float(rays));
      }
      weights[block] += room.rays.weight[r];
      composite_ray_backward(n, sigma.data(), dt, colour.data(), room.rays.behind[r].data(), seen, d_pixel,
                             0.f, d_sigma.data(), d_colour.data());
      for (int i = 0; i < n; ++i) {
        const std::size_t at = room.samples.slot[first + std::uint32_t(i)], k = std::size_t(i);
        room.d_sigma[at] = d_sigma[k];
        room.d_red[at] = d_colour[3 * k], room.d_green[at] = d_colour[3 * k + 1];
        room.d_blue[at] = d_colour[3 * k + 2];
      }
    }
  };
  std::vector<std::size_t> ends;
  for (std::size_t block = 0; block < errors.size(); ++block)
    ends.push_back(room.samples.begin[std::min(rays, (block + 1) * kBlockRays)]);
  const FieldOutputGradients slopes{room.d_sigma.data(), room.d_red.data(), room.d_green.data(),
                                    room.d_blue.data()};
  const FieldStep step{room.part.field, inputs, ends, room.outputs, slopes, *room.tape, room.gradients};
  train_fields({&step, 1}, composite_block);
  double error = 0, weight = 0;
  for (std::size_t k = 0; k < errors.size(); ++k) error += errors[k], weight += weights[k];
  return weight > 0 ? error / (3 * weight) : 0;
}

double room_step(RoomTraining& room, std::uint64_t step, double rate) {
  MarchVolumes volumes = march_volumes(room.part, nullptr);
  volumes.max_samples = kMaxSamples;
  sample_rays(room.rays.requests, volumes, room.samples);
  const FieldSamples& samples = room.samples.fields[0];
  if (samples.count() == 0) return 0;
  const FieldInputs inputs = samples.inputs(nullptr, nullptr);
  const double loss = train_on_rays(room, inputs);
  AdamOptions adam;
  adam.table_rate = float(kRoomTableRate * rate), adam.network_rate = float(kRoomNetworkRate * rate);
  adam_step(room.part.field, room.gradients, room.adam, adam);
  if (step + 1 >= kRoomFirstRefresh && (step + 1) % kRoomRefreshEvery == 0) {
    const auto densities = [&](const FieldInputs& places, std::vector<float>& sigma) -> Result<void> {
      evaluate_density(room.part.field, places, sigma);
      return {};
    };
    const auto refreshed = refresh_occupancy(
        room.learnt, room.part.occupancy.resolution, nullptr, 1, [](FieldSamples&) {}, densities, 0, step);
    LIKENESS_CHECK(refreshed.ok(), "the processor's densities failed at step %d", int(step));
    room.part.occupancy = occupancy_bits(room.learnt, room.volume);
    room.part.opacity = cell_opacities(room.learnt, room.volume);
  }
  return loss;
}

RoomTraining start_room(std::span<const TrainingView> views, const FieldCube& cube, std::uint64_t seed) {
  RoomTraining room;
  room.volume.cube = cube;
  room.volume.allowed = free_cells(views, cube);
  room.volume.kept = make_occupancy(kRoomCells, false);
  room.part.field = make_field(room_config(), std::uint32_t(2 * seed + 77));
  room.part.cube = cube;
  room.part.occupancy = room.volume.allowed;
  room.adam = make_adam_state(room.part.field);
  room.learnt = make_occupancy_state(room.volume);
  room.gradients = make_gradients(room.part.field, 1);
  return room;
}

}  // namespace

FieldCube room_cube(std::span<const TrainingView> views, std::span<const Vec3f> points) {
  const Vec3f head = views.front().pose.world_from_head.translation().cast<float>();
  Vec3f low, high;
  if (points.size() >= kMinPoints) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<float> along;
      for (const Vec3f& point : points) along.push_back(point[axis]);
      low[axis] = quantile(along, kOutliers), high[axis] = quantile(along, 1 - kOutliers);
      const float margin = float(kMargin) * (high[axis] - low[axis]);
      low[axis] -= margin, high[axis] += margin;
    }
  } else {
    low = head - Vec3f::Constant(kUsualReach), high = head + Vec3f::Constant(kUsualReach);
  }
  const float side = std::clamp((high - low).maxCoeff(), 0.1f, kLargestSide);
  Vec3f centre = 0.5f * (low + high);
  // For a landscape, the part around the person: everything farther is painted on the sides.
  const Vec3f reach = Vec3f::Constant(0.5f * kLargestSide - kUsualReach);
  if (side == kLargestSide) centre = centre.cwiseMax(head - reach).cwiseMin(head + reach);
  return {centre - Vec3f::Constant(0.5f * side), side};
}

Result<FieldPart> train_room(std::span<const TrainingView> views, const FieldCube& cube,
                             const RoomOptions& options, const Progress& progress, std::stop_token stop) {
  if (views.empty() || std::ranges::any_of(views, [](const TrainingView& v) { return v.alpha.empty(); }))
    return Error{ErrorCode::bad_input, "There is no picture with a matte to learn the room from.",
                 "Run the matting again.", "training"};
  if (std::ranges::none_of(views, shows_background))
    return Error{ErrorCode::not_found, "The person fills every picture: none of the room is seen.",
                 "Film from farther away.", "training"};
  std::vector<UnitFromCamera> maps;
  for (const TrainingView& view : views)
    maps.push_back(unit_from_camera(cube, view.camera.cam_from_world, Pose::Identity()));
  RoomTraining room = start_room(views, cube, options.seed);
  Schedule schedule;
  schedule.total_steps = options.steps;
  double mean_loss = 0;
  for (std::uint64_t step = 0; step < options.steps; ++step) {
    if (stop.stop_requested()) return cancelled_error();
    choose_room_rays(views, maps, options.seed, step, options.rays_per_step, room.rays);
    const double loss = room_step(room, step, learning_rate(step, schedule));
    if (!std::isfinite(loss))
      return Error{ErrorCode::failed, fmt::format("The room's training diverged at step {}.", step),
                   "Try another --seed.", "training"};
    mean_loss = step == 0 ? loss : 0.95 * mean_loss + 0.05 * loss;
    progress.report(double(step + 1) / double(options.steps),
                    fmt::format("room, step {}, training PSNR {:.1f} dB", step + 1,
                                mean_loss > 0 ? psnr_from_mse(mean_loss) : 0));
  }
  return std::move(room.part);
}

}  // namespace likeness
