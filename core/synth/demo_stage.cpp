// One ray per sample to the person, and where it misses to the room; the samples of a pixel lie on a fixed
// pattern, so that static things do not flicker.
#include "core/synth/demo_stage.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/synth/noise.h"
#include "core/synth/person.h"
#include "core/synth/room.h"

namespace likeness {
namespace {

constexpr float kBrightest = 4;  // radiance of one sample; keeps single sparkles from aliasing
constexpr int kPlateSamples = 16;

// Low-discrepancy positions in the pixel (additive recurrence of the plastic number).
Vec2d sample_position(int sample) {
  const double x = 0.5 + 0.7548776662466927 * (sample + 1), y = 0.5 + 0.5698402909980532 * (sample + 1);
  return {x - std::floor(x), y - std::floor(y)};
}

struct View {
  Vec3f origin;
  Mat3d world_from_cam;
  Intrinsics intrinsics;

  explicit View(const Camera& camera)
      : origin(inverse(camera.cam_from_world).translation().cast<float>()),
        world_from_cam(camera.cam_from_world.linear().transpose()),
        intrinsics(camera.intrinsics) {}
  Vec3f ray(const Vec2d& pixel) const {
    return (world_from_cam * ray_direction(intrinsics, pixel)).normalized().cast<float>();
  }
};

bool same_view(const Camera& a, const Camera& b) {
  return a.cam_from_world.isApprox(b.cam_from_world, 1e-12) && a.intrinsics.fx == b.intrinsics.fx;
}

float pixel_on_face(const DemoOptions& options) {
  return float(0.57 / (1.35 * std::min(options.width, options.height)));
}

}  // namespace

struct DemoStage::Impl {
  HeadModel model;
  DemoOptions options;
  PersonShape person_shape;
  HeadShape shape;
  PersonalPlay play;
  LightRig rig;
  Room room;
  Person person;
  std::optional<Camera> plate_camera;  // whose picture of the room `plate` is
  std::vector<Vec3f> plate;            // linear, (height, width)

  Impl(HeadModel m, const DemoOptions& o)
      : model(std::move(m)),
        options(o),
        person_shape(make_personal_shape(model, demo_person(o.person), o.person, o.seed)),
        shape(shape_head(model, person_shape)),
        play(model, shape, demo_person(o.person)),
        rig(make_light_rig(o.light)),
        room(furnish_room(std::uint32_t(o.seed + 61 * o.person)), rig),
        person(model, shape, play, rig,
               {pixel_on_face(o), hash_u32(std::uint32_t(o.seed) + 1 + 19 * std::uint32_t(o.person)),
                demo_person(o.person)}) {}

  bool rest_on(const Camera& camera, std::stop_token stop);
};

// Makes the plate of a camera; false when stopped.
bool DemoStage::Impl::rest_on(const Camera& camera, std::stop_token stop) {
  if (plate_camera && same_view(*plate_camera, camera)) return true;
  plate.assign(std::size_t(options.width) * options.height, Vec3f::Zero());
  const View view(camera);
  parallel_for(std::size_t(options.height), [&](std::size_t y) {
    for (int x = 0; x < options.width && !stop.stop_requested(); ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int k = 0; k < kPlateSamples; ++k) {
        const Vec3f ray = view.ray(Vec2d(x, double(y)) + sample_position(k));
        sum += room.look(view.origin, ray).cwiseMin(kBrightest);
      }
      plate[y * std::size_t(options.width) + x] = sum / float(kPlateSamples);
    }
  });
  if (stop.stop_requested()) return false;
  plate_camera = camera;
  return true;
}

DemoStage::DemoStage(HeadModel model, const DemoOptions& options)
    : impl_(std::make_unique<Impl>(std::move(model), options)) {}
DemoStage::~DemoStage() = default;
const HeadModel& DemoStage::model() const { return impl_->model; }
const HeadShape& DemoStage::shape() const { return impl_->shape; }
const PersonShape& DemoStage::person_shape() const { return impl_->person_shape; }
const PersonalPlay& DemoStage::play() const { return impl_->play; }
std::vector<Vec3f> DemoStage::posed(const Shot& shot) const {
  return impl_->play.pose(shot.articulation, shot.habit);
}
Shot DemoStage::shot(int frame) const { return perform(impl_->model, impl_->shape, impl_->options, frame); }

DemoFrame DemoStage::film(int frame, std::stop_token stop) {
  Impl& me = *impl_;
  const DemoOptions& o = me.options;
  DemoFrame result{Image8(o.width, o.height, 3), Image8(o.width, o.height, 1), true};
  const Shot shot = this->shot(frame);
  me.person.pose(shot, stop);
  const bool resting = frame >= moving_frames(o);
  if (stop.stop_requested() || (resting && !me.rest_on(shot.camera, stop))) {
    result.complete = false;
    return result;
  }
  const View view(shot.camera);
  const int samples = std::max(1, o.samples_per_pixel);
  parallel_for(std::size_t(o.height), [&](std::size_t y) {
    for (int x = 0; x < o.width && !stop.stop_requested(); ++x) {
      Vec3f sum = Vec3f::Zero();
      int covered = 0;
      for (int k = 0; k < samples; ++k) {
        const Vec3f ray = view.ray(Vec2d(x, double(y)) + sample_position(k));
        const auto person = me.person.look(view.origin, ray);
        covered += person ? 1 : 0;
        if (person)
          sum += person->cwiseMin(kBrightest);
        else
          sum += resting ? me.plate[y * std::size_t(o.width) + x]
                         : me.room.look(view.origin, ray).cwiseMin(kBrightest);
      }
      const Vec3f colour = develop(sum / float(samples));
      for (int c = 0; c < 3; ++c)
        result.rgb.at(x, int(y))[c] = std::uint8_t(std::lround(255 * std::clamp(colour[c], 0.0f, 1.0f)));
      *result.mask.at(x, int(y)) = std::uint8_t((255 * covered + samples / 2) / samples);
    }
  });
  result.complete = !stop.stop_requested();
  return result;
}

}  // namespace likeness
