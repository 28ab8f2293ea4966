// Volumes from the head mesh, a body shape below it, and the mattes.
#include "core/train/volumes.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/train/carve.h"
#include "core/train/head_marks.h"
#include "core/train/still_cells.h"

namespace likeness {
namespace {

constexpr int kCarveViews = 64, kPoses = 12;
constexpr float kNeckRoot = 0.03f;  // m below the base to which the head's field extends, fixed to the torso
constexpr float kShortestNeck = 0.02f;    // m; models with less neck turn stiffly
constexpr float kBustTop = 0.02f;         // m below the chin that the shoulders of a model may reach up to
constexpr float kNeckBelowChin = 0.005f;  // m that the bend ends below the chin
constexpr float kShoulderTop = 0.05f;     // m above the chin that collars beside the neck may reach
constexpr float kCollar = 0.04f;          // m above the base that the torso may reach up along the neck
constexpr float kBesideFace = 0.006f;     // m above the chin: collars end below, shoulders mostly too
constexpr float kMouthMargin = 0.008f;
constexpr float kSpacing = 0.005f;  // m between points of the skin

// Hair, skin envelope (parts of it show only in a few expressions), chest and arms (arms come and go), collar
// (a head leaning over it must not be taken for it), and the region beside the face, which the head covers in
// most views: hardly any of it is torso.
constexpr CarveRule kRules[] = {{0.9f}, {0.05f}, {0.3f}, {0.8f}, {0.8f, true}};
enum CellClass : std::uint8_t { kHair = 0, kSkin = 1, kChest = 2, kCollarCell = 3, kShoulder = 4 };

struct Ball {
  Vec3f centre;
  float radius;
};  // m

std::size_t cell_count(int n) { return std::size_t(n) * n * n; }

// Sets every cell whose centre lies in a ball to `value`.
void fill_balls(std::vector<std::uint8_t>& cells, int n, const FieldCube& cube,
                const std::vector<Ball>& balls, std::uint8_t value) {
  const float scale = float(n) / cube.side;
  parallel_for(std::size_t(n), [&](std::size_t z) {
    for (const Ball& ball : balls) {
      const Vec3f c = (ball.centre - cube.origin) * scale - Vec3f::Constant(0.5f);
      const float r = ball.radius * scale, dz = float(z) - c.z();
      if (std::abs(dz) > r) continue;
      const float ry = std::sqrt(r * r - dz * dz);
      for (int y = std::max(0, int(std::ceil(c.y() - ry))); y <= std::min(n - 1, int(std::floor(c.y() + ry)));
           ++y) {
        const float dy = float(y) - c.y(), rx = std::sqrt(std::max(0.f, ry * ry - dy * dy));
        const int x0 = std::max(0, int(std::ceil(c.x() - rx))),
                  x1 = std::min(n - 1, int(std::floor(c.x() + rx)));
        for (int x = x0; x <= x1; ++x) cells[(z * n + y) * n + x] = value;
      }
    }
  });
}

bool is_mouth(const HeadModel& model, std::size_t v) {
  if (model.parts.empty()) return false;
  const HeadPart part = model.parts[v];
  return part == HeadPart::mouth_socket || part == HeadPart::gums_tongue || part == HeadPart::teeth;
}

// Busts flare out below the neck; that region belongs to the torso.
bool on_shoulder(const HeadMarks& marks, const Vec3f& p) {
  return p.y() < marks.chin - kBustTop && Vec3f(p.x(), 0, p.z() - marks.ear_z).norm() > 0.08f;
}

// Neutral, the widest jaw a slider can set, and poses of the training track.
std::vector<Articulation> envelope_poses(const TrainingSet& set) {
  std::vector<Articulation> poses{neutral_articulation(set.model)};
  for (const NamedAction& action : set.model.actions)
    if (action.name == "jawOpen") {
      Articulation open = poses[0];
      if (action.expression.size() == open.expression.size()) open.expression = action.expression;
      open.jaw = action.jaw;
      poses.push_back(open);
    }
  const std::size_t n = std::min<std::size_t>(set.views.size(), kPoses);
  for (std::size_t i = 0; i < n; ++i) {
    Articulation a = set.views[i * set.views.size() / n].pose.articulation;
    a.neck.setZero();
    poses.push_back(std::move(a));
  }
  return poses;
}

// Points all over the skin: scalps are often coarse meshes.
std::vector<Vec3f> surface_points(const HeadModel& model, const std::vector<Vec3f>& posed) {
  std::vector<Vec3f> points;
  for (const Triangle& t : model.triangles) {
    if (!is_skin(model, std::size_t(t[0]))) continue;
    const Vec3f a = posed[std::size_t(t[0])], ab = posed[std::size_t(t[1])] - a,
                ac = posed[std::size_t(t[2])] - a;
    const float longest = std::max({ab.norm(), ac.norm(), (ab - ac).norm()});
    const int n = std::clamp(int(std::ceil(longest / kSpacing)), 1, 64);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) points.push_back(a + (float(i) * ab + float(j) * ac) / float(n));
  }
  return points;
}

struct HeadBalls {
  std::vector<Ball> hair, skin, mouth, wall, near;
};

HeadBalls head_balls(const TrainingSet& set, const HeadShape& shape, const HeadMarks& marks,
                     const VolumeOptions& options) {
  HeadBalls balls;
  const std::vector<Articulation> poses = envelope_poses(set);
  const bool has_mouth = std::any_of(set.model.parts.begin(), set.model.parts.end(), [](HeadPart part) {
    return part == HeadPart::teeth || part == HeadPart::mouth_socket;
  });
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::vector<Vec3f> posed = pose_head(set.model, shape, poses[i]);
    for (std::size_t v = 0; v < posed.size(); ++v) {
      if (posed[v].y() < marks.base - kNeckRoot || on_shoulder(marks, posed[v])) continue;
      if (is_mouth(set.model, v)) balls.mouth.push_back({posed[v], kMouthMargin});
      if (!is_skin(set.model, v)) {
        balls.near.push_back({posed[v], options.core_depth});
        continue;
      }
      balls.near.push_back({posed[v], options.core_depth});
      balls.skin.push_back({posed[v], options.skin_margin});
      if (i > 0) continue;
      const float hair = hairiness(marks, posed[v]);
      if (hair > 0)
        balls.hair.push_back(
            {posed[v], options.skin_margin + hair * (options.hair_margin - options.skin_margin)});
    }
    if (!has_mouth && i < 2) {
      const auto landmarks = landmark_positions(set.model, posed);
      for (int k = 60; k < 68; ++k)
        for (int back = 0; back < 3; ++back)
          balls.mouth.push_back({landmarks[std::size_t(k)] - Vec3f(0, 0, 0.01f * float(back)), 0.012f});
    }
    if (i > 0) continue;
    for (const Vec3f& p : surface_points(set.model, posed)) {
      // Thick enough that open eyes, mouths and coarse scalps stay closed; nothing shallower can be core
      // anyway.
      balls.wall.push_back({p, options.core_depth});
      balls.near.push_back({p, options.core_depth});
    }
  }
  return balls;
}

// Cells that air from outside the cube cannot reach through the wall. Below the base counts as wall.
std::vector<std::uint8_t> enclosed_cells(const std::vector<std::uint8_t>& wall, int n) {
  std::vector<std::uint8_t> reached = wall;
  std::vector<std::uint32_t> stack;
  const auto visit = [&](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= n || y >= n || z >= n) return;
    const std::size_t i = (std::size_t(z) * n + y) * n + x;
    if (reached[i]) return;
    reached[i] = 1;
    stack.push_back(std::uint32_t(i));
  };
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      visit(0, a, b), visit(n - 1, a, b);
      visit(a, 0, b), visit(a, n - 1, b);
      visit(a, b, 0), visit(a, b, n - 1);
    }
  while (!stack.empty()) {
    const int i = int(stack.back());
    stack.pop_back();
    const int x = i % n, y = i / n % n, z = i / (n * n);
    visit(x - 1, y, z), visit(x + 1, y, z);
    visit(x, y - 1, z), visit(x, y + 1, z);
    visit(x, y, z - 1), visit(x, y, z + 1);
  }
  for (auto& cell : reached) cell = !cell;
  return reached;
}

OccupancyGrid to_grid(const std::vector<std::uint8_t>& cells, int n) {
  OccupancyGrid grid = make_occupancy(n, false);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        if (cells[(std::size_t(z) * n + y) * n + x]) set_occupied(grid, x, y, z, true);
  return grid;
}

FieldCube cube_around(const Vec3f& low, const Vec3f& high) {
  FieldCube cube;
  cube.side = (high - low).maxCoeff() + 0.01f;
  cube.origin = 0.5f * (low + high) - Vec3f::Constant(0.5f * cube.side);
  return cube;
}

Volume head_volume(const TrainingSet& set, const HeadShape& shape, const HeadMarks& marks,
                   const VolumeOptions& options) {
  const int n = options.head_resolution;
  const HeadBalls balls = head_balls(set, shape, marks, options);
  Vec3f low = Vec3f::Constant(1e9f), high = -low;
  for (const auto* list : {&balls.hair, &balls.skin})
    for (const Ball& ball : *list) {
      low = low.cwiseMin(ball.centre - Vec3f::Constant(ball.radius));
      high = high.cwiseMax(ball.centre + Vec3f::Constant(ball.radius));
    }
  const float bottom = set.has_torso ? marks.base - kNeckRoot : marks.base;
  low.y() = bottom;
  Volume volume;
  volume.cube = cube_around(low, high);

  std::vector<std::uint8_t> hair(cell_count(n), 0), skin = hair, wall = hair, near = hair, mouth = hair;
  fill_balls(hair, n, volume.cube, balls.hair, 1);
  fill_balls(skin, n, volume.cube, balls.skin, 1);
  fill_balls(near, n, volume.cube, balls.near, 1);
  fill_balls(wall, n, volume.cube, balls.wall, 1);
  fill_balls(mouth, n, volume.cube, balls.mouth, 1);
  const auto below = [&](int y) {
    return volume.cube.origin.y() + (float(y) + 0.5f) * volume.cube.side / float(n) < bottom;
  };
  // Busts are open below and often at the shoulders: the flood is kept above the chin.
  const auto under_chin = [&](int y) {
    return volume.cube.origin.y() + (float(y) + 0.5f) * volume.cube.side / float(n) < marks.chin;
  };
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n && under_chin(y); ++y)
      for (int x = 0; x < n; ++x) wall[(std::size_t(z) * n + y) * n + x] = 1;
  const std::vector<std::uint8_t> enclosed = enclosed_cells(wall, n);

  // Skin lies between the margin outside and core_depth inside; enclosed cells that are deeper are core. The
  // mouth's inside always belongs to the head.
  std::vector<std::uint8_t> allowed(cell_count(n), 0), core = allowed, classes(cell_count(n), kHair);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const std::size_t i = (std::size_t(z) * n + y) * n + x;
        if (below(y)) {
          mouth[i] = 0;
          continue;
        }
        core[i] = enclosed[i] && !near[i] && !mouth[i];
        allowed[i] = (hair[i] || skin[i] || mouth[i] || enclosed[i]) && !core[i];
        if (skin[i] || mouth[i] || enclosed[i]) classes[i] = kSkin;
      }
  volume.allowed = to_grid(allowed, n);
  volume.kept = to_grid(mouth, n);
  volume.core = to_grid(core, n);
  if (options.carve) carve(volume.allowed, volume.cube, head_carve_views(set, kCarveViews), classes, kRules);
  return volume;
}

// Flat elliptic cylinder below the chin; generous, since the reference head may lean towards the shoulders;
// the mattes carve it. p in the torso frame.
bool in_body(const HeadMarks& marks, float axis_z, const Vec3f& p) {
  constexpr float kHalfWidth = 0.54f, kNeckDepth = 0.085f, kChestDepth = 0.13f;
  if (p.y() > marks.chin + kShoulderTop) return false;
  const float drop = std::clamp((marks.base + 0.02f - p.y()) / 0.08f, 0.f, 1.f);  // 0 neck, 1 chest
  const float x = p.x() / kHalfWidth, z = (p.z() - axis_z) / (kNeckDepth + drop * (kChestDepth - kNeckDepth));
  return x * x * x * x + z * z < 1;
}

// Both frames coincide in the straight neck, so a place of the torso is one of the head. The neck above the
// collar belongs only to the head: a second one on the torso would stay behind when the head moves.
bool is_neck(const Volume& head, const HeadMarks& marks, const Vec3f& p) {
  if (p.y() < marks.base + kCollar) return false;
  const int n = head.allowed.resolution;
  const Vec3f cell = (p - head.cube.origin) * (float(n) / head.cube.side);
  if ((cell.array() < 0).any() || (cell.array() >= float(n)).any()) return false;
  const int x = int(cell.x()), y = int(cell.y()), z = int(cell.z());
  return head.allowed.occupied(x, y, z) || (head.core.resolution == n && head.core.occupied(x, y, z));
}

std::optional<Volume> torso_volume(const TrainingSet& set, const HeadShape& shape, const Volume& head,
                                   float axis_z, const HeadMarks& marks, const VolumeOptions& options) {
  // -- How far down and to the sides the pictures reach at the torso's depth.
  const Vec3d chest(0, marks.base - 0.08, axis_z);
  Vec3f low(-0.05f, marks.chin + kShoulderTop, axis_z), high(0.05f, low.y(), axis_z);
  const std::span<const TrainingView> own = own_views(set);
  const std::size_t views = std::min<std::size_t>(own.size(), 32);
  for (std::size_t i = 0; i < views; ++i) {
    const TrainingView& view = own[i * own.size() / views];
    const Pose cam_from_torso = view.camera.cam_from_world * view.pose.world_from_torso;
    const double depth = (cam_from_torso * chest).z();
    if (depth < 0.05) continue;
    const Intrinsics& k = view.camera.intrinsics;
    for (const double u : {0.0, 1.0}) {
      const Vec3d corner = inverse(cam_from_torso) * (ray_direction(k, Vec2d(u * k.width, k.height)) * depth);
      low = low.cwiseMin(corner.cast<float>()), high.x() = std::max(high.x(), float(corner.x()));
    }
  }
  low.x() = std::max(low.x(), -0.5f), high.x() = std::min(high.x(), 0.5f);
  low.y() = std::max(low.y(), marks.base - 0.45f);
  low.z() = axis_z - 0.13f, high.z() = axis_z + 0.13f;
  if (low.y() > marks.chin) return std::nullopt;  // not even shoulders beside it

  Volume volume;
  volume.cube = cube_around(low, high);
  const int n = options.torso_resolution;
  volume.allowed = make_occupancy(n, false);
  volume.kept = make_occupancy(n, false);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const Vec3f p = volume.cube.origin + (Vec3f(float(x), float(y), float(z)) + Vec3f::Constant(0.5f)) *
                                                 (volume.cube.side / float(n));
        if (in_body(marks, axis_z, p) && !is_neck(head, marks, p))
          set_occupied(volume.allowed, x, y, z, true);
      }
  std::vector<std::uint8_t> classes(cell_count(n), kChest);
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const float y = volume.cube.origin.y() +
                    (float(i / std::size_t(n) % std::size_t(n)) + 0.5f) * volume.cube.side / float(n);
    if (y > marks.base) classes[i] = y > marks.chin + kBesideFace ? kShoulder : kCollarCell;
  }
  if (options.carve)
    carve(volume.allowed, volume.cube, torso_carve_views(set, shape, marks.chin - kBustTop, kCarveViews),
          classes, kRules);
  return volume;
}

}  // namespace

float neck_base(const HeadModel& model, const HeadShape& shape) { return head_marks(model, shape).base; }

Volumes make_volumes(const TrainingSet& set, const HeadShape& shape, const VolumeOptions& options) {
  LIKENESS_CHECK(options.head_resolution % 4 == 0 && options.torso_resolution % 4 == 0,
                 "resolutions %d and %d", options.head_resolution, options.torso_resolution);
  const HeadMarks marks = head_marks(set.model, shape);
  Volumes volumes;
  volumes.head = head_volume(set, shape, marks, options);
  std::vector<Articulation> articulations;
  for (const TrainingView& view : set.views) articulations.push_back(view.pose.articulation);
  volumes.head.still =
      still_cells(set.model, shape, articulations, volumes.head.cube, options.head_resolution);
  if (set.has_torso) {
    const float axis_z = neck_axis(set.model, shape);
    volumes.torso = torso_volume(set, shape, volumes.head, axis_z, marks, options);
    if (volumes.torso) {
      const float top = marks.chin - kNeckBelowChin;
      if (top - marks.base >= kShortestNeck)
        volumes.neck = {marks.base, top, {0, 0.5f * (marks.base + top), axis_z}};
    }
  }
  return volumes;
}

}  // namespace likeness
