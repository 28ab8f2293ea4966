// Learning the cells of each look-up, and what it culls: see cull_study.h.
#include "core/lab/study/cull_study.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/field/evaluate.h"
#include "core/head/named_actions.h"
#include "core/lab/score/held_out.h"
#include "core/lab/score/sized_clip.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/training_set.h"
#include "core/render/canonical_samples.h"
#include "core/render/pose_avatar.h"
#include "core/train/canonical_cells.h"
#include "core/train/capture_summary.h"
#include "core/train/cell_math.h"
#include "core/train/occupancy_refresh.h"
#include "core/train/random_stream.h"

namespace likeness {
namespace {

constexpr int kLooks = 32;          // into each cell
constexpr float kSpacing = 0.002f;  // m
constexpr int kPixelStride = 3;
constexpr float kFar = 20;  // m

std::size_t cell_index(int n, float x, float y, float z) {
  const auto along = [n](float at) { return std::size_t(std::clamp(int(at * float(n)), 0, n - 1)); };
  return (along(z) * std::size_t(n) + along(y)) * std::size_t(n) + along(x);
}

bool holds(const OccupancyGrid& grid, float x, float y, float z) {
  const std::size_t i = cell_index(grid.resolution, x, y, z);
  return grid.bits[i >> 3] >> (i & 7) & 1;
}

// Maps samples to canonical space by the lattices and bends of their views.
void to_canonical(std::span<const WarpLattice> lattices, std::span<const NeckBend> necks,
                  const FieldCube& cube, FieldSamples& samples) {
  warp_samples(lattices, cube, samples);
  straighten_samples(necks, samples);
}

// Raises every cell to the highest density found in it so far.
void keep_most(std::vector<float>& most, std::span<const float> sigma, auto&& cell) {
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    float& kept = most[cell(i)];
    kept = std::max(kept, sigma[i]);
  }
}

}  // namespace

LearntCells learn_cells(const CullScene& scene, int looks, std::uint64_t seed) {
  const int n = scene.head.allowed.resolution;
  const auto views = std::uint32_t(scene.lattices.size());
  LIKENESS_CHECK(views > 0, "cells of %u views", views);
  OccupancyState posed = make_occupancy_state(scene.head);
  std::ranges::fill(posed.density, 0.f);
  CanonicalState canonical = make_canonical_state(n), resting = canonical;
  std::ranges::fill(canonical.density, 0.f), std::ranges::fill(resting.density, 0.f);
  FieldSamples samples;
  std::vector<float> sigma;
  for (int look = 0; look < looks; ++look) {
    samples.resize(posed.cells.size());
    for (std::size_t i = 0; i < posed.cells.size(); ++i) {
      const CellSample at(posed.cells[i], n, views, seed, std::uint64_t(look), i);
      samples.x[i] = at.place[0], samples.y[i] = at.place[1], samples.z[i] = at.place[2];
      samples.view[i] = at.view;
    }
    FieldSamples moved = samples;
    to_canonical(scene.lattices, scene.necks, scene.head.cube, moved);
    scene.density(moved, sigma);
    keep_most(posed.density, sigma, [](std::size_t i) { return i; });
    const auto canonical_cell = [&](std::size_t i) {
      return cell_index(n, moved.x[i], moved.y[i], moved.z[i]);
    };
    keep_most(canonical.density, sigma, canonical_cell);
    // The face at rest, at the places of these samples in canonical space.
    std::ranges::fill(moved.view, std::int32_t(views));
    scene.density(moved, sigma);
    keep_most(resting.density, sigma, canonical_cell);
  }
  const FieldInputs none;
  // Spread to the neighbours, as training does.
  for (CanonicalState* state : {&canonical, &resting}) {
    for (float& density : state->density) density /= kCellDecay;  // an update lets all decay before it adds
    add_cell_samples(*state, none, {});
  }
  return {occupancy_bits(posed, scene.head), std::move(canonical.occupancy), std::move(resting.occupancy)};
}

void add_culled(const CullScene& scene, const OccupancyGrid& trained, const LearntCells& cells,
                const CullView& view, float spacing, CullTable& table) {
  const Volume& head = scene.head;
  const MarchVolume volume = march_volume(head.allowed, head.core, head.cube.side);
  std::optional<MarchNeck> neck;
  if (view.neck) neck = march_neck(*view.neck, volume);

  // -- Samples of all rays through allowed cells.
  FieldSamples posed;
  std::vector<std::size_t> begin{0};
  std::vector<Interval> intervals;
  for (const FieldRay& ray : view.rays) {
    intervals.clear();
    occupied_intervals(ray, volume, 0.05f, kFar, intervals, neck ? &*neck : nullptr);
    const std::size_t first = posed.count();
    for (const Interval& stretch : intervals) {
      const int count = int(std::floor((stretch.far - stretch.near) / spacing + 0.5f));
      for (int k = 0; k < count; ++k) {
        const Vec3f p = ray.origin + (stretch.near + (float(k) + 0.5f) * spacing) * ray.direction;
        posed.x.push_back(std::clamp(p.x(), 0.f, 1.f));
        posed.y.push_back(std::clamp(p.y(), 0.f, 1.f));
        posed.z.push_back(std::clamp(p.z(), 0.f, 1.f));
      }
    }
    if (posed.count() > first) begin.push_back(posed.count());
  }
  const std::size_t count = posed.count();
  posed.dx.resize(count), posed.dy.resize(count), posed.dz.resize(count);
  posed.view.assign(count, 0);

  // -- Where they lie in the canonical face, and what is there.
  const std::span<const NeckBend> necks =
      view.neck ? std::span<const NeckBend>(view.neck, 1) : std::span<const NeckBend>();
  FieldSamples straight = posed, canonical = posed;
  straighten_samples(necks, straight);
  to_canonical(view.lattice ? std::span<const WarpLattice>(view.lattice, 1) : std::span<const WarpLattice>(),
               necks, head.cube, canonical);
  std::ranges::fill(canonical.view, view.row);
  std::vector<float> sigma;
  scene.density(canonical, sigma);

  // -- What each look-up keeps.
  const auto in_posed = [&](const OccupancyGrid& grid, std::size_t i) {
    return holds(grid, posed.x[i], posed.y[i], posed.z[i]) ||
           holds(grid, straight.x[i], straight.y[i], straight.z[i]);
  };
  const auto in_canonical = [&](const OccupancyGrid& grid, std::size_t i) {
    return holds(head.kept, posed.x[i], posed.y[i], posed.z[i]) ||
           holds(grid, canonical.x[i], canonical.y[i], canonical.z[i]);
  };
  for (std::size_t row = 0; row < table.size(); ++row) {
    CullSums& sums = table[row];
    for (std::size_t r = 0; r + 1 < begin.size(); ++r) {
      ++sums.rays;
      double transmittance = 1;
      for (std::size_t i = begin[r]; i < begin[r + 1]; ++i) {
        const bool kept = row == 0   ? true
                          : row == 1 ? in_posed(trained, i)
                          : row == 2 ? in_posed(cells.posed, i)
                          : row == 3 ? in_canonical(cells.canonical, i)
                                     : in_canonical(cells.resting, i);
        const double left = std::exp(-double(sigma[i] * spacing / head.cube.side));
        const double light = transmittance * (1 - left);
        transmittance *= left;
        ++sums.samples;
        sums.kept += kept;
        sums.light += light;
        sums.light_lost += kept ? 0 : light;
        if (sigma[i] <= kCellThreshold) continue;
        ++sums.dense;
        sums.density += double(sigma[i]);
        if (kept) continue;
        ++sums.dense_lost;
        sums.density_lost += double(sigma[i]);
      }
    }
  }
}

namespace {

// The conditions of views as one array of rows, painted attributes at rest.
struct Conditions {
  const Avatar& avatar;
  std::vector<float> rows;
  std::int32_t count = 0;

  std::int32_t add(const Articulation& articulation) {
    const Eigen::VectorXf psi = condition(avatar.condition, articulation, avatar.attributes, {});
    rows.insert(rows.end(), psi.begin(), psi.end());
    return count++;
  }
};

std::vector<FieldRay> rays_of(const FieldCube& cube, const Camera& camera, const Pose& world_from_head) {
  const UnitFromCamera map = unit_from_camera(cube, camera.cam_from_world, world_from_head);
  std::vector<FieldRay> rays;
  for (int y = 0; y < camera.intrinsics.height; y += kPixelStride)
    for (int x = 0; x < camera.intrinsics.width; x += kPixelStride)
      rays.push_back(field_ray(
          map, ray_direction(camera.intrinsics, Vec2d(x + 0.5, y + 0.5)).normalized().cast<float>()));
  return rays;
}

struct PosedView {
  Camera camera;
  AvatarPose pose;
};

// Every action alone and at full, from the typical place.
std::vector<PosedView> acted_views(const Avatar& avatar, const HeadModel& model) {
  std::vector<PosedView> views;
  for (const NamedAction& action : model.actions) {
    if (action.name.starts_with("eyeLook")) continue;  // gaze moves no lattice
    PosedView& view = views.emplace_back();
    view.camera.intrinsics = avatar.intrinsics, view.camera.cam_from_world = avatar.cam_from_world;
    view.pose = typical_state(avatar).pose;
    add_action(view.pose.articulation, action, 1);
  }
  return views;
}

std::vector<PosedView> held_out_views(const HeldOutSet& set, int most) {
  std::vector<PosedView> all, chosen;
  for (const int frame : held_out_frames(set.capture)) {
    const TrackedFrame* t = find_tracked(set.track, frame);
    const auto camera = picture_camera(set.capture, set.cameras, set.track, frame);
    if (t == nullptr || t->status == FrameStatus::lost || !camera) continue;
    all.push_back({.camera = *camera, .pose = t->pose});
  }
  for (const std::size_t k : evenly_chosen(all.size(), std::size_t(std::max(0, most))))
    chosen.push_back(all[k]);
  return chosen;
}

}  // namespace

Result<CullStudy> study_culling(const Project& project, int frames, const Progress& progress,
                                std::stop_token stop) {
  const auto held_out = read_held_out(project);
  if (!held_out) return held_out.error();
  const Avatar& avatar = held_out->avatar;
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  if (const auto fits = check_avatar_fits(avatar, *model, project.folder.string()); !fits)
    return fits.error();
  const auto set = load_training_set(project, *model);
  if (!set) return set.error();
  const auto made = make_rig(avatar, *model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  if (!rig.warps)
    return Error{ErrorCode::bad_input, "This avatar's face is not deformed by the head model.",
                 "Train it in the mode warp+hyper: likeness train --mode warp+hyper.",
                 project.folder.string()};
  const std::vector<PosedView> seen = held_out_views(*held_out, frames);
  if (seen.empty())
    return Error{ErrorCode::failed, "None of the held-out frames has a track, so nothing can be measured.",
                 "Film a longer clip in which the face stays in view to the end.", project.folder.string()};

  // -- The training's views, the face at rest, and the density of all.
  const Volumes volumes = make_volumes(*set, rig.shape);
  const FieldCube& cube = volumes.head.cube;
  Conditions conditions{avatar, {}};
  const std::span<const TrainingView> own = own_views(*set);
  std::vector<WarpLattice> lattices(own.size());
  std::vector<NeckBend> necks(avatar.neck.empty() ? 0 : own.size());
  parallel_for(own.size(), [&](std::size_t v) {
    const TrainingView& view = own[v];
    lattices[v] = pose_avatar(rig, view.pose).warp;
    if (!necks.empty())
      necks[v] = make_neck_bend(avatar.neck, inverse(view.pose.world_from_head) * view.pose.world_from_torso,
                                cube.origin, cube.side);
  });
  for (const TrainingView& view : own) conditions.add(view.pose.articulation);
  conditions.add(avatar.neutral);
  const CullScene scene{volumes.head, lattices, necks,
                        [&](const FieldSamples& at, std::vector<float>& sigma) {
                          const std::vector<float> weights(avatar.attributes.size() * at.count(), 0.f);
                          FieldInputs inputs = at.inputs(conditions.rows.data(), nullptr);
                          if (!weights.empty()) inputs.local = weights.data();
                          evaluate_density(avatar.head.field, inputs, sigma);
                        }};
  if (stop.stop_requested()) return cancelled_error();
  progress.report(0.1, "sampling the cells");
  const LearntCells cells = learn_cells(scene, kLooks, avatar.seed);

  CullStudy study;
  study.spacing = kSpacing, study.threshold = kCellThreshold;
  const std::vector<PosedView> acted = acted_views(avatar, *model);
  study.frames = int(seen.size()), study.actions = int(acted.size());
  double done = 0;
  for (const auto& [views, table] : {std::pair(&seen, &study.held_out), {&acted, &study.acted}})
    for (const PosedView& view : *views) {
      if (stop.stop_requested()) return cancelled_error();
      progress.report(0.2 + 0.8 * done++ / double(seen.size() + acted.size()));
      const RenderState state = pose_avatar(rig, view.pose);
      std::optional<NeckBend> neck;
      if (!avatar.neck.empty())
        neck = make_neck_bend(avatar.neck, inverse(view.pose.world_from_head) * view.pose.world_from_torso,
                              cube.origin, cube.side);
      add_culled(scene, avatar.head.occupancy, cells,
                 {rays_of(cube, view.camera, view.pose.world_from_head), &state.warp, neck ? &*neck : nullptr,
                  conditions.add(view.pose.articulation)},
                 kSpacing, *table);
    }
  progress.report(1);
  return study;
}

}  // namespace likeness
