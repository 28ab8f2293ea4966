// Timing a training's steps: see device_step.h.
#include "core/lab/bench/device_step.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <random>
#include <vector>

#include "core/base/rigid.h"
#include "core/lab/bench/device_frames.h"
#include "core/train/cast_rays.h"
#include "core/train/training_step.h"

namespace likeness {
namespace {

using StepClock = std::chrono::steady_clock;

TrainedField trained(const FieldPart& part, int look_every) {
  TrainedField field;
  field.part = part;
  field.volume.cube = part.cube;
  field.volume.allowed = part.occupancy;
  field.volume.kept = make_occupancy(part.occupancy.resolution, false);
  const OccupancyState all = make_occupancy_state(field.volume);
  for (std::size_t i = 0; i < all.cells.size(); i += std::size_t(look_every)) {
    field.learnt.cells.push_back(all.cells[i]);
    field.learnt.density.push_back(all.density[i]);
  }
  field.adam = make_adam_state(field.part.field);
  return field;
}

// A training of the standard avatar.
struct StandardTraining {
  TrainingSet set;
  TrainingState state;
  RaySource source;
  StepOptions options;

  explicit StandardTraining(const DeviceBenchOptions& bench) {
    const Avatar avatar = standard_avatar(bench.seed, bench.step_picture);
    std::mt19937 random(bench.seed);
    options.rays = bench.step_rays, options.seed = bench.seed;
    state.head = trained(avatar.head, bench.look_every),
    state.torso = trained(*avatar.torso, bench.look_every);
    const auto conditions = std::size_t(avatar.head.field.config.condition_count),
               views = std::size_t(bench.step_views);
    state.codes.assign(2 * views * std::size_t(avatar.head.field.config.latent_count), 0.f);
    for (std::size_t i = 0; i < 2 * views * conditions; ++i)
      state.conditions.push_back(float(random() >> 8) * 0x1p-23f - 1);
    state.deviations.assign(conditions, 0.5f);
    state.schedule.total_steps = 1000000;
    set.size = bench.step_picture;
    const std::vector<std::uint32_t> pixels = [&] {
      std::vector<std::uint32_t> all(std::size_t(set.size) * std::size_t(set.size));
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = std::uint32_t(i);
      return all;
    }();
    const std::vector<float> seen =
        render_pixels(avatar, typical_camera(avatar), typical_state(avatar), pixels,
                      device_options(render_options(RenderQuality::preview)));
    for (std::size_t v = 0; v < views; ++v) add_view(avatar, seen, v, random);
    source.set = &set;
  }
  StandardTraining(const StandardTraining&) = delete;

 private:
  void add_view(const Avatar& avatar, const std::vector<float>& seen, std::size_t v, std::mt19937& random) {
    TrainingView view;
    view.camera = typical_camera(avatar);
    view.rgb = Image8(set.size, set.size, 3);
    for (std::uint8_t& value : view.rgb.data) value = std::uint8_t(random());
    Image8 alpha(set.size, set.size, 1);
    for (std::size_t i = 0; i < alpha.data.size(); ++i)
      alpha.data[i] = std::uint8_t(255 * std::clamp(seen[4 * i + 3], 0.f, 1.f));
    view.alpha = TiledMask(alpha);
    view.has_plate = false;
    set.views.push_back(std::move(view));
    Pose head = avatar.world_from_head;
    head.rotate(rotation_about(Vec3d::UnitY(), 0.02 * double(v % 40) - 0.4));
    source.views.emplace_back();
    RaySource::View& own = source.views.back();
    const Pose& cam = typical_camera(avatar).cam_from_world;
    own.maps = {unit_from_camera(avatar.head.cube, cam, head),
                unit_from_camera(avatar.torso->cube, cam, avatar.world_from_torso)};
    own.face_x0 = set.size / 3, own.face_x1 = 2 * set.size / 3;
    own.face_y0 = set.size / 6, own.face_y1 = set.size / 2;
  }
};

double median(std::vector<double>& seconds) {
  const auto middle = seconds.begin() + std::ptrdiff_t(seconds.size() / 2);
  std::nth_element(seconds.begin(), middle, seconds.end());
  return *middle;
}

}  // namespace

Result<DeviceStepSpeed> measure_step(std::shared_ptr<Device> device, const DeviceCeilings& ceilings,
                                     const DeviceBenchOptions& options, std::stop_token stop) {
  StandardTraining training(options);
  const auto backend = device_backend(device);
  auto learner = make_learner(*backend, training.state, training.options, training.set);
  if (!learner) return learner.error();
  const CasterChoice chosen = make_ray_caster(**learner, training.state, training.source, training.options);
  if (!chosen.caster)
    return Error{ErrorCode::failed, chosen.why_not, "Close what else uses the GPU.", "CUDA, training"};
  DeviceStepSpeed speed;
  speed.rays = std::size_t(options.step_rays);
  double samples = 0;
  // Median wall time, which is what a training waits for, after one step that records.
  const auto timed = [&](RayCaster* caster) -> Result<double> {
    std::vector<double> seconds;
    samples = 0;
    for (int k = 0; k <= options.rounds; ++k) {
      if (stop.stop_requested()) return cancelled_error();
      const auto start = StepClock::now();
      const auto step = training_step(training.state, **learner, training.source, training.options, caster);
      if (!step) return step.error();
      if (k == 0) continue;
      seconds.push_back(std::chrono::duration<double>(StepClock::now() - start).count());
      samples += double(step->samples) / options.rounds;
    }
    return median(seconds);
  };
  training.options.use_occupancy = false;  // updates of the cells are timed separately
  const auto with_processor = timed(nullptr);
  if (!with_processor) return with_processor.error();
  const auto seconds = timed(chosen.caster.get());
  if (!seconds) return seconds.error();
  speed.seconds = *seconds, speed.rays_by_processor_seconds = *with_processor, speed.samples = samples;
  const DeviceWork work = training_work(training.state.torso->part.field.config, std::size_t(samples));
  speed.floor_seconds = floor_seconds(work, ceilings);
  speed.fraction_of_floor = speed.floor_seconds / speed.seconds;
  std::vector<double> looks;
  for (int k = 0; k < options.rounds; ++k) {
    if (auto done = device->mark(0); !done) return done.error();
    if (auto done = chosen.caster->refresh(training.state.step + std::uint64_t(k)); !done)
      return done.error();
    if (auto done = device->mark(1); !done) return done.error();
    if (auto done = device->wait(); !done) return done.error();
    const auto taken = device->between(0, 1);
    if (!taken) return taken.error();
    looks.push_back(*taken);
  }
  speed.look_seconds = median(looks);
  return speed;
}

}  // namespace likeness
