// Notation: motion M = (w, t) turns the torso about a pivot at the neck's base and shifts it, in world axes;
// world_from_torso = M * world_from_head(reference). Template pixels lie on Z(x) = Z0 + bend (x - x0)^2 in
// the reference camera, the shape of a chest seen from the front. Robust Gauss-Newton, coarse to fine.
#include "core/track/torso.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/track/fit_frame.h"

namespace likeness {
namespace {

constexpr double kChestForward = 0.04;  // m, chest before the head's origin
constexpr double kBend = 1.75;          // 1/m, shoulders lie this much behind
constexpr double kHalfWidth = 0.24;     // m of body used each side
constexpr double kNeckHalf = 0.085;     // m, the neck moves with the head and is left out
constexpr double kBelowChin = 0.065;    // m, where shoulders may begin
constexpr double kLowest = 0.36;        // m below the chin: further down are hands and desks
constexpr double kNeckBelow = 0.12;     // m, where the neck ends
constexpr double kHuber = 12;           // grey levels
constexpr double kNoise = 4;            // grey levels

using Vec6 = Eigen::Matrix<double, 6, 1>;

// A float picture of one pyramid level.
struct Level {
  int width = 0, height = 0;
  double scale = 1;  // of the working picture
  std::vector<float> data;

  float at(int x, int y) const { return data[static_cast<std::size_t>(y) * width + x]; }
  // Value and slope at a place in this level's pixels (centres at +0.5); false outside.
  bool sample(double px, double py, float* value, Vec2d* slope) const {
    const double x = px - 0.5, y = py - 0.5;
    if (!(x >= 1 && y >= 1 && x < width - 2 && y < height - 2)) return false;
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    const double u = x - ix, v = y - iy;
    const double a = at(ix, iy), b = at(ix + 1, iy), c = at(ix, iy + 1), d = at(ix + 1, iy + 1);
    *value = static_cast<float>((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d));
    if (slope) *slope = {(1 - v) * (b - a) + v * (d - c), (1 - u) * (c - a) + u * (d - b)};
    return true;
  }
};

Level reduced(const Level& from) {
  Level to{from.width / 2, from.height / 2, from.scale / 2, {}};
  to.data.resize(static_cast<std::size_t>(to.width) * to.height);
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x)
      to.data[static_cast<std::size_t>(y) * to.width + x] =
          0.25f * (from.at(2 * x, 2 * y) + from.at(2 * x + 1, 2 * y) + from.at(2 * x, 2 * y + 1) +
                   from.at(2 * x + 1, 2 * y + 1));
  return to;
}

// Halves of the picture: 1/2, 1/4, 1/8. The finest holds enough for a hundredth of a pixel over so many
// pixels.
std::vector<Level> pyramid(const Image8& grey) {
  Level full{grey.width, grey.height, 1, std::vector<float>(grey.data.begin(), grey.data.end())};
  std::vector<Level> levels;
  for (int k = 0; k < 3; ++k) {
    full = reduced(full);
    levels.push_back(full);
  }
  return levels;
}

struct TemplatePixel {
  Vec3d world;  // on the torso in the reference frame
  float value;
};

struct Template {
  std::vector<std::vector<TemplatePixel>> levels;
  Vec3d pivot = Vec3d::Zero();  // world
  double picture_share = 0;     // of the picture that the torso covers
};

Template make_template(const TorsoFrame& f, const Vec3d& chin) {
  Template made;
  const Pose cam_from_head = f.cam_from_world * f.world_from_head,
             world_from_cam = f.cam_from_world.inverse();
  const Vec3d chin_cam = cam_from_head * chin;
  const double z0 = cam_from_head.translation().z() - kChestForward;
  const double x0 = cam_from_head.translation().x() / cam_from_head.translation().z() * z0;
  const double chin_y = chin_cam.y() / chin_cam.z() * z0;
  made.pivot = world_from_cam * Vec3d(x0, chin_y + kBelowChin, z0);
  for (const Level& level : pyramid(*f.grey)) {
    std::vector<TemplatePixel> pixels;
    for (int y = 2; y < level.height - 2; ++y)
      for (int x = 2; x < level.width - 2; ++x) {
        const Vec2d px((x + 0.5) / level.scale, (y + 0.5) / level.scale);
        const Vec3d ray = ray_direction(f.intrinsics, px);
        const double side = ray.x() * z0 - x0, down = ray.y() * z0 - chin_y;
        if (std::abs(side) > kHalfWidth || down > kLowest ||
            down < (std::abs(side) < kNeckHalf ? kNeckBelow : kBelowChin))
          continue;
        pixels.push_back({world_from_cam * (ray * (z0 + kBend * side * side)), level.at(x, y)});
      }
    if (made.levels.empty())
      made.picture_share =
          static_cast<double>(pixels.size()) / (static_cast<double>(level.width) * level.height);
    made.levels.push_back(std::move(pixels));
  }
  return made;
}

struct Motion {
  Vec3d turn = Vec3d::Zero(), shift = Vec3d::Zero();  // rad about the pivot, m; world axes
  double gain_offset = 0;                             // grey levels
};

Pose pose_of(const Motion& m, const Vec3d& pivot) {
  Pose pose = Pose::Identity();
  pose.linear() = turn_from_vector(m.turn);
  pose.translation() = pivot + m.shift - pose.linear() * pivot;
  return pose;
}

// Prior weights in the camera's axes: turning in the picture and shifting in it are seen well, the rest
// hardly.
struct PriorWeights {
  Vec3d turn{40, 40, 8};  // per rad, about x, y, z of the camera
  Vec3d shift{5, 5, 30};  // per m
};

double align_level(const std::vector<TemplatePixel>& pixels, const Level& level, const TorsoFrame& f,
                   const Vec3d& pivot, int iterations, Motion* motion) {
  const Mat3d to_cam = f.cam_from_world.linear();
  const PriorWeights prior;
  // Neighbouring pixels agree, so that many pixels are no many observations.
  const double trust = std::min(1.0, 600.0 / std::max<std::size_t>(1, pixels.size()));
  double mean_difference = 0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    Eigen::Matrix<double, 7, 7> hessian = Eigen::Matrix<double, 7, 7>::Zero();
    Eigen::Matrix<double, 7, 1> gradient = Eigen::Matrix<double, 7, 1>::Zero();
    const Pose move = pose_of(*motion, pivot);
    double sum = 0;
    int count = 0;
    for (const TemplatePixel& t : pixels) {
      const Vec3d world = move * t.world, p = f.cam_from_world * world;
      if (p.z() < 0.05) continue;
      const Vec2d px = project<double>(f.intrinsics, p) * level.scale;
      float value;
      Vec2d slope;
      if (!level.sample(px.x(), px.y(), &value, &slope)) continue;
      const double r = value + motion->gain_offset - t.value;
      sum += std::abs(r);
      ++count;
      const double weight = trust / (kNoise * kNoise) * (std::abs(r) <= kHuber ? 1.0 : kHuber / std::abs(r));
      const double fz = f.intrinsics.fx * level.scale / p.z();
      const Vec3d by_cam(slope.x() * fz, slope.y() * fz,
                         -(slope.x() * p.x() + slope.y() * p.y()) * fz / p.z());
      const Vec3d by_world = to_cam.transpose() * by_cam;
      Eigen::Matrix<double, 7, 1> row;
      row.head<3>() = (world - pivot - motion->shift).cross(by_world);
      row.segment<3>(3) = by_world;
      row[6] = 1;
      hessian.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
      gradient += weight * r * row;
    }
    if (count < 50) return 1e9;
    mean_difference = sum / count;
    hessian.triangularView<Eigen::StrictlyUpper>() = hessian.transpose();
    const Mat3d turn_prior = to_cam.transpose() * prior.turn.cwiseAbs2().asDiagonal() * to_cam;
    const Mat3d shift_prior = to_cam.transpose() * prior.shift.cwiseAbs2().asDiagonal() * to_cam;
    hessian.topLeftCorner<3, 3>() += turn_prior;
    hessian.block<3, 3>(3, 3) += shift_prior;
    gradient.head<3>() += turn_prior * motion->turn;
    gradient.segment<3>(3) += shift_prior * motion->shift;
    hessian(6, 6) += 1e-6;
    const Eigen::Matrix<double, 7, 1> step = -hessian.ldlt().solve(gradient);
    if (!step.allFinite()) return 1e9;
    motion->turn = vector_from_turn(turn_from_vector(step.head<3>()) * turn_from_vector(motion->turn));
    motion->shift += step.segment<3>(3);
    motion->gain_offset += step[6];
    if (step.head<3>().norm() < 2e-5 && step.segment<3>(3).norm() < 1e-5) break;
  }
  return mean_difference;
}

// The training frame whose head looks at the camera most and stands nearest to the usual place.
int reference_frame(const std::vector<TorsoFrame>& frames) {
  std::vector<double> xs[3];
  for (const TorsoFrame& f : frames)
    if (f.usable && !f.held_out)
      for (int k = 0; k < 3; ++k) xs[k].push_back(f.world_from_head.translation()[k]);
  if (xs[0].empty()) return -1;
  Vec3d usual;
  for (int k = 0; k < 3; ++k) {
    std::nth_element(xs[k].begin(), xs[k].begin() + static_cast<std::ptrdiff_t>(xs[k].size() / 2),
                     xs[k].end());
    usual[k] = xs[k][xs[k].size() / 2];
  }
  int best = -1;
  double least = 1e30;
  const Mat3d facing = Vec3d(1, -1, -1).asDiagonal();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const TorsoFrame& f = frames[i];
    if (!f.usable || f.held_out) continue;
    const Mat3d turn = (f.cam_from_world * f.world_from_head).linear() * facing.transpose();
    const double score = vector_from_turn(turn).norm() + 4 * (f.world_from_head.translation() - usual).norm();
    if (score < least) least = score, best = static_cast<int>(i);
  }
  return best;
}

}  // namespace

Result<TorsoTrack> track_torso(const std::vector<TorsoFrame>& frames, const Vec3d& chin,
                               const Progress& progress, std::stop_token stop) {
  TorsoTrack track;
  track.world_from_torso.assign(frames.size(), Pose::Identity());
  track.reference = reference_frame(frames);
  if (track.reference < 0) return track;
  const TorsoFrame& reference = frames[track.reference];
  track.world_from_torso.assign(frames.size(), reference.world_from_head);
  const Template body = make_template(reference, chin);
  track.has_torso = body.picture_share > 0.02;
  if (!track.has_torso) return track;

  std::vector<std::optional<Motion>> motions(frames.size());
  std::optional<Motion> last_training, last;
  double before = 0, after = 0;
  int counted = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (stop.stop_requested()) return cancelled_error();
    if (i % 8 == 0) progress.report(static_cast<double>(i) / frames.size(), "following the torso");
    const TorsoFrame& f = frames[i];
    if (!f.usable) continue;
    const std::vector<Level> levels = pyramid(*f.grey);
    Motion motion = (f.held_out ? last : last_training).value_or(Motion{});
    Motion still;
    const double unmoved = align_level(body.levels[1], levels[1], f, body.pivot, 1, &still);
    double difference = 0;
    for (int level = 2; level >= 0; --level)
      difference =
          align_level(body.levels[level], levels[level], f, body.pivot, level == 0 ? 6 : 10, &motion);
    // A motion that no body makes in a picture that still shows the head: keep the last good one.
    if (difference > 1e8 || motion.shift.norm() > 0.5 || motion.turn.norm() > 0.7) continue;
    motions[i] = motion;
    last = motion;
    if (!f.held_out) last_training = motion;
    before += unmoved, after += difference, ++counted;
  }
  if (counted > 0) track.residual_before = before / counted, track.residual_after = after / counted;

  // -- Slight smoothing; training frames among themselves, held-out frames stay their own.
  static constexpr double kKernel[5] = {1, 3, 4, 3, 1};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Motion smooth;
    double weight = 0;
    for (int k = -2; k <= 2; ++k) {
      const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + k;
      if (j < 0 || j >= static_cast<std::ptrdiff_t>(frames.size()) || !motions[j]) continue;
      if (frames[i].held_out ? k != 0 : frames[j].held_out) continue;
      smooth.turn += kKernel[k + 2] * motions[j]->turn;
      smooth.shift += kKernel[k + 2] * motions[j]->shift;
      weight += kKernel[k + 2];
    }
    if (weight == 0) {  // nothing near: the torso stays where it was seen last
      for (std::size_t j = i; j-- > 0 && weight == 0;)
        if (motions[j] && (frames[i].held_out || !frames[j].held_out)) smooth = *motions[j], weight = 1;
      if (weight == 0) continue;
    }
    smooth.turn /= weight;
    smooth.shift /= weight;
    track.world_from_torso[i] = pose_of(smooth, body.pivot) * reference.world_from_head;
  }
  progress.report(1);
  return track;
}

}  // namespace likeness
