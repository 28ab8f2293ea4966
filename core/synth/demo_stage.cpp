// One ray per sample to the person, and where it misses to the room; the samples of a pixel lie on a fixed
// pattern, so that static things do not flicker.
#include "core/synth/demo_stage.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/synth/demo_camera.h"
#include "core/synth/drift.h"
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
  const Intrinsics &k = a.intrinsics, &l = b.intrinsics;
  return a.cam_from_world.isApprox(b.cam_from_world, 1e-12) && k.fx == l.fx && k.cx == l.cx && k.cy == l.cy;
}

float pixel_on_face(const DemoOptions& options) {
  return float(0.57 / (1.35 * std::min(options.width, options.height)));
}

DemoPerson look_of(const DemoOptions& options) {
  DemoPerson look = demo_person(options.person);
  if (options.hair == DemoHair::loose) look.hair.cut = HairCut::loose, look.hair.curl = 0;
  return look;
}

std::vector<RoomPatch> room_of(const DemoOptions& options) {
  switch (options.wall) {
    case DemoWall::plain:
      return bare_wall(false);
    case DemoWall::textured:
      return bare_wall(true);
    case DemoWall::furnished:
      break;
  }
  return furnish_room(std::uint32_t(options.seed + 61 * options.person));
}

void put(const Vec3f& radiance, std::uint8_t* pixel) {
  const Vec3f colour = develop(radiance);
  for (int c = 0; c < 3; ++c) pixel[c] = std::uint8_t(std::lround(255 * std::clamp(colour[c], 0.0f, 1.0f)));
}

// The shutter is open for half of the time from frame to frame.
constexpr double kShutter = 0.5;
constexpr int kMostExposures = 6;

}  // namespace

struct DemoStage::Impl {
  HeadModel model;
  DemoOptions options;
  PersonShape person_shape;
  HeadShape shape;
  PersonalPlay play;
  LightRig rig;
  std::vector<DemoShot> shots;
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
        shots(demo_shots(o)),
        room(room_of(o), rig),
        person(model, shape, play, rig,
               {pixel_on_face(o), hash_u32(std::uint32_t(o.seed) + 1 + 19 * std::uint32_t(o.person)),
                look_of(o), o.still_torso}) {}

  Shot shot(int frame, double later_s = 0) const { return perform(model, shape, options, frame, later_s); }
  bool rests(int frame) const {
    return camera_rests(uncut(options, shots), frame + shot_of(shots, frame).dropped);
  }
  std::vector<Vec3f> room_seen(const Camera& camera, int samples, std::stop_token stop) const;
  bool rest_on(const Camera& camera, std::stop_token stop);
  DemoFrame film_at_once(const Shot& shot, bool resting, std::stop_token stop);
  DemoFrame film_in_layers(int frame, std::stop_token stop);
  std::vector<double> exposures(int frame) const;
  bool expose(int frame, double later_s, float share, FilmLayers& sum, std::stop_token stop);
};

// Linear, (height, width). Not whole when stopped.
std::vector<Vec3f> DemoStage::Impl::room_seen(const Camera& camera, int samples, std::stop_token stop) const {
  std::vector<Vec3f> seen(std::size_t(options.width) * options.height, Vec3f::Zero());
  const View view(camera);
  parallel_for(std::size_t(options.height), [&](std::size_t y) {
    for (int x = 0; x < options.width && !stop.stop_requested(); ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int k = 0; k < samples; ++k) {
        const Vec3f ray = view.ray(Vec2d(x, double(y)) + sample_position(k));
        sum += room.look(view.origin, ray).cwiseMin(kBrightest);
      }
      seen[y * std::size_t(options.width) + x] = sum / float(samples);
    }
  });
  return seen;
}

// Makes the plate of a camera; false when stopped.
bool DemoStage::Impl::rest_on(const Camera& camera, std::stop_token stop) {
  if (plate_camera && same_view(*plate_camera, camera)) return true;
  plate = room_seen(camera, kPlateSamples, stop);
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
Shot DemoStage::shot(int frame) const { return impl_->shot(frame); }
const std::vector<DemoShot>& DemoStage::shots() const { return impl_->shots; }

DemoFrame DemoStage::film(int frame, std::stop_token stop) {
  const bool in_layers = impl_->options.drift || impl_->options.motion_blur;
  return in_layers ? impl_->film_in_layers(frame, stop)
                   : impl_->film_at_once(impl_->shot(frame), impl_->rests(frame), stop);
}

DemoFrame DemoStage::film(const Shot& shot, std::stop_token stop) {
  return impl_->film_at_once(shot, false, stop);
}

DemoFrame DemoStage::Impl::film_at_once(const Shot& shot, bool resting, std::stop_token stop) {
  const DemoOptions& o = options;
  DemoFrame result{Image8(o.width, o.height, 3), Image8(o.width, o.height, 1), true};
  person.pose(shot, stop);
  if (stop.stop_requested() || (resting && !rest_on(shot.camera, stop))) {
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
        const auto seen = person.look(view.origin, ray);
        covered += seen ? 1 : 0;
        if (seen)
          sum += seen->cwiseMin(kBrightest);
        else
          sum += resting ? plate[y * std::size_t(o.width) + x]
                         : room.look(view.origin, ray).cwiseMin(kBrightest);
      }
      put(sum / float(samples), result.rgb.at(x, int(y)));
      *result.mask.at(x, int(y)) = std::uint8_t((255 * covered + samples / 2) / samples);
    }
  });
  result.complete = !stop.stop_requested();
  return result;
}

// When a frame is exposed, s about its middle: once, or, if something moves by more than a pixel while the
// shutter is open, several times.
std::vector<double> DemoStage::Impl::exposures(int frame) const {
  if (!options.motion_blur) return {0};
  const double open_s = kShutter / options.frames_per_second;
  const auto seen = [&](double later_s) {
    const Shot shot = this->shot(frame, later_s);
    std::vector<Vec2d> places;
    for (const Vec3f& p : landmark_positions(model, play.pose(shot.articulation, shot.habit))) {
      const Vec3d in_cam = shot.camera.cam_from_world * shot.world_from_head * p.cast<double>();
      places.push_back(project<double>(shot.camera.intrinsics, in_cam));
    }
    for (const double x : {-1.2, 1.2}) {  // of the back wall
      const Vec3d in_cam = shot.camera.cam_from_world * Vec3d(x, 0.3, kBackWall_m);
      places.push_back(project<double>(shot.camera.intrinsics, in_cam));
    }
    return places;
  };
  const std::vector<Vec2d> before = seen(-0.5 * open_s), after = seen(0.5 * open_s);
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i) most = std::max(most, (after[i] - before[i]).norm());
  const int count = most < 1 ? 1 : std::clamp(int(std::ceil(most)) + 1, 2, kMostExposures);
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(open_s * ((i + 0.5) / count - 0.5));
  return times;
}

// Adds `share` of one exposure to the layers; false when stopped.
bool DemoStage::Impl::expose(int frame, double later_s, float share, FilmLayers& sum, std::stop_token stop) {
  const Shot shot = this->shot(frame, later_s);
  person.pose(shot, stop);
  const int samples = std::max(1, options.samples_per_pixel);
  const bool resting = rests(frame);
  if (stop.stop_requested() || (resting && !rest_on(shot.camera, stop))) return false;
  const std::vector<Vec3f> behind = resting ? plate : room_seen(shot.camera, samples, stop);
  const View view(shot.camera);
  parallel_for(std::size_t(options.height), [&](std::size_t y) {
    for (int x = 0; x < options.width && !stop.stop_requested(); ++x) {
      const std::size_t at = y * std::size_t(options.width) + std::size_t(x);
      for (int k = 0; k < samples; ++k) {
        const Vec3f ray = view.ray(Vec2d(x, double(y)) + sample_position(k));
        const auto seen = person.look(view.origin, ray);
        if (!seen) continue;
        sum.person[at] += share / float(samples) * seen->cwiseMin(kBrightest);
        sum.alpha[at] += share / float(samples);
      }
      sum.room[at] += share * behind[at];
    }
  });
  return !stop.stop_requested();
}

DemoFrame DemoStage::Impl::film_in_layers(int frame, std::stop_token stop) {
  const int width = options.width, height = options.height;
  DemoFrame result{Image8(width, height, 3), Image8(width, height, 1), false};
  const std::size_t pixels = std::size_t(width) * std::size_t(height);
  FilmLayers layers{width, height, {}, std::vector<float>(pixels, 0), {}};
  layers.person.assign(pixels, Vec3f::Zero());
  layers.room.assign(pixels, Vec3f::Zero());
  const std::vector<double> times = exposures(frame);
  for (const double later_s : times)
    if (!expose(frame, later_s, 1 / float(times.size()), layers, stop)) return result;
  const Drift drift = drift_of(options, frame);
  blur_layer(layers.person, width, height, drift.face_blur_px);
  blur_layer(layers.alpha, width, height, drift.face_blur_px);
  blur_layer(layers.room, width, height, drift.room_blur_px);
  for (std::size_t i = 0; i < pixels; ++i) {
    const float alpha = std::clamp(layers.alpha[i], 0.0f, 1.0f);
    const Vec3f radiance = layers.person[i] + (1 - alpha) * layers.room[i];
    put(drift.gain.cwiseProduct(radiance), &result.rgb.data[3 * i]);
    result.mask.data[i] = std::uint8_t(std::lround(255 * alpha));
  }
  result.complete = true;
  return result;
}

std::optional<Image8> DemoStage::film_room(int frame, std::stop_token stop) {
  Impl& me = *impl_;
  const int width = me.options.width, height = me.options.height;
  std::vector<Vec3f> room(std::size_t(width) * std::size_t(height), Vec3f::Zero());
  const std::vector<double> times = me.exposures(frame);
  for (const double later_s : times) {
    const Camera camera = me.shot(frame, later_s).camera;
    if (me.rests(frame) && !me.rest_on(camera, stop)) return std::nullopt;
    const std::vector<Vec3f> seen = me.rests(frame) ? me.plate : me.room_seen(camera, kPlateSamples, stop);
    if (stop.stop_requested()) return std::nullopt;
    for (std::size_t i = 0; i < room.size(); ++i) room[i] += seen[i] / float(times.size());
  }
  const Drift drift = drift_of(me.options, frame);
  blur_layer(room, width, height, drift.room_blur_px);
  Image8 picture(width, height, 3);
  for (std::size_t i = 0; i < room.size(); ++i) put(drift.gain.cwiseProduct(room[i]), &picture.data[3 * i]);
  return picture;
}

std::optional<Image8> DemoStage::film_room(const Camera& camera, std::stop_token stop) {
  const Impl& me = *impl_;
  const std::vector<Vec3f> room = me.room_seen(camera, std::max(1, me.options.samples_per_pixel), stop);
  if (stop.stop_requested()) return std::nullopt;
  Image8 picture(me.options.width, me.options.height, 3);
  for (std::size_t i = 0; i < room.size(); ++i) put(room[i], &picture.data[3 * i]);
  return picture;
}

}  // namespace likeness
