// Timing pictures on a device: see device_frames.h.
#include "core/lab/bench/device_frames.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/rigid.h"
#include "core/lab/bench/standard_field.h"
#include "core/render/rays.h"

namespace likeness {
namespace {

constexpr int kCells = 96;
constexpr float kSpeck = 0.02f;  // of a channel: pixels off by more are counted

// inside(p): at most 1 within the shape; p has coordinates from -1 to 1.
template <class Inside>
void fill_grid(FieldPart& part, const Inside& inside) {
  part.occupancy = make_occupancy(kCells, false);
  part.opacity.assign(std::size_t(kCells) * kCells * kCells, 0);
  for (int z = 0; z < kCells; ++z)
    for (int y = 0; y < kCells; ++y)
      for (int x = 0; x < kCells; ++x) {
        const Vec3f p = (Vec3f(float(x), float(y), float(z)).array() + 0.5f) * (2.f / kCells) - 1;
        const float depth = inside(p);
        if (depth > 1) continue;
        set_occupied(part.occupancy, x, y, z, true);
        // Hair and skin are a few cells thick.
        part.opacity[(std::size_t(z) * kCells + std::size_t(y)) * kCells + std::size_t(x)] =
            depth > 0.9f ? 40 : 200;
      }
}

// The standard field without a condition, as a torso's is.
Field torso_field_of(std::uint32_t seed) {
  FieldConfig config = standard_field_config();
  config.condition_count = config.latent_count = 0;
  config.ambient_grid = FieldConfig().ambient_grid;
  Field field = make_field(config, seed);
  std::mt19937 random(seed);
  for (const ParameterBlock& block : parameter_layout(config))
    for (std::size_t i = 0; block.table && i < block.count; ++i)
      field.parameters[block.offset + i] = float(random() >> 8) * 0x1p-23f - 1;
  return field;
}

// Number of rays that have samples.
std::size_t rays_met(const Avatar& avatar, const Camera& camera, const RenderState& state) {
  const MarchVolumes volumes = march_volumes(avatar.head, avatar.torso ? &*avatar.torso : nullptr);
  const UnitFromCamera head =
      unit_from_camera(avatar.head.cube, camera.cam_from_world, state.pose.world_from_head);
  const UnitFromCamera torso =
      unit_from_camera(avatar.torso->cube, camera.cam_from_world, state.pose.world_from_torso);
  std::size_t met = 0;
  for (const Vec3f& direction : pixel_directions(camera.intrinsics)) {
    RayRequest ray;
    ray.fields = {field_ray(head, direction), field_ray(torso, direction)};
    met += meets_volume(ray, volumes);
  }
  return met;
}

Result<DeviceFrameSpeed> measure_quality(std::shared_ptr<Device> device, const Avatar& avatar,
                                         RenderQuality quality, const DeviceCeilings& ceilings,
                                         const DeviceBenchOptions& options) {
  const RenderOptions asked = render_options(quality);
  const Camera camera = typical_camera(avatar);
  const auto made = device_backend(device)->make_renderer(avatar);
  if (!made) return made.error();
  std::vector<double> seconds;
  Result<RenderedFrame> frame = Error{};
  for (int k = 0; k <= options.rounds; ++k) {
    RenderState state = typical_state(avatar);
    state.pose.world_from_head.rotate(rotation_about(Vec3d::UnitY(), 0.01 * k));
    if (auto done = device->mark(0); !done) return done.error();
    frame = (*made)->render(camera, state, asked);
    if (!frame) return frame.error();
    if (auto done = device->mark(1); !done) return done.error();
    if (auto done = device->wait(); !done) return done.error();
    const auto taken = device->between(0, 1);
    if (!taken) return taken.error();
    if (k > 0) seconds.push_back(*taken);  // the first one allocates
  }
  std::nth_element(seconds.begin(), seconds.begin() + std::ptrdiff_t(seconds.size() / 2), seconds.end());
  RenderState last = typical_state(avatar);
  last.pose.world_from_head.rotate(rotation_about(Vec3d::UnitY(), 0.01 * options.rounds));
  RenderOptions exact = device_options(asked);
  exact.precision = FieldPrecision::exact;
  const Image truth = render_frame(avatar, camera, last, exact).rgba;

  DeviceFrameSpeed speed;
  speed.quality = kRenderQualities[int(quality)];
  speed.size = avatar.size;
  speed.seconds = seconds[seconds.size() / 2], speed.frames_s = 1 / speed.seconds;
  speed.samples = frame->samples_per_ray * double(rays_met(avatar, camera, last));
  // As if all samples were the torso's, which are cheaper.
  const DeviceWork work = inference_work(avatar.torso->field.config, std::size_t(speed.samples));
  speed.floor_seconds = floor_seconds(work, ceilings);
  speed.fraction_of_floor = speed.floor_seconds / speed.seconds;
  for (std::size_t i = 0; i < truth.data.size(); i += 4) {
    float worst = 0;
    for (std::size_t c = i; c < i + 4; ++c)
      worst = std::max(worst, std::abs(frame->rgba.data[c] - truth.data[c]));
    speed.mean_error += double(worst), speed.share_over += worst > kSpeck;
  }
  speed.mean_error /= double(truth.pixels()), speed.share_over /= double(truth.pixels());
  return speed;
}

}  // namespace

Avatar standard_avatar(std::uint32_t seed, int size) {
  Avatar avatar;
  avatar.head.field = standard_field(seed);
  avatar.head.cube = {Vec3f::Constant(-0.2f), 0.4f};
  fill_grid(avatar.head,
            [](const Vec3f& p) { return Vec3f(p.x() / 0.55f, p.y() / 0.75f, p.z() / 0.65f).norm(); });
  avatar.torso.emplace();
  avatar.torso->field = torso_field_of(seed + 1);
  avatar.torso->cube = {Vec3f(-0.35f, -0.75f, -0.35f), 0.7f};
  fill_grid(*avatar.torso,
            [](const Vec3f& p) { return Vec3f(p.x() / 0.9f, (p.y() + 0.4f) / 0.9f, p.z() / 0.4f).norm(); });
  const int conditions = avatar.head.field.config.condition_count;
  avatar.condition.mean = Eigen::VectorXf::Zero(9);
  avatar.condition.rows = Eigen::MatrixXf::Identity(conditions, 9);
  avatar.condition.low = Eigen::VectorXf::Constant(conditions, -1);
  avatar.condition.high = Eigen::VectorXf::Constant(conditions, 1);
  avatar.world_from_head.translate(Vec3d(0, 0, 0.9)).rotate(rotation_about(Vec3d::UnitX(), 3.1));
  avatar.world_from_torso = avatar.world_from_head;
  avatar.intrinsics = {size, size, 1.3 * size, 1.3 * size, 0.5 * size, 0.4 * size, 0, 0, 0, 0};
  avatar.size = size;
  return avatar;
}

Result<std::vector<DeviceFrameSpeed>> measure_frames(std::shared_ptr<Device> device,
                                                     const DeviceCeilings& ceilings,
                                                     const DeviceBenchOptions& options,
                                                     std::stop_token stop) {
  const Avatar avatar = standard_avatar(options.seed, options.frame_size);
  std::vector<DeviceFrameSpeed> speeds;
  for (const RenderQuality quality : {RenderQuality::final, RenderQuality::preview}) {
    if (stop.stop_requested()) return cancelled_error();
    auto speed = measure_quality(device, avatar, quality, ceilings, options);
    if (!speed) return speed.error();
    speeds.push_back(*speed);
  }
  return speeds;
}

}  // namespace likeness
