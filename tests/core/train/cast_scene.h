// A training set with everything a ray can pass, for tests of ray casting: views of two clips with distorted
// lenses and pictures that nobody filmed, mattes, a guessed plate and pixels that teach nothing; a warped
// face, a bent neck, a torso that deforms, still cells and sides that the first clip does not show. The
// fields are small and random.
#pragma once

#include <random>

#include "core/base/rigid.h"
#include "core/render/pose_avatar.h"
#include "core/train/training_step.h"
#include "tests/core/render/posed_tiny_avatar.h"

namespace likeness {

inline OccupancyGrid random_cells(int n, std::uint32_t seed, std::uint32_t of) {
  OccupancyGrid grid = make_occupancy(n, false);
  std::mt19937 random(seed);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) set_occupied(grid, x, y, z, random() % of == 0);
  return grid;
}

inline Image8 random_picture(int width, int height, int channels, std::uint32_t seed) {
  Image8 image(width, height, channels);
  std::mt19937 random(seed);
  for (std::uint8_t& value : image.data) value = std::uint8_t(random());
  return image;
}

struct CastScene {
  static constexpr std::size_t kOwn = 3, kFurther = 2, kProxies = 2, kViews = kOwn + kFurther + kProxies;
  static constexpr int kRays = 900;
  TrainingSet set;
  TrainingState state;
  RaySource source;
  StepOptions options;

  CastScene() {
    const Avatar avatar = posable_avatar();
    options.rays = kRays, options.seed = 4;
    make_state(avatar);
    for (std::size_t v = 0; v < kViews; ++v) add_view(avatar, int(v));
    set.plate = random_picture(70, 50, 3, 90);
    set.plate_known = random_picture(70, 50, 1, 91);
    for (std::uint8_t& known : set.plate_known.data) known = known < 100 ? known : 255;
    set.further_plates[1] = {random_picture(70, 50, 3, 92), {}};
    source.set = &set;
    source.sides = random_cells(32, 93, 2);
  }
  CastScene(const CastScene&) = delete;

  void place_poses(int turn) {
    const Avatar avatar = posable_avatar();
    for (std::size_t v = 0; v < kViews; ++v) place_view(avatar, int(v), turn);
  }

 private:
  static TrainedField trained(const FieldPart& part, std::uint32_t seed) {
    TrainedField field;
    field.part = part;
    const int n = part.occupancy.resolution;
    field.volume.cube = part.cube, field.volume.core = part.core;
    field.volume.allowed = random_cells(n, seed, 8);
    for (std::size_t i = 0; i < field.volume.allowed.bits.size(); ++i)
      field.volume.allowed.bits[i] |= part.occupancy.bits[i];
    field.volume.kept = random_cells(n, seed + 1, 30);
    field.learnt = make_occupancy_state(field.volume);
    std::mt19937 random(seed + 2);
    for (float& density : field.learnt.density) density = float(random() % 100) / 10;
    field.adam = make_adam_state(field.part.field);
    return field;
  }
  void make_state(const Avatar& avatar) {
    state.head = trained(avatar.head, 50);
    state.head.volume.still = random_cells(avatar.head.occupancy.resolution, 60, 3);
    state.torso = trained(*avatar.torso, 70);
    const auto length = std::size_t(avatar.head.field.config.latent_count);
    state.codes.assign(2 * kViews * length, 0.f);
    std::mt19937 random(80);
    for (std::size_t i = 0; i < 2 * kViews * 2; ++i)
      state.conditions.push_back(float(random() % 200) / 100 - 1);
    state.deviations = {0.5f, 0.3f};
    state.schedule.total_steps = 100;
  }
  void add_view(const Avatar& avatar, int number) {
    TrainingView view;
    view.camera = typical_camera(avatar);
    view.camera.intrinsics.cx += number, view.camera.intrinsics.p1 = 0.001 * number;
    view.rgb = random_picture(70, 50, 3, std::uint32_t(number));
    const bool proxy = number >= int(kOwn + kFurther);
    view.further_clip = number < int(kOwn) || proxy ? 0 : 1 + (number - int(kOwn)) % 2;
    view.has_plate = number != 1 && !proxy;
    if (proxy) view.part = number + 1 < int(kViews) ? LearntPart::head : LearntPart::torso;
    if (number != 2) {
      Image8 alpha = random_picture(70, 50, 1, 100 + std::uint32_t(number));
      for (std::uint8_t& value : alpha.data) value = value < 90 ? 0 : value > 150 ? 255 : value;
      view.alpha = TiledMask(alpha);
    }
    if (view.further_clip > 0 || proxy) {
      Image8 teaches = random_picture(70, 50, 1, 200 + std::uint32_t(number));
      for (std::uint8_t& value : teaches.data) value = value < (number == 4 ? 250 : 128) ? 0 : 255;
      view.teaches = TiledMask(teaches);
    }
    (proxy ? set.proxies : set.views).push_back(std::move(view));
    source.views.emplace_back();
    RaySource::View& own = source.views.back();
    own.face_x0 = 20 + number, own.face_y0 = 10, own.face_x1 = 50, own.face_y1 = number == 0 ? 10 : 40;
    if (number >= int(kOwn) && !proxy) own.gain = Vec3f(1.3f, 0.9f, 1.1f);
    source.warps.emplace_back(), source.torsos.emplace_back(), source.necks.emplace_back();
    place_view(avatar, number, 0);
  }
  void place_view(const Avatar& avatar, int number, int turn) {
    const auto v = std::size_t(number);
    const RenderState posed = posed_state(avatar, number + turn);
    const Pose& cam = picture_at(set, v).camera.cam_from_world;
    // One neck of all is straight.
    const Pose& torso = number == 1 ? posed.pose.world_from_head : posed.pose.world_from_torso;
    source.views[v].maps[0] = unit_from_camera(avatar.head.cube, cam, posed.pose.world_from_head);
    source.views[v].maps[1] = unit_from_camera(avatar.torso->cube, cam, torso);
    source.warps[v] = posed.warp, source.torsos[v] = posed.torso;
    source.necks[v] = make_neck_bend(avatar.neck, inverse(posed.pose.world_from_head) * torso,
                                     avatar.head.cube.origin, avatar.head.cube.side);
  }
};

}  // namespace likeness
